// SPDX-License-Identifier: Apache-2.0
// OpenNI2's own stand-in for a camera ("Dummy"), live and recorded.
#include "compare_records.h"
#include "environment_variable.h"
#include "program.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <vector>

#include "knuckle/core/text_file.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;

constexpr int kDummyWidth = 320;
constexpr int kDummyHeight = 240;

template <class Plain>
void append(std::string& bytes, const Plain& plain) {
  bytes.append(reinterpret_cast<const char*>(&plain), sizeof plain);
}

/// What "Dummy" records lacks a property that OpenNI2 needs to play it. It takes the place of another that
/// has as many bytes and is not needed.
void add_cropping(std::string& oni) {
  std::string record("NIR\0", 4);
  for (const std::uint32_t number : {6U, 1U, 59U, 0U})
    append(record, number);  // a property, of node 1, its size
  append(record, std::uint64_t{0});
  append(record, std::uint32_t{11});
  record.append("xnCropping\0", 11);
  append(record, std::uint32_t{12});
  record.append(12, '\0');  // off
  constexpr std::size_t kBeforeItsName = 32;
  const std::size_t place = oni.find("xnIsGenerating") - kBeforeItsName;
  ASSERT_EQ(oni.substr(place, 3), "NIR");
  oni.replace(place, record.size(), record);
}

/// A frame as it came while it was recorded.
struct FrameThatCame {
  double time_s;  ///< by the device's clock
  Image<float> depth_mm;
};

class Openni2Test : public ::testing::Test {
 protected:
  void SetUp() override {
#ifdef KNUCKLE_ONI_RECORDER
    const std::string command =
        fmt::format("'{}' '{}' '{}' {}", KNUCKLE_ONI_RECORDER, path("dummy.oni"), path("dummy.raw"), kFrames);
    ASSERT_EQ(std::system(command.c_str()), 0);
    oni_ = read_text_file(folder_ / "dummy.oni");
    add_cropping(oni_);
    write_text_file(folder_ / "take.oni", oni_);
#else
    GTEST_SKIP() << "OpenNI2 is missing";
#endif
  }

  std::string path(const std::string& name) const {
    return folder_ / name;
  }
  std::string take(const std::string& settings = "") const {
    return "oni:" + path("take.oni") + "?fov_deg=60" + settings;
  }
  std::vector<FrameThatCame> frames_that_came() const {
    const std::string raw = read_text_file(folder_ / "dummy.raw");
    Image<std::uint16_t> counts(kDummyWidth, kDummyHeight);
    const std::size_t pixel_bytes = 2 * counts.size();
    std::vector<FrameThatCame> frames;
    for (std::size_t place = 0; place < raw.size(); place += 8 + pixel_bytes) {
      std::uint64_t time_us = 0;
      std::memcpy(&time_us, raw.data() + place, sizeof time_us);
      std::memcpy(counts.data(), raw.data() + place + 8, pixel_bytes);
      FrameThatCame frame{1e-6 * static_cast<double>(time_us), Image<float>(kDummyWidth, kDummyHeight)};
      std::ranges::copy(counts.pixels(), frame.depth_mm.data());
      frames.push_back(std::move(frame));
    }
    return frames;
  }

  static constexpr int kFrames = 40;
  TemporaryFolder folder_{};
  std::string oni_;
};

TEST_F(Openni2Test, ARecordingHoldsTheFramesThatCame) {
  const auto source = open_source(take());
  std::vector<Frame> recorded;
  for (std::int64_t i = 0; i < source->size(); ++i) recorded.push_back(source->read(i));
  // On a busy machine the recorder misses frames, and so does whoever watches it.
  int found = 0;
  std::optional<double> offset_s;
  for (const FrameThatCame& frame : frames_that_came()) {
    const auto same = std::ranges::find(recorded, frame.depth_mm, &Frame::depth_mm);
    if (same == recorded.end()) continue;
    ++found;
    if (!offset_s) offset_s = frame.time_s - same->time_s.value();
    EXPECT_NEAR(frame.time_s - same->time_s.value(), *offset_s, 1e-4);
  }
  EXPECT_GT(found, kFrames / 2);
  EXPECT_NE(recorded[0].depth_mm, recorded[1].depth_mm) << "else the test shows little";
}

TEST_F(Openni2Test, ARecordingIsASourceForAllVerbs) {
  EXPECT_THAT(run_program({"inspect", "--source", take()}).out, HasSubstr("320 x 240 px"));
  ASSERT_THAT(
      run_program({"record", "--source", take("&first=2&count=3&rate=100"), "--out", path("part.h5")}),
      Succeeded());
  const auto whole = open_source(take());
  const auto part = open_source("h5:" + path("part.h5"));
  ASSERT_EQ(part->size(), 3);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(part->read(i).depth_mm, whole->read(2 + i).depth_mm);
  EXPECT_THAT(run_program({"inspect", "--source", "oni:" + path("take.oni")}),
              FailedWith("take.oni: its intrinsics are not known"));
}

TEST_F(Openni2Test, DamagedRecordingsAreErrors) {
  EXPECT_THAT(run_program({"inspect", "--source", "oni:" + path("none.oni")}), FailedWith("none.oni"));
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{20}, std::size_t{700}, oni_.size() / 4}) {
    write_text_file(folder_ / "damaged.oni", oni_.substr(0, bytes));
    EXPECT_THAT(run_program({"inspect", "--source", "oni:" + path("damaged.oni") + "?fov_deg=60"}),
                FailedWith("damaged.oni: cannot be opened"));
  }
  write_text_file(folder_ / "damaged.oni", "an essay on hands");
  EXPECT_THAT(run_program({"inspect", "--source", "oni:" + path("damaged.oni") + "?fov_deg=60"}),
              FailedWith("is it an .oni recording"));
}

TEST_F(Openni2Test, ADamagedByteIsAnErrorOrNoMatter) {
  std::uint32_t seed = 12345;
  for (int i = 0; i < 12; ++i) {
    seed = seed * 1664525U + 1013904223U;
    std::string damaged = oni_;
    damaged[seed % 3000] ^= static_cast<char>(1U << (seed >> 29));  // headers, and the first frame
    write_text_file(folder_ / "damaged.oni", damaged);
    const ProgramRun run = run_program({"inspect", "--source", "oni:" + path("damaged.oni") + "?fov_deg=60"});
    if (run.status != 0) {
      EXPECT_THAT(run, FailedWith("damaged.oni"));
    }
  }
}

TEST_F(Openni2Test, DummyIsACamera) {
  constexpr int kTaken = 10;
  ASSERT_THAT(run_program({"record", "--source", "openni2:Dummy?fov_deg=60", "--out", path("live.h5"),
                           "--frames", std::to_string(kTaken)}),
              Succeeded());
  const auto taken = open_source("h5:" + path("live.h5"));
  ASSERT_EQ(taken->size(), kTaken);
  EXPECT_EQ(taken->read(0).time_s, 0.0);
  const std::vector<FrameThatCame> drawn = frames_that_came();
  int known = 0;
  double before = -1.0;
  for (int i = 0; i < kTaken; ++i) {
    const Frame frame = taken->read(i);
    // It draws the same frames from its start on, of which a busy machine misses some.
    known += std::ranges::find(drawn, frame.depth_mm, &FrameThatCame::depth_mm) == drawn.end() ? 0 : 1;
    EXPECT_GT(frame.time_s.value(), before);
    before = frame.time_s.value();
  }
  EXPECT_GT(known, 0);
}

/// "Dummy" draws no hand: the pipeline takes whatever is nearest for one.
TEST_F(Openni2Test, LiveFindsInTheDeviceWhatItFindsInItsRecording) {
  write_text_file(folder_ / "any.toml", fmt::format("[hand]\nsure_confidence = 0.0\n[segmentation]\nmethod = "
                                                    "\"threshold\"\n[patch]\nmode = \"cube\"\nsize_px = "
                                                    "96\ncube_mm = 250.0\n[estimator]\nmethod = "
                                                    "\"dense\"\nmodel = \"{}\"\n",
                                                    std::filesystem::absolute("models/dense.pt").string()));
  ASSERT_THAT(run_program({"live", "--source", "openni2:Dummy?fov_deg=60", "--pipeline", path("any.toml"),
                           "--frames", "20", "--records", path("live.jsonl"), "--record", path("live.h5")}),
              Succeeded());
  ASSERT_THAT(run_program({"estimate", "--source", take(), "--pipeline", path("any.toml"), "--out",
                           path("poses.txt"), "--records", path("take.jsonl")}),
              Succeeded());
  const auto taken = open_source("h5:" + path("live.h5"));
  const auto recorded = open_source(take());
  std::vector<FrameRecord> of_device;
  for (FrameRecord& record : read_records(folder_ / "live.jsonl")) {
    // The device draws the same frames from its start on, of which a busy machine misses some.
    const Image<float> depth = taken->read(record.frame).depth_mm;
    for (std::int64_t i = 0; i < recorded->size(); ++i) {
      if (recorded->read(i).depth_mm != depth) continue;
      record.frame = i;
      of_device.push_back(std::move(record));
      break;
    }
  }
  ASSERT_FALSE(of_device.empty());
  expect_records_of_file(of_device, read_records(folder_ / "take.jsonl"));
}

TEST_F(Openni2Test, FaultsAreOneLine) {
  const std::string out = path("x.h5");
  EXPECT_THAT(run_program({"record", "--source", "openni2:Dummy", "--out", out}),
              FailedWith("openni2:Dummy: its intrinsics are not known"));
  EXPECT_THAT(run_program({"record", "--source", "openni2:nothing@1?fov_deg=60", "--out", out}),
              FailedWith("openni2:nothing@1?fov_deg=60: cannot be opened"));
  EXPECT_THAT(run_program({"record", "--source", "openni2:Dummy?width=9&height=9&fov_deg=60", "--out", out}),
              FailedWith("does not offer 9x9; it offers 320x240 at 30"));
  EXPECT_THAT(
      run_program({"record", "--source", "openni2:" + path("take.oni") + "?fov_deg=60", "--out", out}),
      FailedWith("read it as oni:FILE"));
  EXPECT_THAT(run_program({"cameras", "--check", "openni2:Dummy", "--frames", "5"}).out,
              HasSubstr("320 x 240 px"));
}

}  // namespace
}  // namespace knuckle::testing
