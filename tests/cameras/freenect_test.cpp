// SPDX-License-Identifier: Apache-2.0
// A Kinect, played to libfreenect's users by its own stand-in (fakenect) from a recording that we write.
#include "compare_records.h"
#include "environment_variable.h"
#include "program.h"

#include <cmath>

#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/folder_format.h"
#include "knuckle/data/readers/kinect_depth.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;

/// The raw value whose depth is nearest; 2047 where nothing is measured.
std::uint16_t raw_of(float depth_mm) {
  if (!(depth_mm > 0.0f)) return 2047;
  const double raw = 2842.5 * (std::atan(depth_mm / 123.6) - 1.1863);
  return static_cast<std::uint16_t>(std::clamp(std::lround(raw), 0L, 2046L));
}

/// The demo's hand as a Kinect would see it: 640x480, raw.
std::string kinect_image(const Image<float>& depth_mm) {
  std::string bytes = "P5 640 480 65535\n";
  for (int row = 0; row < 480; ++row) {
    for (int column = 0; column < 640; ++column) {
      const std::uint16_t raw = raw_of(depth_mm(column / 2, row / 2));
      bytes += static_cast<char>(raw & 0xFF);
      bytes += static_cast<char>(raw >> 8);
    }
  }
  return bytes;
}

class FreenectTest : public ::testing::Test {
 protected:
  void SetUp() override {
#ifndef KNUCKLE_FAKENECT
    GTEST_SKIP() << "libfreenect, or its stand-in fakenect, is missing";
#endif
    const auto demo = open_source("synthetic:manifests/demo.toml");
    make_folder(folder_ / "take");
    std::string index;
    for (int i = 0; i < kFrames; ++i) {
      // Their clock starts again at 0 within the recording.
      const std::uint32_t ticks = 4294967295U - 20000000U + 18000000U * static_cast<std::uint32_t>(i);
      const std::string name = fmt::format("d-{:.6f}-{}.pgm", 1300000000.0 + 0.3 * i, ticks);
      write_text_file(folder_ / "take" / name, kinect_image(demo->read(i).depth_mm));
      index += name + "\n";
    }
    write_text_file(folder_ / "take" / "INDEX.txt", index);
    FolderDescription description;
    description.camera = demo->read(0).camera;
    for (double* const focal_length : {&description.camera.fx, &description.camera.fy}) *focal_length *= 2.0;
    for (double* const centre : {&description.camera.cx, &description.camera.cy})
      *centre = 2.0 * *centre + 0.5;
    description.camera.width = 640;
    description.camera.height = 480;
    write_text_file(folder_ / "camera.toml", folder_description_as_toml(description));
  }

  std::string path(const std::string& name) const {
    return folder_ / name;
  }
  std::string camera() const {
    return "?camera=" + path("camera.toml");
  }
  ProgramRun run(const std::vector<std::string>& arguments) const {
#ifdef KNUCKLE_FAKENECT
    const EnvironmentVariable library("LD_LIBRARY_PATH", KNUCKLE_FAKENECT);
#endif
    const EnvironmentVariable recording("FAKENECT_PATH", path("take"));
    return run_program(arguments);
  }

  static constexpr int kFrames = 5;
  TemporaryFolder folder_{};
};

TEST_F(FreenectTest, GivesWhatTheRecordingHolds) {
  ASSERT_THAT(
      run({"record", "--source", "freenect:", "--out", path("take.h5"), "--frames", std::to_string(kFrames)}),
      Succeeded());
  const auto read = open_source("fakenect:" + path("take"));
  const auto taken = open_source("h5:" + path("take.h5"));
  ASSERT_EQ(taken->size(), kFrames);
  for (int i = 0; i < kFrames; ++i) {
    const Frame frame = taken->read(i);
    const Image<float> expected = read->read(i).depth_mm;
    // A recording rounds to a tenth of a millimetre what is no multiple of one.
    for (std::size_t pixel = 0; pixel < frame.depth_mm.size(); ++pixel)
      ASSERT_NEAR(frame.depth_mm.data()[pixel], expected.data()[pixel], 0.0501f);
    EXPECT_EQ(frame.camera, kinect_camera());
    EXPECT_NEAR(frame.time_s.value(), 0.3 * i, 1e-6) << "by the Kinect's clock, which starts again at 0";
  }
}

TEST_F(FreenectTest, LiveFindsThePosesThatTheRecordingGives) {
  const std::string pipeline = "pipelines/free_hand.toml";
  // After its last frame fakenect behaves as a Kinect that is unplugged.
  ASSERT_THAT(run({"live", "--source", "freenect:0" + camera(), "--pipeline", pipeline, "--records",
                   path("live.jsonl")}),
              FailedWith("freenect:0"));
  ASSERT_THAT(run_program({"estimate", "--source", "fakenect:" + path("take") + camera(), "--pipeline",
                           pipeline, "--out", path("poses.txt"), "--records", path("file.jsonl")}),
              Succeeded());
  expect_records_of_file(read_records(folder_ / "live.jsonl"), read_records(folder_ / "file.jsonl"));
}

TEST_F(FreenectTest, IsListedAndChecked) {
  const ProgramRun listed = run({"cameras"});
  ASSERT_THAT(listed, Succeeded());
  EXPECT_THAT(listed.out, HasSubstr("freenect:0 "));
  const ProgramRun checked = run({"cameras", "--check", "freenect:0", "--frames", "3"});
  ASSERT_THAT(checked, Succeeded());
  EXPECT_THAT(checked.out, HasSubstr("640 x 480 px, 3.3 per second"));
  EXPECT_THAT(checked.out, HasSubstr("measured by N. Burrus for another Kinect"));
}

TEST_F(FreenectTest, FaultsAreOneLine) {
  EXPECT_THAT(run_program({"record", "--source", "freenect:7", "--out", path("x.h5")}),
              FailedWith("freenect:7: "));
  EXPECT_THAT(run({"record", "--source", "freenect:7", "--out", path("x.h5")}),
              FailedWith("freenect:7: there is no such Kinect, 1 are connected"));
  EXPECT_THAT(run_program({"record", "--source", "freenect:first", "--out", path("x.h5")}),
              FailedWith("first"));
  EXPECT_THAT(run_program({"record", "--source", "freenect:0?depth=inch", "--out", path("x.h5")}),
              FailedWith("known are raw, mm"));
}

}  // namespace
}  // namespace knuckle::testing
