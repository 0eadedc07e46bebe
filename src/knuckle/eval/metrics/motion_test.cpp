// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/motion.h"

#include <cmath>
#include <functional>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/eval/metrics/eval_fixtures.h"

namespace knuckle {
namespace {

using testing::example_convention;
using Place = std::function<Point3(int frame, int joint)>;

Projection some_projection() {
  Camera camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 250;
  camera.cx = 160;
  camera.cy = 120;
  return Projection(camera);
}

PoseSequence sequence_of(int frames, const Place& place) {
  PoseSequence sequence{"made up", example_convention(), {}};
  for (int frame = 0; frame < frames; ++frame) {
    HandPose pose = HandPose::missing(example_convention());
    for (int joint = 0; joint < example_convention().size(); ++joint) {
      const Point3 point = place(frame, joint);
      if (point.allFinite()) pose.joints[static_cast<std::size_t>(joint)] = some_projection().to_image(point);
    }
    sequence.poses.push_back(pose);
  }
  return sequence;
}

MotionScore score_of(int frames, const Place& truth, const Place& estimate,
                     const std::vector<int>& sequences = {}) {
  return motion_score({sequence_of(frames, truth), {some_projection()}, {}, sequences},
                      {"made up", sequence_of(frames, estimate)});
}

Point3 at_rest(int joint) {
  return {10.0 * (joint % 4), 12.0 * joint - 100.0, 500.0 + joint};
}

/// Swings with a period of 40 frames.
Point3 swinging(double frame, int joint) {
  return at_rest(joint) + Point3(40.0 * std::sin(frame * 0.157), 0.0, 20.0 * std::cos(frame * 0.157));
}

TEST(MotionScore, OfPerfectEstimatesIsThatOfTheTruth) {
  const Place truth = [](int frame, int joint) { return swinging(frame, joint); };
  const MotionScore score = score_of(60, truth, truth);
  EXPECT_EQ(score.frames, 58);
  EXPECT_NEAR(score.acceleration_mm, score.true_acceleration_mm, 1e-9);
  EXPECT_NEAR(score.acceleration_error_mm, 0.0, 1e-9);
  EXPECT_NEAR(score.lag_frames, 0.0, 0.02);
  EXPECT_NEAR(score.bone_deviation, 0.0, 1e-9);
  EXPECT_TRUE(std::isnan(score.jitter_mm)) << "the hand never stands still";
}

TEST(MotionScore, AccelerationIsTheSecondDifference) {
  // x = frame^2 has 2 everywhere; a zigzag of 3 mm on z has 4 x 3.
  const Place truth = [](int frame, int joint) {
    return Point3(at_rest(joint) + Point3(frame * frame, 0, 0));
  };
  const Place zigzag = [&](int frame, int joint) {
    return Point3(truth(frame, joint) + Point3(0, 0, frame % 2 == 0 ? 3.0 : -3.0));
  };
  const MotionScore score = score_of(12, truth, zigzag);
  EXPECT_NEAR(score.true_acceleration_mm, 2.0, 1e-9);
  EXPECT_NEAR(score.acceleration_mm, std::hypot(2.0, 12.0), 1e-9);
  EXPECT_NEAR(score.acceleration_error_mm, 12.0, 1e-9);
}

TEST(MotionScore, LagIsHowLateEstimatesAre) {
  const Place truth = [](int frame, int joint) { return swinging(frame, joint); };
  for (const double late : {-2.0, -0.5, 0.3, 1.0, 2.4}) {
    const Place estimate = [&](int frame, int joint) { return swinging(frame - late, joint); };
    EXPECT_NEAR(score_of(120, truth, estimate).lag_frames, late, 0.05);
  }
  const Place still = [](int, int joint) { return at_rest(joint); };
  EXPECT_TRUE(std::isnan(score_of(60, still, still).lag_frames));
}

TEST(MotionScore, SequencesAreNotMixed) {
  // Two sequences that are half a metre apart: across the border there would be a huge acceleration.
  const Place truth = [](int frame, int joint) {
    return Point3(swinging(frame, joint) + Point3(frame < 20 ? 0.0 : 500.0, 0, 0));
  };
  std::vector<int> sequences(40, 0);
  std::fill(sequences.begin() + 20, sequences.end(), 1);
  const MotionScore score = score_of(40, truth, truth, sequences);
  EXPECT_EQ(score.frames, 36);
  EXPECT_LT(score.acceleration_mm, 2.0);
  EXPECT_GT(score_of(40, truth, truth).acceleration_mm, 10.0);
}

TEST(MotionScore, JitterIsTheDeviationOnAStillHand) {
  // Still for 200 frames, then moving; noise of 0.3 mm per axis, of one joint twice that.
  constexpr int kStill = 200;
  const Place truth = [](int frame, int joint) {
    return Point3(at_rest(joint) + Point3(frame < kStill ? 0.0 : 5.0 * (frame - kStill + 1), 0, 0));
  };
  Random random(3);
  const Place noisy = [&](int frame, int joint) {
    const double sigma = joint == 7 ? 0.6 : 0.3;
    return Point3(truth(frame, joint) + Point3(4, 0, 0) +
                  sigma * Point3(random.normal(), random.normal(), random.normal()));
  };
  const MotionScore score = score_of(kStill + 40, truth, noisy);
  EXPECT_NEAR(score.worst_jitter_mm, 0.6 * std::sqrt(3.0), 0.06);
  EXPECT_NEAR(score.jitter_mm, (19 * 0.3 + 0.6) / 20 * std::sqrt(3.0), 0.02);
  const MotionScore brief = score_of(kStillFrames - 1, truth, noisy);
  EXPECT_TRUE(std::isnan(brief.jitter_mm)) << "too few still frames";
}

TEST(MotionScore, AHandThatMovesSlowlyDoesNotStandStill) {
  const auto moving = [](double mm_per_frame) {
    return [=](int frame, int joint) { return Point3(at_rest(joint) + Point3(mm_per_frame * frame, 0, 0)); };
  };
  EXPECT_TRUE(std::isnan(score_of(60, moving(0.06), moving(0.06)).jitter_mm));
  EXPECT_FALSE(std::isnan(score_of(60, moving(0.04), moving(0.04)).jitter_mm));
}

TEST(MotionScore, BonesThatChangeTheirLengthAreTold) {
  const Place truth = [](int, int joint) { return at_rest(joint); };
  const Place breathing = [](int frame, int joint) {
    return Point3(at_rest(joint) * (frame % 2 == 0 ? 1.02 : 0.98));
  };
  EXPECT_NEAR(score_of(20, truth, breathing).bone_deviation, 0.02, 1e-6);
}

TEST(MotionScore, FramesWithoutHandsAndUnrelatedFramesAreLeftOut) {
  const Place truth = [](int frame, int joint) { return swinging(frame, joint); };
  const Place gaps = [&](int frame, int joint) {
    return frame % 10 == 4 ? Point3(Point3::Constant(kNaN)) : truth(frame, joint);
  };
  const MotionScore score = score_of(40, truth, gaps);
  EXPECT_EQ(score.frames, 38 - 3 * 4);
  EXPECT_NEAR(score.acceleration_error_mm, 0.0, 1e-9);
  EXPECT_NEAR(score.lag_frames, 0.0, 0.05);
  const Place nowhere = [](int, int) { return Point3(Point3::Constant(kNaN)); };
  EXPECT_EQ(score_of(40, truth, nowhere).frames, 0);
  EXPECT_TRUE(std::isnan(score_of(40, truth, nowhere).lag_frames));
  Random random(5);
  const Place unrelated = [&](int, int) {
    return Point3(random.uniform(-200, 200), random.uniform(-200, 200), random.uniform(400, 800));
  };
  EXPECT_EQ(score_of(40, unrelated, unrelated).frames, 0);
  EXPECT_EQ(score_of(1, truth, truth).frames, 0);
}

}  // namespace
}  // namespace knuckle
