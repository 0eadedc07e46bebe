// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/track_each.h"

#include <set>

#include "knuckle/camera/projection.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

constexpr double kPlaneMm = 600.0;
constexpr std::int64_t kSequenceFrames = 12;

/// Two hands that go to and fro before a wall, in sequences of 12 frames; frames know where they are.
class TwoHands final : public FrameSource {
 public:
  explicit TwoHands(std::int64_t size, std::set<std::int64_t> faulty = {})
      : size_(size), faulty_(std::move(faulty)) {}

  std::int64_t size() const override { return size_; }
  Frame read(std::int64_t index) const override {
    if (faulty_.contains(index)) fail("image {} is broken", index);
    Frame frame = testing::blank_frame(testing::quarter_vga_camera());
    std::ranges::fill(frame.depth_mm.pixels(), static_cast<float>(kPlaneMm));
    frame.name = fmt::format("frame{}", index);
    frame.time_s = static_cast<double>(index) / 30.0;
    frame.sequence = static_cast<int>(index / kSequenceFrames);
    const double step = 4.0 * static_cast<double>(index % kSequenceFrames);
    for (const double x : {-130.0 + step, 130.0 - step}) {
      HandTruth hand;
      hand.pose = HandPose::missing(superset_convention());
      hand.pose.joints[0] = Projection(frame.camera).to_image({x, step, kPlaneMm});
      frame.hands.push_back(hand);
    }
    return frame;
  }
  FrameLabel read_label(std::int64_t index) const override {
    return {testing::quarter_vga_camera(), std::nullopt, static_cast<double>(index) / 30.0,
            static_cast<int>(index / kSequenceFrames), fmt::format("frame{}", index)};
  }
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  std::int64_t size_;
  std::set<std::int64_t> faulty_;
};

/// Finds the hands that a frame knows.
class KnowingSegmenter final : public Segmenter {
 public:
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override {
    Segmentation found;
    for (const HandTruth& hand : frame.hands) {
      HandRegion region;
      region.box = {0, 0, 1, 1};
      region.mask = Image<std::uint8_t>(1, 1, 1);
      region.centre = Projection(frame.camera).to_camera(mean_joint(hand.pose));
      if (start && (region.centre - *start).norm() > 60.0) continue;
      if (std::ssize(found.hands) < max_hands) found.hands.push_back(region);
    }
    return found;
  }
};

/// Sees an adult's straight hand around the patch's centre; the farther left, the surer.
class StraightHand final : public Estimator {
 public:
  Convention convention() const override { return superset_convention(); }
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch& patch) const override {
    const Projection projection(testing::quarter_vga_camera());
    const Point3 centre = projection.to_camera(patch.geometry.to_image({0, 0, 0}));
    const auto points = landmarks(adult_skeleton(), HandAngles{}, RigidTransform::Identity());
    PatchPose pose;
    for (const Point3& point : points) {
      pose.joints.push_back(patch.geometry.to_patch(projection.to_image(centre + point - Point3(0, 90, 0))));
      pose.confidence.push_back(centre.x() < 0.0 ? 0.9f : 0.8f);
    }
    return pose;
  }

 private:
  PatchExtractor patches_{{.size_px = 32, .mode = "cube", .cube_mm = 250.0}};
};

Pipeline tracked_pipeline() {
  return Pipeline({.finder = HandFinder(std::make_unique<KnowingSegmenter>(), {.max_hands = 2}),
                   .estimator = std::make_unique<StraightHand>(),
                   .tracker = TrackerOptions{}});
}

std::vector<FrameResult> results_of(const FrameSource& source, const RunOptions& options = {}) {
  std::vector<FrameResult> results;
  track_each(source, tracked_pipeline(), options,
             [&](FrameResult result) { results.push_back(std::move(result)); });
  return results;
}

void expect_same(const FrameResult& a, const FrameResult& b) {
  EXPECT_EQ(a.index, b.index);
  EXPECT_EQ(a.fault, b.fault);
  ASSERT_EQ(a.estimate.hands.size(), b.estimate.hands.size());
  for (std::size_t i = 0; i < a.estimate.hands.size(); ++i) {
    const HandEstimate& one = a.estimate.hands[i];
    const HandEstimate& other = b.estimate.hands[i];
    EXPECT_EQ(one.id, other.id);
    EXPECT_EQ(one.side, other.side);
    EXPECT_EQ(one.angles, other.angles);
    for (std::size_t j = 0; j < one.pose.joints.size(); ++j)
      EXPECT_EQ(one.pose.joints[j].u, other.pose.joints[j].u);
  }
}

TEST(TrackEach, GivesIdsAnglesAndSkeletonsInTheOrderOfTheFrames) {
  const auto results = results_of(TwoHands(30));
  ASSERT_EQ(results.size(), 30u);
  for (std::size_t i = 0; i < results.size(); ++i) {
    EXPECT_EQ(results[i].index, static_cast<std::int64_t>(i));
    EXPECT_EQ(results[i].name, fmt::format("frame{}", i));
    ASSERT_EQ(results[i].estimate.hands.size(), 2u) << i;
    EXPECT_EQ(results[i].estimate.hands[0].id, 1) << "the surest first; ids begin anew in each sequence";
    EXPECT_EQ(results[i].estimate.hands[1].id, 2);
    for (const HandEstimate& hand : results[i].estimate.hands) {
      EXPECT_TRUE(hand.angles.has_value());
      EXPECT_EQ(hand.skeleton, "adult");
      EXPECT_NEAR(hand.region.centre.z(), kPlaneMm, 60.0);
    }
    EXPECT_EQ(results[i].estimate.status, "");
  }
}

TEST(TrackEach, IsTheSameOnAnyNumberOfThreadsAndFromAnyFrameOn) {
  const TwoHands source(30);
  set_thread_count(1);
  const auto one = results_of(source);
  set_thread_count(4);
  const auto four = results_of(source);
  for (const std::int64_t first : {0, 5, 12, 17, 29, 30}) {
    const auto rest = results_of(source, {.first = first});
    ASSERT_EQ(std::ssize(rest), 30 - first);
    for (std::size_t i = 0; i < rest.size(); ++i)
      expect_same(rest[i], one[i + static_cast<std::size_t>(first)]);
  }
  set_thread_count(0);
  for (std::size_t i = 0; i < one.size(); ++i) expect_same(one[i], four[i]);
}

TEST(TrackEach, AFrameThatCannotBeReadIsAFaultAndHandsAreFoundAgain) {
  const auto results = results_of(TwoHands(12, {4, 5}));
  ASSERT_EQ(results.size(), 12u);
  for (std::size_t i = 0; i < results.size(); ++i) {
    const bool is_faulty = i == 4 || i == 5;
    EXPECT_EQ(results[i].fault.empty(), !is_faulty) << i;
    EXPECT_EQ(results[i].estimate.hands.size(), is_faulty ? 0u : 2u) << i;
    EXPECT_EQ(results[i].name, fmt::format("frame{}", i));
  }
}

TEST(TrackEach, NeedsATrackerAndAStartOfItsOwn) {
  const TwoHands source(2);
  const auto take = [](const FrameResult&) {};
  const Pipeline still({HandFinder(std::make_unique<KnowingSegmenter>()), std::make_unique<StraightHand>()});
  EXPECT_THAT(error_of([&] { track_each(source, still, {}, take); }), HasSubstr("no tracker"));
  EXPECT_THAT(error_of([&] { track_each(source, tracked_pipeline(), {.start = Start::truth}, take); }),
              HasSubstr("--init truth"));
  EXPECT_THAT(error_of([&] { track_each(source, tracked_pipeline(), {.first = 3}, take); }),
              HasSubstr("2 frames"));
  Pipeline tracked = tracked_pipeline();
  EXPECT_THAT(error_of([&] { tracked.use_landmarks(LandmarkDefinition::plain(superset_convention())); }),
              HasSubstr("tracker"));
  EXPECT_THAT(error_of([] {
                Pipeline({.finder = HandFinder(std::make_unique<KnowingSegmenter>()),
                          .estimator = std::make_unique<StraightHand>(),
                          .tracker = TrackerOptions{.learn_s = -1.0}});
              }),
              HasSubstr("learn_s"));
}

}  // namespace
}  // namespace knuckle
