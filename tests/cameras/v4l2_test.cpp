// SPDX-License-Identifier: Apache-2.0
// Cameras of Video4Linux, played to the program by a library that answers for the kernel (fake_v4l2.cpp).
#include "compare_records.h"
#include "environment_variable.h"
#include "program.h"

#include <map>

#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/folder_format.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kDemo = "synthetic:manifests/demo.toml";
constexpr const char* kPath = "/dev/video42";

std::string bytes_of(const Image<std::uint16_t>& image) {
  std::string bytes;
  for (const std::uint16_t value : image.pixels()) {
    bytes += static_cast<char>(value & 0xFF);
    bytes += static_cast<char>(value >> 8);
  }
  return bytes;
}

class V4l2Test : public ::testing::Test {
 protected:
  V4l2Test() : demo_(open_source(kDemo)) {
    camera_ = demo_->read(0).camera;
    FolderDescription description;
    description.camera = camera_;
    write_text_file(folder_ / "camera.toml", folder_description_as_toml(description));
    settings_ = {{"device", kPath},
                 {"frames", path("frames")},
                 {"sizes", fmt::format("848x480,{}x{}", camera_.width, camera_.height)}};
  }

  std::string path(const std::string& name) const { return folder_ / name; }
  std::string camera(const std::string& settings = "") const {
    return fmt::format("v4l2:{}?camera={}{}", kPath, path("camera.toml"), settings);
  }
  Image<std::uint16_t> counts(std::int64_t index) const {
    return counts_from_depth(demo_->read(index).depth_mm, 1.0, "demo");
  }
  /// The device sends the depth of these frames of the demo, in millimetres.
  void send(int count) {
    std::string bytes;
    for (int i = 0; i < count; ++i) bytes += bytes_of(counts(i));
    write_text_file(folder_ / "frames", bytes);
  }
  ProgramRun run(const std::vector<std::string>& arguments, const std::function<bool()>& is_time = {}) {
    std::string text;
    for (const auto& [key, value] : settings_) text += fmt::format("{} {}\n", key, value);
    write_text_file(folder_ / "scenario", text);
    const EnvironmentVariable scenario("KNUCKLE_FAKE_V4L2", path("scenario"));
    const EnvironmentVariable library("LD_PRELOAD", KNUCKLE_FAKE_V4L2);
    const EnvironmentVariable sanitizer("ASAN_OPTIONS", sanitizer_beside_a_library());
    return run_program_until(is_time, arguments, SIGINT);
  }
  ProgramRun record(int frames, const std::string& settings = "") {
    return run({"record", "--source", camera(settings), "--out", path("take.h5"), "--frames",
                std::to_string(frames)});
  }
  ProgramRun fail_to_record(const std::string& source) {
    return run({"record", "--source", source, "--out", path("none.h5"), "--frames", "1"});
  }
  std::unique_ptr<FrameSource> take() const { return open_source("h5:" + path("take.h5")); }

  TemporaryFolder folder_;
  std::unique_ptr<FrameSource> demo_;
  Camera camera_;
  std::map<std::string, std::string> settings_;
};

TEST_F(V4l2Test, WhatTheDeviceGivesIsRecordedToTheBit) {
  settings_["padding"] = "6";
  send(8);
  ASSERT_THAT(record(8), Succeeded());
  const auto recorded = take();
  ASSERT_EQ(recorded->size(), 8);
  for (int i = 0; i < 8; ++i) {
    const Frame frame = recorded->read(i);
    EXPECT_EQ(frame.depth_mm, depth_from_counts(counts(i), 1.0)) << i;
    EXPECT_EQ(frame.camera, camera_);
    EXPECT_NEAR(frame.time_s.value(), 0.02 * i, 1e-5) << "the device's times, to its microsecond";
  }
}

TEST_F(V4l2Test, LiveFindsInThemWhatItFindsInTheSameFilesFrames) {
  send(8);
  settings_["interval_ms"] = "300";
  ASSERT_THAT(run({"live", "--source", camera(), "--pipeline", "pipelines/free_hand.toml", "--records",
                   path("live.jsonl"), "--record", path("take.h5"), "--frames", "4"}),
              Succeeded());
  ASSERT_THAT(
      run_program({"estimate", "--source", "h5:" + path("take.h5"), "--pipeline", "pipelines/free_hand.toml",
                   "--out", path("poses.txt"), "--records", path("file.jsonl")}),
      Succeeded());
  const std::vector<FrameRecord> live = read_records(folder_ / "live.jsonl");
  for (const FrameRecord& record : live)
    EXPECT_EQ(take()->read(record.frame).depth_mm, depth_from_counts(counts(record.frame), 1.0));
  expect_records_of_file(live, read_records(folder_ / "file.jsonl"));
}

TEST_F(V4l2Test, InziGivesInfraredAsWell) {
  settings_["formats"] = "YUYV,INZI";
  settings_["images"] = "2";
  const Image<std::uint16_t> infrared(camera_.width, camera_.height, 517);
  write_text_file(folder_ / "frames", bytes_of(infrared) + bytes_of(counts(0)));
  ASSERT_THAT(record(1), Succeeded());
  EXPECT_EQ(take()->read(0).depth_mm, depth_from_counts(counts(0), 0.125));
  EXPECT_EQ(take()->read(0).infrared, infrared);
}

TEST_F(V4l2Test, TheUnitAndTheRateCanBeSaid) {
  settings_["rates"] = "30,60";
  send(1);
  ASSERT_THAT(record(1, "&depth_unit_mm=0.1&rate=60"), Succeeded());
  EXPECT_EQ(take()->read(0).depth_mm, depth_from_counts(counts(0), 0.1));
  EXPECT_THAT(fail_to_record(camera("&rate=90")), FailedWith("does not offer 90 frames per second"));
  EXPECT_THAT(fail_to_record(camera("&rate=90")), FailedWith("it offers 30, 60"));
}

TEST_F(V4l2Test, FramesThatWereDroppedAreCounted) {
  settings_["lose"] = "2,3";
  settings_["damage"] = "5";
  send(8);
  const ProgramRun run = record(5);
  ASSERT_EQ(run.status, 0) << run.error;
  EXPECT_THAT(run.error, HasSubstr("warning: the camera lost 3 frames on the way"));
  ASSERT_EQ(take()->size(), 5);
  const std::vector<int> expected{0, 1, 4, 6, 7};
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(take()->read(i).depth_mm, depth_from_counts(counts(expected[i]), 1.0)) << i;
    EXPECT_NEAR(take()->read(i).time_s.value(), 0.02 * expected[i], 1e-5);
  }
}

TEST_F(V4l2Test, UnpluggedItIsOneLineAndWhatCameIsKept) {
  settings_["end"] = "unplug";
  send(3);
  EXPECT_THAT(record(0), FailedWith("v4l2:/dev/video42: the camera was unplugged"));
  EXPECT_EQ(take()->size(), 3);
  EXPECT_THAT(run({"live", "--source", camera(), "--pipeline", "pipelines/free_hand.toml", "--records", "-"}),
              AllOf(::testing::Field(&ProgramRun::status, 1),
                    ::testing::Field(&ProgramRun::error,
                                     HasSubstr("knuckle: v4l2:/dev/video42: the camera was unplugged\n"))));
}

TEST_F(V4l2Test, ACameraThatComesBackGoesOnInANewSequence) {
  settings_["end"] = "unplug";
  settings_["back_after_ms"] = "300";
  send(3);
  ASSERT_THAT(record(5, "&wait_s=20"), Succeeded());
  const auto recorded = take();
  ASSERT_EQ(recorded->size(), 5);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(recorded->read(i).depth_mm, depth_from_counts(counts(i % 3), 1.0));
    EXPECT_EQ(recorded->read(i).sequence, i / 3);
  }
  EXPECT_GE(recorded->read(3).time_s.value(), recorded->read(2).time_s.value() + 0.25);
}

TEST_F(V4l2Test, ACameraThatDoesNotComeBackIsLost) {
  settings_["end"] = "unplug";
  send(2);
  EXPECT_THAT(record(0, "&wait_s=0.5"), FailedWith("it was lost, and did not come back within 0.5 s"));
  EXPECT_EQ(take()->size(), 2);
}

TEST_F(V4l2Test, ACameraThatComesBackWithOtherImagesIsLost) {
  settings_["sizes"] = fmt::format("{}x{}", camera_.width, camera_.height);
  settings_["end"] = "unplug";
  settings_["back_after_ms"] = "50";
  settings_["back_sizes"] = "64x48";
  send(2);
  EXPECT_THAT(run({"record", "--source", fmt::format("v4l2:{}?fov_deg=70&wait_s=20", kPath), "--out",
                   path("take.h5"), "--frames", "5"}),
              FailedWith(fmt::format("v4l2:/dev/video42: came back with images of 64x48, had {}x{}",
                                     camera_.width, camera_.height)));
  EXPECT_EQ(take()->size(), 2);
}

TEST_F(V4l2Test, ACameraThatStopsSendingIsLost) {
  send(2);
  EXPECT_THAT(record(0, "&timeout_s=0.3"), FailedWith("has sent no whole frame for 0.3 s"));
  EXPECT_EQ(take()->size(), 2);
}

TEST_F(V4l2Test, ThatSendsNothingWholeSaysSo) {
  send(1);
  settings_["damage"] = "0";
  EXPECT_THAT(record(0, "&timeout_s=0.3"), FailedWith("has sent no whole frame for 0.3 s"));
  EXPECT_FALSE(std::filesystem::exists(path("take.h5")));
}

TEST_F(V4l2Test, CtrlCEndsItCleanly) {
  send(20);
  settings_["interval_ms"] = "10";
  const std::string partial = path("take.h5.partial");
  const auto has_begun = [&] {
    return std::filesystem::exists(partial) && std::filesystem::file_size(partial) > 1000;
  };
  // 20 frames come, then none: Ctrl-C has to end the waiting.
  const ProgramRun ended =
      run({"record", "--source", camera("&timeout_s=600"), "--out", path("take.h5")}, has_begun);
  EXPECT_THAT(ended, Succeeded());
  EXPECT_GE(take()->size(), 1);
  EXPECT_EQ(take()->read(0).depth_mm, depth_from_counts(counts(0), 1.0));
}

TEST_F(V4l2Test, WhatCannotBeOpenedSaysWhatToDo) {
  send(1);
  const auto fault_at_opening = [&](int error) {
    settings_["open_error"] = std::to_string(error);
    return fail_to_record(camera());
  };
  EXPECT_THAT(fault_at_opening(EACCES), FailedWith("add the user to the group video"));
  EXPECT_THAT(fault_at_opening(EBUSY), FailedWith("another program uses it"));
  EXPECT_THAT(fault_at_opening(ENODEV), FailedWith("is it plugged in?"));
  settings_["open_error"] = "0";
  settings_["start_error"] = std::to_string(EBUSY);
  EXPECT_THAT(fail_to_record(camera()),
              FailedWith("v4l2:/dev/video42: cannot be started: another program uses it"));
  EXPECT_THAT(fail_to_record("v4l2:/dev/video43"),
              FailedWith("v4l2:/dev/video43: cannot be opened: the camera is not there"));
  EXPECT_THAT(fail_to_record("v4l2:" + path("camera.toml")), FailedWith("is not a video device"));
  EXPECT_THAT(fail_to_record("v4l2:/dev"), FailedWith("v4l2:/dev: cannot be opened"));
  EXPECT_THAT(fail_to_record("v4l2:"), FailedWith("names no device"));
  settings_["no_capture"] = "1";
  settings_["start_error"] = "0";
  EXPECT_THAT(fail_to_record(camera()), FailedWith("does not capture images"));
  settings_["planes"] = "1";
  EXPECT_THAT(fail_to_record(camera()), FailedWith("captures images in several planes of memory"));
  EXPECT_FALSE(std::filesystem::exists(path("none.h5")));
}

TEST_F(V4l2Test, WhatItDoesNotOfferIsSaidWithWhatItDoes) {
  send(1);
  EXPECT_THAT(fail_to_record(fmt::format("v4l2:{}?width=500&height=400&fov_deg=70", kPath)),
              FailedWith("does not offer Z16 of 500x400; it offers 848x480, "));
  EXPECT_THAT(fail_to_record(camera("&format=inzi")),
              FailedWith("does not offer the format inzi; it offers Z16"));
  EXPECT_THAT(fail_to_record(camera("&format=rgb")), FailedWith("known are auto, z16, inzi, y16"));
  EXPECT_THAT(fail_to_record(camera("&width=500")), FailedWith("width and height belong together"));
  EXPECT_THAT(fail_to_record(camera("&width=848&height=480")),
              FailedWith("848x480 is asked for, but the camera of"));
  settings_["fixed_rate"] = "1";
  EXPECT_THAT(fail_to_record(camera("&rate=30")), FailedWith("does not let its rate be chosen"));
  settings_["formats"] = "YUYV,MJPG";
  EXPECT_THAT(fail_to_record(camera()),
              FailedWith("does not offer depth (Z16 or INZI); it offers YUYV, MJPG"));
  settings_["formats"] = "YUYV,Y16";
  EXPECT_THAT(fail_to_record(camera()), FailedWith("say ?format=y16 where it is depth"));
  ASSERT_THAT(record(1, "&format=y16"), Succeeded());
  EXPECT_EQ(take()->read(0).depth_mm, depth_from_counts(counts(0), 1.0));
}

TEST_F(V4l2Test, ADeviceWhoseNumbersCannotBeIsRefused) {
  send(1);
  const auto fault_with = [&](const std::string& key, const std::string& value) {
    settings_[key] = value;
    ProgramRun run = fail_to_record(camera());
    settings_.erase(key);
    return run;
  };
  EXPECT_THAT(fault_with("row_bytes", "3"), FailedWith("(3 per row), which cannot be"));
  EXPECT_THAT(fault_with("row_bytes", "1000000"), FailedWith("(1000000 per row), which cannot be"));
  EXPECT_THAT(fault_with("image_bytes", "100"), FailedWith(" in 100 bytes"));
  EXPECT_THAT(fault_with("buffers", "1"), FailedWith("gives 1 buffers, expected 2 to 64"));
  EXPECT_THAT(fault_with("buffers", "65"), FailedWith("gives 65 buffers, expected 2 to 64"));
  EXPECT_THAT(fault_with("buffer_bytes", "100"), FailedWith("gives buffers of 100 bytes for frames of"));
}

TEST_F(V4l2Test, IntrinsicsHaveToBeKnown) {
  settings_["sizes"] = fmt::format("{}x{}", camera_.width, camera_.height);
  send(1);
  EXPECT_THAT(fail_to_record(fmt::format("v4l2:{}", kPath)),
              FailedWith("its intrinsics are not known; say them by ?camera=FILE.toml"));
  EXPECT_THAT(fail_to_record(camera("&first=3")), FailedWith("first, count and step are for recordings"));
  ASSERT_THAT(run({"record", "--source", fmt::format("v4l2:{}?fov_deg=87", kPath), "--out", path("take.h5"),
                   "--frames", "1"}),
              Succeeded());
  EXPECT_DOUBLE_EQ(take()->read(0).camera.cx, (camera_.width - 1) / 2.0);
  EXPECT_THAT(run_program({"inspect", "--source", camera()}),
              FailedWith("is a camera, for `live` and `record`"));
}

TEST_F(V4l2Test, CamerasListsWhatIsConnected) {
  settings_["formats"] = "YUYV,Z16";
  settings_["card"] = "Depth\tcamera";
  ProgramRun listed = run({"cameras"});
  ASSERT_THAT(listed, Succeeded());
  EXPECT_THAT(listed.out, HasSubstr("v4l2:/dev/video42"));
  EXPECT_THAT(listed.out, HasSubstr("Depth\\tcamera"));
  EXPECT_THAT(listed.out, HasSubstr(" Z16\n"));
  EXPECT_THAT(listed.out, Not(HasSubstr("no depth camera is connected")));
  settings_["formats"] = "YUYV";
  listed = run({"cameras"});
  EXPECT_THAT(listed.out, AllOf(HasSubstr(" no depth\n"), HasSubstr("no depth camera is connected")));
  settings_["open_error"] = std::to_string(EACCES);
  listed = run({"cameras"});
  ASSERT_THAT(listed, Succeeded());
  EXPECT_THAT(listed.out, HasSubstr("add the user to the group video"));
}

TEST_F(V4l2Test, ACheckSaysHowGoodItIs) {
  send(8);
  settings_["end"] = "stall";
  ProgramRun checked = run({"cameras", "--check", camera(), "--frames", "8"});
  ASSERT_THAT(checked, Succeeded());
  EXPECT_THAT(checked.out, HasSubstr(fmt::format("frames       8, {} x {} px, 50.0 per second, 0 lost",
                                                 camera_.width, camera_.height)));
  EXPECT_THAT(checked.out, HasSubstr("format       Z16 "));
  EXPECT_THAT(checked.out, HasSubstr("intrinsics   from "));
  settings_["sizes"] = fmt::format("{}x{}", camera_.width, camera_.height);
  checked = run({"cameras", "--check", fmt::format("v4l2:{}?depth_unit_mm=100", kPath), "--frames", "3"});
  ASSERT_EQ(checked.status, 0);
  EXPECT_THAT(checked.out, HasSubstr("intrinsics   not known"));
  EXPECT_THAT(checked.error,
              HasSubstr("warning: its intrinsics are not known: say them by ?camera=FILE.toml"));
  EXPECT_THAT(checked.error, HasSubstr("is the unit wrong?"));
  EXPECT_THAT(run({"cameras", "--check", camera("&timeout_s=0.2"), "--frames", "20"}),
              FailedWith("has sent no whole frame"));
  EXPECT_THAT(run({"cameras", "--check", "webcam:0"}), FailedWith("unknown kind of camera 'webcam'"));
}

}  // namespace
}  // namespace knuckle::testing
