// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_fit.h"

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

using testing::bent_hand_points;
using testing::flesh_frame;
using testing::kLabelCamera;
using testing::LandmarkPoints;
using testing::mean_error_mm;
using testing::pose_of_points;

std::size_t at(Landmark landmark) {
  return static_cast<std::size_t>(landmark);
}

/// The index finger where the middle one is, as estimators confuse them.
std::vector<ImagePoint> confused(const LandmarkPoints& truth) {
  std::vector<ImagePoint> points = pose_of_points(truth).joints;
  for (int i = 1; i < 4; ++i)
    points[at(Landmark::index_mcp) + static_cast<std::size_t>(i)] =
        points[at(Landmark::middle_mcp) + static_cast<std::size_t>(i)];
  return points;
}

std::vector<LandmarkLabel> labels_at(const std::vector<ImagePoint>& points) {
  std::vector<LandmarkLabel> labels(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) labels[i].at = points[i];
  return labels;
}

LabelFit fit_of(const Frame& frame, const std::vector<LandmarkLabel>& labels,
                const std::vector<ImagePoint>& estimates, const LabelFitContext& context = {},
                HandSide side = HandSide::right) {
  const auto fit = fit_labels(frame, side, superset_convention(), labels, estimates, context);
  EXPECT_TRUE(fit);
  return fit.value_or(LabelFit());
}

TEST(LabelFit, OneCorrectionBringsTheWholeFingerBack) {
  const LandmarkPoints truth = bent_hand_points(0.5);
  const Frame frame = flesh_frame(truth);
  const std::vector<ImagePoint> estimates = confused(truth);
  std::vector<LandmarkLabel> labels = labels_at(estimates);
  const double before = mean_error_mm(fit_of(frame, labels, estimates).points, truth);
  labels[at(Landmark::index_tip)] = {.at = pose_of_points(truth).joints[at(Landmark::index_tip)],
                                     .state = LabelState::corrected};
  const LabelFit fit = fit_of(frame, labels, estimates);
  EXPECT_LT(mean_error_mm(fit.points, truth), 0.5 * before);
  const Point3 pip = Projection(kLabelCamera).to_camera(fit.points[at(Landmark::index_pip)]);
  EXPECT_LT((pip - truth[at(Landmark::index_pip)]).norm(), 8.0) << "nobody touched it";
}

TEST(LabelFit, WhatAPersonAnswersForHoldsTheSkeleton) {
  const LandmarkPoints truth = bent_hand_points(0.4);
  const Frame frame = flesh_frame(truth);
  std::vector<ImagePoint> estimates = pose_of_points(truth).joints;
  for (ImagePoint& point : estimates) point.u += 6.0;  // 22 mm beside
  std::vector<LandmarkLabel> labels = labels_at(estimates);
  for (const Landmark landmark :
       {Landmark::wrist, Landmark::middle_tip, Landmark::thumb_tip, Landmark::little_tip})
    labels[at(landmark)] = {.at = pose_of_points(truth).joints[at(landmark)], .state = LabelState::corrected};
  const LabelFit fit = fit_of(frame, labels, estimates);
  for (const Landmark landmark :
       {Landmark::wrist, Landmark::middle_tip, Landmark::thumb_tip, Landmark::little_tip}) {
    const Point3 point = Projection(kLabelCamera).to_camera(fit.points[at(landmark)]);
    EXPECT_LT((point - truth[at(landmark)]).norm(), 4.0) << name_of(landmark);
  }
  const auto moved = with_fit(labels, fit, LabelState::estimated);
  EXPECT_EQ(moved[at(Landmark::wrist)], labels[at(Landmark::wrist)]) << "it stays where the person put it";
  EXPECT_EQ(moved[at(Landmark::ring_tip)].at.u, fit.points[at(Landmark::ring_tip)].u);
}

TEST(LabelFit, HiddenLandmarksComeFromTheModelAlone) {
  const LandmarkPoints truth = bent_hand_points(0.4);
  const Frame frame = flesh_frame(truth);
  std::vector<ImagePoint> estimates = pose_of_points(truth).joints;
  estimates[at(Landmark::ring_pip)].u += 30.0;
  std::vector<LandmarkLabel> labels = labels_at(estimates);
  const auto error = [&] {
    const Point3 point =
        Projection(kLabelCamera).to_camera(fit_of(frame, labels, estimates).points[at(Landmark::ring_pip)]);
    return (point - truth[at(Landmark::ring_pip)]).norm();
  };
  const double seen = error();
  labels[at(Landmark::ring_pip)].is_visible = false;
  EXPECT_LT(error(), 6.0);
  EXPECT_GT(seen, 2.0 * error());
}

TEST(LabelFit, ALeftHandIsARightOneInTheMirror) {
  const LandmarkPoints truth = bent_hand_points(0.5);
  const Frame frame = flesh_frame(truth);
  const Frame mirror = mirrored(frame);
  const std::vector<ImagePoint> estimates = confused(truth);
  HandPose pose{superset_convention(), estimates, {}};
  const std::vector<ImagePoint> in_mirror = mirrored(pose, kLabelCamera.width).joints;
  const LabelFit right = fit_of(frame, labels_at(estimates), estimates);
  const LabelFit left = fit_of(mirror, labels_at(in_mirror), in_mirror, {}, HandSide::left);
  for (std::size_t i = 0; i < right.points.size(); ++i)
    EXPECT_NEAR(left.points[i].u, kLabelCamera.width - 1 - right.points[i].u, 0.6)
        << i;  // other pixels are looked at
}

TEST(LabelFit, FewerThanThreeLandmarksAreNoHand) {
  const LandmarkPoints truth = bent_hand_points(0.4);
  std::vector<LandmarkLabel> labels(kSupersetSize);
  const std::vector<ImagePoint> none(kSupersetSize);
  const auto joints = pose_of_points(truth).joints;
  for (const Landmark landmark : {Landmark::wrist, Landmark::middle_tip})
    labels[at(landmark)] = {.at = joints[at(landmark)], .state = LabelState::corrected};
  EXPECT_FALSE(fit_labels(flesh_frame(truth), HandSide::right, superset_convention(), labels, none, {}));
  labels[at(Landmark::thumb_tip)] = {.at = joints[at(Landmark::thumb_tip)], .state = LabelState::corrected};
  const auto fit = fit_labels(flesh_frame(truth), HandSide::right, superset_convention(), labels, none, {});
  ASSERT_TRUE(fit);
  EXPECT_FALSE(std::ranges::any_of(fit->points, &ImagePoint::is_missing)) << "the model gives the others";
}

TEST(PersonBones, VerifiedHandsMakeTheirSizeKnown) {
  const LandmarkPoints truth = bent_hand_points(0.4, 0.85);
  const Frame frame = flesh_frame(truth);
  const std::vector<ImagePoint> joints = pose_of_points(truth).joints;
  std::vector<LandmarkLabel> verified = labels_at(joints);
  for (LandmarkLabel& label : verified) label.state = LabelState::verified;
  PersonBones bones;
  SkeletonFitOptions before;
  bones.tell(before);
  EXPECT_EQ(before.size, 1.0);
  double spread = before.size_spread;
  for (std::int64_t frame_number = 0; frame_number < 3; ++frame_number) {
    bones.learn({frame_number}, fit_of(frame, verified, joints).pose);
    SkeletonFitOptions options;
    bones.tell(options);
    EXPECT_NEAR(options.size, 0.85, 0.02);
    EXPECT_LT(options.size_spread, spread) << "each makes it surer";
    spread = options.size_spread;
  }
  for (std::int64_t frame_number = 0; frame_number < 3; ++frame_number) bones.forget({frame_number});
  EXPECT_EQ(bones.size(), 0U);
}

}  // namespace
}  // namespace knuckle
