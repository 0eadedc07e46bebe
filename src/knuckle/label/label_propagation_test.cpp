// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_propagation.h"

#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

using testing::kLabelCamera;

const Projection kProjection(kLabelCamera);

std::vector<ImagePoint> at_depth(double depth_mm) {
  return {{70, 50, depth_mm}, {80, 60, depth_mm}};
}

std::vector<LandmarkLabel> labels_at_depth(double depth_mm) {
  std::vector<LandmarkLabel> labels(2);
  for (std::size_t i = 0; i < labels.size(); ++i)
    labels[i] = {.at = at_depth(depth_mm)[i], .state = LabelState::verified};
  return labels;
}

LabelFit fit_with_angle(double radians) {
  LabelFit fit;
  fit.pose.angles.radians[3] = radians;
  return fit;
}

TEST(LabelPropagation, AnEstimateIsMendedAsTheOneBesideItAndLessSoFarAway) {
  const std::vector<LandmarkLabel> labels = labels_at_depth(520.0);  // 20 mm behind what was estimated
  double last_mm = 20.0;
  for (const int away : {1, 3, 10, 30}) {
    const auto mended = estimates_beside(kProjection, at_depth(510.0),
                                         {{.away = away, .labels = &labels, .estimates = at_depth(500.0)}});
    const double moved_mm = mended[1].depth_mm - 510.0;
    EXPECT_LT(moved_mm, last_mm);
    EXPECT_GT(moved_mm, 0.0);
    last_mm = moved_mm;
    if (away == 1) {
      EXPECT_GT(moved_mm, 18.0);
    }
  }
  EXPECT_LT(last_mm, 4.0);
}

TEST(LabelPropagation, WhatSeveralAnchorsSayIsAveraged) {
  const std::vector<LandmarkLabel> nearer = labels_at_depth(490.0);
  const std::vector<LandmarkLabel> farther = labels_at_depth(510.0);
  const auto mended =
      estimates_beside(kProjection, at_depth(500.0),
                       {{.away = 2, .is_before = true, .labels = &nearer, .estimates = at_depth(500.0)},
                        {.away = 2, .is_before = false, .labels = &farther, .estimates = at_depth(500.0)}});
  EXPECT_NEAR(mended[0].depth_mm, 500.0, 1e-9);
}

TEST(LabelPropagation, WithoutAnEstimateTheNearestAnchorsLabelsCount) {
  const std::vector<LandmarkLabel> near = labels_at_depth(520.0);
  const std::vector<LandmarkLabel> far = labels_at_depth(600.0);
  const std::vector<ImagePoint> none(2);
  const auto found = estimates_beside(kProjection, none,
                                      {{.away = 5, .labels = &far, .estimates = none},
                                       {.away = 2, .is_before = false, .labels = &near, .estimates = none}});
  EXPECT_EQ(found[0].depth_mm, 520.0);
}

TEST(LabelPropagation, AnglesAreExpectedOnTheWayBetweenTheNearestAnchors) {
  const LabelFit before = fit_with_angle(0.2);
  const LabelFit after = fit_with_angle(0.8);
  const LabelFit far = fit_with_angle(5.0);
  const std::vector<LandmarkLabel> labels = labels_at_depth(500.0);
  const std::vector<LabelAnchor> anchors{
      {.away = 1, .is_before = true, .fit = &before, .labels = &labels, .estimates = {}},
      {.away = 9, .is_before = true, .fit = &far, .labels = &labels, .estimates = {}},
      {.away = 2, .is_before = false, .fit = &after, .labels = &labels, .estimates = {}}};
  const LabelFitContext context = context_beside({}, anchors);
  EXPECT_NEAR(context.expected->radians[3], 0.4, 1e-12) << "a third of the way";
  EXPECT_EQ(context.start->angles.radians[3], 0.2) << "it begins at the nearer one";
  const LabelFitContext of_one = context_beside({}, {anchors[2]});
  EXPECT_NEAR(of_one.expected->radians[3], 0.8, 1e-12);
  EXPECT_GT(of_one.expected_rad, context.expected_rad) << "two say it more surely";
}

}  // namespace
}  // namespace knuckle
