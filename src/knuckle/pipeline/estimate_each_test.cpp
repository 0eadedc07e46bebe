// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/estimate_each.h"

#include <array>
#include <atomic>
#include <chrono>
#include <set>
#include <thread>

#include "knuckle/core/interruption.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/pipeline/estimate_all.h"
#include "knuckle/segment/hand_region.h"

namespace knuckle {
namespace {

using ::knuckle::testing::error_of;
using ::testing::HasSubstr;

constexpr int kSide = 24;

/// The first pixel says which frame it is.
Frame numbered_frame(std::int64_t index) {
  Frame frame;
  frame.name = fmt::format("frame{}", index);
  frame.time_s = 0.1 * static_cast<double>(index);
  frame.camera = {.width = kSide, .height = kSide, .fx = 20.0, .fy = 20.0, .cx = 11.5, .cy = 11.5};
  frame.depth_mm = Image<float>(kSide, kSide, 500.0f);
  frame.depth_mm(0, 0) = 400.0f + static_cast<float>(index % 64);
  return frame;
}

/// Frames that count how many of them are alive; those in `faulty` cannot be read.
class CountedSource final : public FrameSource {
 public:
  explicit CountedSource(std::int64_t size, std::set<std::int64_t> faulty = {})
      : size_(size), faulty_(std::move(faulty)) {}

  std::int64_t size() const override { return size_; }
  Frame read(std::int64_t index) const override {
    ++reads;
    if (faulty_.contains(index)) fail("image {} is broken", index);
    return numbered_frame(index);
  }
  FrameLabel read_label(std::int64_t index) const override {
    if (labels_are_wrong) fail("labels.txt:{}: wrong", index);
    const Frame frame = numbered_frame(index);
    return {frame.camera, std::nullopt, frame.time_s, 0, frame.name};
  }
  std::optional<Convention> convention() const override { return std::nullopt; }

  mutable std::atomic<int> reads = 0;
  bool labels_are_wrong = false;

 private:
  std::int64_t size_;
  std::set<std::int64_t> faulty_;
};

/// All pixels are hand. Every tenth frame takes long, and some do parallel work of their own.
class SlowSegmenter final : public Segmenter {
 public:
  Segmentation segment(const Frame& frame, const std::optional<Point3>& /*start*/,
                       int /*max_hands*/) const override {
    const int number = static_cast<int>(frame.depth_mm(0, 0)) - 400;
    std::this_thread::sleep_for(std::chrono::microseconds(number % 10 == 0 ? 3000 : 20));
    if (number % 3 == 0) parallel_for(8, [](std::int64_t) {});
    std::vector<std::int32_t> pixels(frame.depth_mm.size());
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::int32_t>(i);
    HandRegion region = region_of_pixels(pixels, kSide);
    region.centre = Point3(0.0, 0.0, frame.depth_mm(0, 0));
    return {{region}, ""};
  }
};

class MiddleEstimator final : public Estimator {
 public:
  Convention convention() const override { return {"middle1", kPalm}; }
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch& /*patch*/) const override { return {{{0.0, 0.0, 0.0}}, {1.0f}}; }

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchExtractor patches_{{.size_px = 8}};
};

class EstimateEachTest : public ::testing::Test {
 protected:
  void TearDown() override { set_interrupted(false); }

  static void expect_is_frame(const FrameResult& result, std::int64_t index) {
    EXPECT_EQ(result.index, index);
    if (!result.fault.empty()) return;
    EXPECT_EQ(result.camera, numbered_frame(index).camera);
    EXPECT_EQ(result.name, fmt::format("frame{}", index));
    EXPECT_DOUBLE_EQ(*result.time_s, 0.1 * static_cast<double>(index));
    ASSERT_EQ(result.estimate.hands.size(), 1u);
    EXPECT_EQ(result.estimate.hands[0].region.centre.z(), 400.0 + static_cast<double>(index % 64));
    EXPECT_TRUE(result.estimate.hands[0].region.mask.empty());
    EXPECT_FALSE(result.estimate.hands[0].pose.is_missing());
  }

  const Pipeline pipeline_{
      {HandFinder(std::make_unique<SlowSegmenter>()), std::make_unique<MiddleEstimator>()}};
};

TEST_F(EstimateEachTest, ResultsOfFramesOfVeryDifferentCostComeInOrderAndAreTheirOwn) {
  const CountedSource source(300);
  std::int64_t taken = 0;
  estimate_each(source, pipeline_, {}, [&](const FrameResult& result) { expect_is_frame(result, taken++); });
  EXPECT_EQ(taken, 300);
  SourceStream stream(source);
  taken = 0;
  estimate_each(stream, pipeline_, {}, [&](const FrameResult& result) { expect_is_frame(result, taken++); });
  EXPECT_EQ(taken, 300);
}

TEST(RunOptions, AreChecked) {
  EXPECT_NO_THROW(RunOptions{}.check());
  EXPECT_THAT(error_of([] { RunOptions{.first = -1}.check(); }),
              HasSubstr("first is -1, expected at least 0"));
  EXPECT_THAT(error_of([] { RunOptions{.frames_in_flight = -1}.check(); }),
              HasSubstr("frames_in_flight is -1"));
  EXPECT_THAT(error_of([] { RunOptions{.frames_in_flight = 1 << 30}.check(); }),
              HasSubstr("frames_in_flight is 1073741824, expected 0 to"));
}

TEST_F(EstimateEachTest, AllResultsAreInTheOrderOfTheFrames) {
  const CountedSource source(100);
  const std::vector<FrameEstimate> frames = estimate_all(source, pipeline_, Start::nearest, "x");
  ASSERT_EQ(frames.size(), 100u);
  for (std::size_t i = 0; i < frames.size(); ++i)
    EXPECT_EQ(frames[i].hands.at(0).region.centre.z(), 400.0 + static_cast<double>(i % 64)) << i;
}

TEST_F(EstimateEachTest, OnePipelineAndOneSourceServeManyRunsAtOnce) {
  const CountedSource source(60);
  std::vector<std::int64_t> taken(4, 0);
  {
    std::vector<std::jthread> threads;
    for (std::int64_t& own : taken) {
      threads.emplace_back([&] {
        SourceStream stream(source);
        estimate_each(stream, pipeline_, {},
                      [&](const FrameResult& result) { expect_is_frame(result, own++); });
      });
    }
  }
  EXPECT_EQ(taken, std::vector<std::int64_t>(4, 60));
}

TEST_F(EstimateEachTest, FramesThatCannotBeReadAreResultsWithAFault) {
  const CountedSource source(100, {0, 50, 51, 99});
  SourceStream stream(source);
  for (const bool is_stream : {false, true}) {
    std::vector<std::int64_t> faulty;
    std::int64_t taken = 0;
    const auto take = [&](const FrameResult& result) {
      expect_is_frame(result, taken++);
      if (result.fault.empty()) return;
      EXPECT_EQ(result.fault, fmt::format("image {} is broken", result.index));
      EXPECT_TRUE(result.estimate.hands.empty());
      EXPECT_EQ(result.estimate.status, "the frame cannot be read: " + result.fault);
      EXPECT_EQ(result.name, is_stream ? "" : fmt::format("frame{}", result.index));
      EXPECT_EQ(result.time_s.has_value(), !is_stream);
      EXPECT_EQ(result.camera == numbered_frame(0).camera, !is_stream);
      faulty.push_back(result.index);
    };
    if (is_stream) {
      estimate_each(stream, pipeline_, {}, take);
    } else {
      estimate_each(source, pipeline_, {}, take);
    }
    EXPECT_EQ(taken, 100);
    EXPECT_THAT(faulty, ::testing::ElementsAre(0, 50, 51, 99));
  }
  EXPECT_EQ(error_of([&] { estimate_all(source, pipeline_, Start::nearest, "x"); }), "image 0 is broken");
}

TEST_F(EstimateEachTest, ASetWhoseLabelsAreWrongIsRefusedAsAWhole) {
  CountedSource source(20, {7});
  source.labels_are_wrong = true;
  std::int64_t taken = 0;
  EXPECT_EQ(error_of([&] { estimate_each(source, pipeline_, {}, [&](const FrameResult&) { ++taken; }); }),
            "labels.txt:7: wrong");
  EXPECT_LE(taken, 7);
}

TEST_F(EstimateEachTest, NoMoreFramesAreReadThanAllowedAheadOfTheResults) {
  const CountedSource source(64);
  std::int64_t taken = 0;
  estimate_each(source, pipeline_, {.frames_in_flight = 3}, [&](const FrameResult&) {
    EXPECT_LE(source.reads - taken, 3);
    ++taken;
    std::this_thread::sleep_for(std::chrono::microseconds(300));
  });
  EXPECT_EQ(taken, 64);
}

TEST_F(EstimateEachTest, ARunMayBeginLater) {
  const CountedSource source(30);
  std::int64_t taken = 12;
  const auto take = [&](const FrameResult& result) { expect_is_frame(result, taken++); };
  estimate_each(source, pipeline_, {.first = 12}, take);
  EXPECT_EQ(taken, 30);
  EXPECT_EQ(source.reads, 18);
  estimate_each(source, pipeline_, {.first = 30}, take);
  EXPECT_EQ(taken, 30);
  EXPECT_THAT(error_of([&] { estimate_each(source, pipeline_, {.first = 31}, take); }),
              HasSubstr("first is 31"));
  EXPECT_THAT(error_of([&] { estimate_each(source, pipeline_, {.frames_in_flight = -1}, take); }),
              HasSubstr("frames_in_flight is -1"));
}

TEST_F(EstimateEachTest, AnExceptionOfTheReceiverEndsTheRun) {
  const CountedSource source(100000);
  std::int64_t taken = 0;
  EXPECT_EQ(error_of([&] {
              estimate_each(source, pipeline_, {}, [&](const FrameResult& result) {
                expect_is_frame(result, taken++);
                if (taken == 20) fail("the disk is full");
              });
            }),
            "the disk is full");
  EXPECT_EQ(taken, 20);
  EXPECT_LT(source.reads, 200);
}

TEST_F(EstimateEachTest, InterruptedItHandsOverWhatWasBegun) {
  const CountedSource source(100000);
  std::int64_t taken = 0;
  EXPECT_THROW(estimate_each(source, pipeline_, {},
                             [&](const FrameResult& result) {
                               expect_is_frame(result, taken++);
                               if (taken == 20) set_interrupted(true);
                             }),
               Interrupted);
  EXPECT_GE(taken, 20);
  EXPECT_LT(source.reads, 200);
}

TEST_F(EstimateEachTest, ASourceWithoutTruthCannotBeStartedAtIt) {
  const CountedSource source(3);
  EXPECT_THAT(
      error_of([&] { estimate_each(source, pipeline_, {.start = Start::truth}, [](const FrameResult&) {}); }),
      HasSubstr("the source has none"));
}

}  // namespace
}  // namespace knuckle
