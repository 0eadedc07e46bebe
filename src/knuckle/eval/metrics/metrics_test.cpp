// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using knuckle::testing::error_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// At a depth of 100 mm one pixel is one millimetre.
Projection simple_projection() {
  Camera camera;
  camera.width = 100;
  camera.height = 100;
  camera.fx = 100.0;
  camera.fy = 100.0;
  return Projection(camera);
}

Truth truth_of(const Convention& convention, std::vector<HandPose> poses) {
  return {{"truth.txt", convention, std::move(poses)}, {simple_projection()}};
}

Predictions predictions_of(const Convention& convention, std::vector<HandPose> poses) {
  return {"method", {"method.txt", convention, std::move(poses)}};
}

/// A pose in nyu14 of which only the first joints are known.
HandPose pose_of(const std::vector<ImagePoint>& joints) {
  HandPose pose = HandPose::missing(convention_from_name("nyu14"));
  std::ranges::copy(joints, pose.joints.begin());
  return pose;
}

MethodScore score_of(const Truth& truth, const Predictions& predictions) {
  return score(joint_errors(truth, predictions), predictions.name);
}

std::vector<HandPose> random_poses(const Convention& convention, int count, std::uint64_t seed,
                                   double missing_share, double spread) {
  std::vector<HandPose> poses;
  for (int i = 0; i < count; ++i) {
    Random random(seed, static_cast<std::uint64_t>(i));
    HandPose pose = HandPose::missing(convention);
    for (ImagePoint& joint : pose.joints) {
      if (random.uniform() < missing_share) continue;
      joint = {50.0 + spread * random.normal(), 50.0 + spread * random.normal(),
               400.0 + spread * random.normal()};
    }
    poses.push_back(pose);
  }
  return poses;
}

TEST(Metrics, AreThoseComputedByHand) {
  const Convention convention = convention_from_name("nyu14");
  const ImagePoint at_origin{0.0, 0.0, 100.0};
  // Frame 0: errors 3 and 5 mm. Frame 1: 30 mm, the other joint has no truth. Frame 2: one joint is missing.
  const Truth truth = truth_of(convention, {pose_of({at_origin, at_origin}), pose_of({at_origin}),
                                            pose_of({at_origin, at_origin}), pose_of({})});
  const Predictions predictions =
      predictions_of(convention, {pose_of({{3.0, 0.0, 100.0}, {3.0, 4.0, 100.0}}),
                                  pose_of({{0.0, 30.0, 100.0}, {99.0, 99.0, 100.0}}),
                                  pose_of({{1.0, 0.0, 100.0}}), pose_of({})});
  const MethodScore result = score_of(truth, predictions);
  EXPECT_EQ(result.frames, 4);
  EXPECT_EQ(result.scored_frames, 3);
  EXPECT_EQ(result.missing, 1);
  EXPECT_NEAR(result.mean_3d_mm, (3.0 + 5.0 + 30.0) / 3.0, 1e-12);
  EXPECT_NEAR(result.median_3d_mm, 5.0, 1e-12);
  EXPECT_NEAR(result.mean_2d_px, (3.0 + 5.0 + 30.0) / 3.0, 1e-12);
  EXPECT_NEAR(result.joints[0].mean_3d_mm, 16.5, 1e-12);
  EXPECT_NEAR(result.joints[0].median_3d_mm, 16.5, 1e-12);
  EXPECT_EQ(result.joints[0].frames, 2);
  EXPECT_EQ(result.joints[1].frames, 1);
  EXPECT_TRUE(std::isnan(result.joints[2].mean_3d_mm));
  EXPECT_THAT(result.frames_all_joints_within, ElementsAre(1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0));
  EXPECT_DOUBLE_EQ(result.curves.mean_within[3], 0.0);
  EXPECT_DOUBLE_EQ(result.curves.mean_within[4], 1.0 / 3.0);  // within includes the distance itself
  EXPECT_DOUBLE_EQ(result.curves.joints_within[3], 1.0 / 5.0);
  EXPECT_DOUBLE_EQ(result.curves.joints_within[80], 3.0 / 5.0);
  EXPECT_DOUBLE_EQ(result.curves.joints_within_px[5], 2.0 / 5.0);
  EXPECT_NEAR(result.auc_pck_0_50, (47.0 + 45.0 + 20.0) / 50.0 / 5.0, 1e-12);
  EXPECT_DOUBLE_EQ(result.frame_mean_3d_mm[0], 4.0);
  EXPECT_EQ(result.frame_mean_3d_mm[2], kInfinity);
  EXPECT_TRUE(std::isnan(result.frame_mean_3d_mm[3]));
}

/// The measures' definitions, written out frame by frame.
struct Reference {
  int missing = 0;
  double joints = 0.0;             ///< with truth
  std::vector<double> used;        ///< errors of frames with a prediction, sorted
  std::vector<double> frame_mean;  ///< of the same frames
  std::vector<double> frame_largest;
};

Reference reference_of(const std::vector<HandPose>& truth, const std::vector<HandPose>& predicted) {
  const Projection projection = simple_projection();
  Reference reference;
  for (std::size_t f = 0; f < truth.size(); ++f) {
    std::vector<double> errors;
    bool is_missing = false;
    for (std::size_t j = 0; j < truth[f].joints.size(); ++j) {
      const ImagePoint& expected = truth[f].joints[j];
      const ImagePoint& found = predicted[f].joints[j];
      if (expected.is_missing()) continue;
      is_missing = is_missing || found.is_missing();
      errors.push_back((projection.to_camera(expected) - projection.to_camera(found)).norm());
    }
    reference.joints += static_cast<double>(errors.size());
    reference.missing += is_missing ? 1 : 0;
    if (is_missing) continue;
    reference.used.insert(reference.used.end(), errors.begin(), errors.end());
    const double sum = std::accumulate(errors.begin(), errors.end(), 0.0);
    reference.frame_mean.push_back(sum / static_cast<double>(errors.size()));
    reference.frame_largest.push_back(std::ranges::max(errors));
  }
  std::ranges::sort(reference.used);
  return reference;
}

double count_within(const std::vector<double>& errors, double distance) {
  return static_cast<double>(std::ranges::count_if(errors, [&](double error) { return error <= distance; }));
}

TEST(Metrics, AgreeWithTheirDefinitionsWrittenOut) {
  const Convention convention = convention_from_name("icg20");
  const Truth truth = truth_of(convention, random_poses(convention, 60, 1, 0.1, 5.0));
  std::vector<HandPose> poses = random_poses(convention, 60, 2, 0.002, 5.0);
  poses[17] = HandPose::missing(convention);
  const MethodScore result = score_of(truth, predictions_of(convention, poses));
  const Reference reference = reference_of(truth.sequence.poses, poses);

  ASSERT_GT(reference.missing, 1);
  EXPECT_EQ(result.missing, reference.missing);
  for (std::size_t i = 0; i < result.curves.threshold_mm.size(); ++i) {
    const double distance = result.curves.threshold_mm[i];
    EXPECT_NEAR(result.curves.all_joints_within[i], count_within(reference.frame_largest, distance) / 60.0,
                1e-12);
    EXPECT_NEAR(result.curves.mean_within[i], count_within(reference.frame_mean, distance) / 60.0, 1e-12);
    EXPECT_NEAR(result.curves.joints_within[i], count_within(reference.used, distance) / reference.joints,
                1e-12);
  }
  const std::vector<double>& used = reference.used;
  const std::size_t half = used.size() / 2;
  EXPECT_NEAR(result.median_3d_mm, used.size() % 2 == 1 ? used[half] : (used[half - 1] + used[half]) / 2.0,
              1e-12);
  EXPECT_NEAR(result.mean_3d_mm,
              std::accumulate(used.begin(), used.end(), 0.0) / static_cast<double>(used.size()), 1e-9);
}

TEST(Metrics, TheAreaIsThatUnderTheStepCurve) {
  const Convention convention = convention_from_name("icg20");
  const Truth truth = truth_of(convention, random_poses(convention, 30, 1, 0.1, 5.0));
  const std::vector<HandPose> poses = random_poses(convention, 30, 2, 0.002, 5.0);
  const Reference reference = reference_of(truth.sequence.poses, poses);
  constexpr int kSamples = 20000;
  double area = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    area += count_within(reference.used, kAucLimitMm * (i + 0.5) / kSamples) / reference.joints / kSamples;
  }
  EXPECT_NEAR(score_of(truth, predictions_of(convention, poses)).auc_pck_0_50, area, 1e-4);
}

TEST(Metrics, OfAPerfectMethodArePerfect) {
  const Convention convention = convention_from_name("mediapipe21");
  const std::vector<HandPose> poses = random_poses(convention, 10, 3, 0.1, 20.0);
  const MethodScore result = score_of(truth_of(convention, poses), predictions_of(convention, poses));
  EXPECT_EQ(result.mean_3d_mm, 0.0);
  EXPECT_EQ(result.median_2d_px, 0.0);
  EXPECT_EQ(result.missing, 0);
  EXPECT_EQ(result.auc_pck_0_50, 1.0);
  for (const std::vector<double>* curve : {&result.curves.all_joints_within, &result.curves.mean_within,
                                           &result.curves.joints_within, &result.curves.joints_within_px}) {
    EXPECT_THAT(*curve, ::testing::Each(1.0));
  }
}

TEST(Metrics, CurvesRiseAndStayBetweenZeroAndOne) {
  const Convention convention = convention_from_name("hands21");
  const MethodScore result =
      score_of(truth_of(convention, random_poses(convention, 40, 4, 0.0, 10.0)),
               predictions_of(convention, random_poses(convention, 40, 5, 0.01, 10.0)));
  for (const std::vector<double>* curve :
       {&result.curves.all_joints_within, &result.curves.mean_within, &result.curves.joints_within}) {
    EXPECT_EQ(curve->size(), 81u);
    EXPECT_TRUE(std::ranges::is_sorted(*curve));
    EXPECT_GE(curve->front(), 0.0);
    EXPECT_LE(curve->back(), 1.0);
  }
  EXPECT_GT(result.auc_pck_0_50, 0.0);
  EXPECT_LT(result.auc_pck_0_50, 1.0);
  EXPECT_LE(result.curves.all_joints_within[40], result.curves.mean_within[40]);
}

TEST(Metrics, DoNotDependOnTheOrderOfLandmarks) {
  const Convention msra = convention_from_name("msra21");
  const Convention hands = convention_from_name("hands21");  // the same 21 landmarks in another order
  const Truth truth = truth_of(msra, random_poses(msra, 20, 6, 0.1, 10.0));
  const std::vector<HandPose> poses = random_poses(msra, 20, 7, 0.01, 10.0);
  std::vector<HandPose> reordered;
  for (const HandPose& pose : poses) reordered.push_back(converted(pose, hands));
  const MethodScore direct = score_of(truth, predictions_of(msra, poses));
  const MethodScore other = score_of(truth, predictions_of(hands, reordered));
  EXPECT_EQ(direct.mean_3d_mm, other.mean_3d_mm);
  EXPECT_EQ(direct.auc_pck_0_50, other.auc_pck_0_50);
  EXPECT_EQ(direct.curves.all_joints_within, other.curves.all_joints_within);
  for (std::size_t j = 0; j < direct.joints.size(); ++j) {
    EXPECT_EQ(direct.joints[j].landmark, other.joints[j].landmark);
    EXPECT_EQ(direct.joints[j].mean_3d_mm, other.joints[j].mean_3d_mm);
  }
}

TEST(Metrics, SayWhichLandmarksWereDropped) {
  const Convention icg = convention_from_name("icg20");
  const Convention mediapipe = convention_from_name("mediapipe21");
  const MethodScore result = score_of(truth_of(mediapipe, random_poses(mediapipe, 3, 8, 0.0, 9.0)),
                                      predictions_of(icg, random_poses(icg, 3, 9, 0.0, 9.0)));
  EXPECT_THAT(result.only_in_truth, ElementsAre(Landmark::wrist, Landmark::thumb_cmc));
  EXPECT_THAT(result.only_in_predictions, ElementsAre(Landmark::palm));
  EXPECT_EQ(result.joints.size(), 19u);
  EXPECT_EQ(result.missing, 0);
}

TEST(Metrics, OfAMethodThatPredictsNothingAreFailures) {
  const Convention convention = convention_from_name("icg20");
  const MethodScore result =
      score_of(truth_of(convention, random_poses(convention, 5, 10, 0.0, 9.0)),
               predictions_of(convention, std::vector(5, HandPose::missing(convention))));
  EXPECT_EQ(result.missing, 5);
  EXPECT_TRUE(std::isnan(result.mean_3d_mm));
  EXPECT_EQ(result.auc_pck_0_50, 0.0);
  EXPECT_THAT(result.curves.all_joints_within, ::testing::Each(0.0));
}

TEST(Metrics, UseTheCameraOfEachFrame) {
  const Convention convention = convention_from_name("nyu14");
  Camera finer = simple_projection().camera();
  finer.fx = 200.0;
  Truth truth = truth_of(convention, {pose_of({{0.0, 0.0, 100.0}}), pose_of({{0.0, 0.0, 100.0}})});
  truth.projections = {simple_projection(), Projection(finer)};
  const MethodScore result = score_of(
      truth, predictions_of(convention, {pose_of({{8.0, 0.0, 100.0}}), pose_of({{8.0, 0.0, 100.0}})}));
  EXPECT_THAT(result.frame_mean_3d_mm, ElementsAre(8.0, 4.0));
}

TEST(Metrics, RefuseWhatCannotBeCompared) {
  const Convention nyu = convention_from_name("nyu14");
  const Convention icvl = convention_from_name("icvl16");
  const Convention mediapipe = convention_from_name("mediapipe21");
  const Truth truth = truth_of(nyu, random_poses(nyu, 4, 11, 0.0, 9.0));
  EXPECT_THAT(error_of([&] { joint_errors(truth, predictions_of(nyu, random_poses(nyu, 3, 12, 0.0, 9.0))); }),
              AllOf(HasSubstr("method.txt"), HasSubstr("3 frames"), HasSubstr("has 4")));
  EXPECT_THAT(error_of([&] { joint_errors(truth, predictions_of(nyu, random_poses(nyu, 5, 12, 0.0, 9.0))); }),
              AllOf(HasSubstr("method.txt"), HasSubstr("5 frames")));
  const Truth other = truth_of(mediapipe, random_poses(mediapipe, 4, 11, 0.0, 9.0));
  EXPECT_THAT(
      error_of([&] { joint_errors(other, predictions_of(icvl, random_poses(icvl, 4, 12, 0.0, 9.0))); }),
      AllOf(HasSubstr("method.txt"), HasSubstr("icvl16"), HasSubstr("mediapipe21")));
  const Truth unknown = truth_of(nyu, std::vector(4, HandPose::missing(nyu)));
  EXPECT_THAT(
      error_of([&] { joint_errors(unknown, predictions_of(nyu, random_poses(nyu, 4, 12, 0.0, 9.0))); }),
      HasSubstr("truth.txt"));
}

}  // namespace
}  // namespace knuckle
