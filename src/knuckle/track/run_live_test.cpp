// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/run_live.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "knuckle/core/interruption.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;

/// Frames 0, 1, 2, ... when `next` is called; what happens then is told.
class CountingStream final : public FrameStream {
 public:
  CountingStream(int size, std::function<void(int)> before) : size_(size), before_(std::move(before)) {}
  std::optional<Frame> next() override {
    if (count_ == size_) return std::nullopt;
    const int number = count_++;
    before_(number);
    Frame frame = testing::blank_frame(testing::quarter_vga_camera());
    std::ranges::fill(frame.depth_mm.pixels(), 500.0f);
    frame.name = std::to_string(number);
    frame.time_s = number / 30.0;
    return frame;
  }

 private:
  int size_;
  std::function<void(int)> before_;
  int count_ = 0;
};

/// Finds a hand in the frames whose names are even numbers; `work` is what it does meanwhile.
class EvenSegmenter final : public Segmenter {
 public:
  explicit EvenSegmenter(std::function<void(const Frame&)> work) : work_(std::move(work)) {}
  Segmentation segment(const Frame& frame, const std::optional<Point3>&, int) const override {
    work_(frame);
    if (std::stoi(frame.name) % 2 == 1) return {{}, "an odd frame"};
    HandRegion region;
    region.box = {0, 0, 1, 1};
    region.mask = Image<std::uint8_t>(1, 1, 1);
    region.centre = {0, 0, 500};
    region.score = 1.0;
    return {{region}, ""};
  }

 private:
  std::function<void(const Frame&)> work_;
};

class StillEstimator final : public Estimator {
 public:
  Convention convention() const override { return superset_convention(); }
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch&) const override {
    return {std::vector<PatchPoint>(kSupersetSize, PatchPoint{0, 0, 0}),
            std::vector<float>(kSupersetSize, 0.8f)};
  }

 private:
  PatchExtractor patches_{{.size_px = 32, .mode = "cube", .cube_mm = 250.0}};
};

Pipeline pipeline_with(std::function<void(const Frame&)> work = [](const Frame&) {}) {
  return Pipeline(
      {HandFinder(std::make_unique<EvenSegmenter>(std::move(work)), {}), std::make_unique<StillEstimator>()});
}

TEST(RunLive, LooksAtEachFrameWhereThereIsTime) {
  std::atomic<int> done = 0;
  // Each frame comes when the one before has been looked at.
  CountingStream stream(6, [&](int number) {
    while (done < number) std::this_thread::sleep_for(milliseconds(1));
  });
  std::vector<std::string> names;
  const LiveCounts counts = run_live(stream, pipeline_with(), {}, [&](const LiveFrame& live) {
    EXPECT_EQ(live.result.name, live.frame->name);
    EXPECT_EQ(live.result.index, done);
    EXPECT_EQ(live.result.estimate.hands.size(), done % 2 == 0 ? 1U : 0U);
    EXPECT_GE(live.latency_ms, 0.0);
    EXPECT_LT(live.latency_ms, 60000.0);
    EXPECT_GT(live.arrived, live.result.index);
    EXPECT_EQ(live.passed_over, 0);
    names.push_back(live.result.name);
    ++done;
  });
  EXPECT_THAT(names, ElementsAre("0", "1", "2", "3", "4", "5"));
  EXPECT_EQ(counts.arrived, 6);
  EXPECT_EQ(counts.results, 6);
  EXPECT_EQ(counts.found, 3);
  EXPECT_EQ(counts.passed_over, 0);
}

TEST(RunLive, TheNewestFrameWinsAndTheOthersAreCounted) {
  std::atomic<int> arrived = 0;
  std::atomic<bool> is_first_seen = false;
  CountingStream stream(10, [&](int number) {
    while (number > 0 && !is_first_seen) std::this_thread::sleep_for(milliseconds(1));
    arrived = number;
  });
  // The first frame takes until the last but one has come.
  const Pipeline pipeline = pipeline_with([&](const Frame& frame) {
    is_first_seen = true;
    while (frame.name == "0" && arrived < 9) std::this_thread::sleep_for(milliseconds(1));
  });
  std::vector<std::int64_t> indices;
  std::int64_t at_arrival = 0;
  const LiveOptions options{
      .at_arrival = [&](std::int64_t index, const auto&) { EXPECT_EQ(index, at_arrival++); }};
  const LiveCounts counts = run_live(stream, pipeline, options,
                                     [&](const LiveFrame& live) { indices.push_back(live.result.index); });
  EXPECT_EQ(at_arrival, 10) << "who records sees them all";
  EXPECT_EQ(counts.arrived, 10);
  EXPECT_EQ(counts.results + counts.passed_over, 10);
  EXPECT_GE(counts.passed_over, 6);
  EXPECT_EQ(indices.front(), 0);
  EXPECT_EQ(indices.back(), 9);
  EXPECT_TRUE(std::ranges::is_sorted(indices));
}

TEST(RunLive, GoesOnAfterAFrameThatCannotBeRead) {
  std::atomic<int> done = 0;
  CountingStream stream(4, [&](int number) {
    if (number == 1) fail("frame 1 is torn");
    while (done < (number > 1 ? number - 1 : number)) std::this_thread::sleep_for(milliseconds(1));
  });
  const LiveCounts counts = run_live(stream, pipeline_with(), {}, [&](const LiveFrame&) { ++done; });
  EXPECT_EQ(counts.results, 3);
  EXPECT_EQ(counts.unreadable, 1);
  EXPECT_EQ(counts.fault, "frame 1 is torn");
}

TEST(RunLive, EndsAtItsLimits) {
  const auto endless = [](int) { std::this_thread::sleep_for(milliseconds(2)); };
  CountingStream many(1000000, endless);
  EXPECT_EQ(run_live(many, pipeline_with(), {.most_frames = 5}, [](const LiveFrame&) {}).results, 5);
  CountingStream long_one(1000000, endless);
  const auto begin = std::chrono::steady_clock::now();
  run_live(long_one, pipeline_with(), {.most_seconds = 0.1}, [](const LiveFrame&) {});
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(100));
  CountingStream interrupted(1000000, endless);
  const LiveCounts counts = run_live(interrupted, pipeline_with(), {}, [](const LiveFrame& live) {
    if (live.result.index >= 3) set_interrupted(true);
  });
  set_interrupted(false);
  EXPECT_GE(counts.results, 1);
  EXPECT_THAT(error_of([&] { run_live(many, pipeline_with(), {.most_frames = -1}, {}); }),
              HasSubstr("frames is -1"));
  EXPECT_THAT(error_of([&] { run_live(many, pipeline_with(), {.most_seconds = kNaN}, {}); }),
              HasSubstr("seconds is nan"));
  EXPECT_THAT(error_of([&] { run_live(many, pipeline_with(), {.most_seconds = INFINITY}, {}); }),
              HasSubstr("seconds is inf"));
}

TEST(RunLive, WhatIsThrownEndsIt) {
  const auto endless = [](int) { std::this_thread::sleep_for(milliseconds(1)); };
  CountingStream one(1000000, endless);
  EXPECT_THAT(error_of([&] {
                run_live(one, pipeline_with(), {}, [](const LiveFrame&) { fail("the disk is full"); });
              }),
              HasSubstr("the disk is full"));
  CountingStream two(1000000, endless);
  const LiveOptions recorded{.at_arrival = [](std::int64_t index, const auto&) {
    if (index == 3) fail("no room to record");
  }};
  EXPECT_THAT(error_of([&] { run_live(two, pipeline_with(), recorded, [](const LiveFrame&) {}); }),
              HasSubstr("no room to record"));
}

}  // namespace
}  // namespace knuckle
