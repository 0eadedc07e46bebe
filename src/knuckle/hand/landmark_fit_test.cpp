// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/landmark_fit.h"

#include <cmath>

#include <Eigen/Geometry>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/hand/skeleton_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

/// Hands in random postures, labelled by a definition with noise; every tenth label is far off.
std::vector<LabelledPoints> labelled_hands(const LandmarkDefinition& definition, int count, double noise_mm,
                                           bool has_outliers, HandSide side = HandSide::right) {
  Random random(7);
  std::vector<LabelledPoints> frames;
  for (int i = 0; i < count; ++i) {
    const HandSkeleton& adult = adult_skeleton();
    const HandAngles angles = testing::random_angles(adult.limits, random);
    RigidTransform pose = RigidTransform::Identity();
    pose.linear() = Eigen::AngleAxisd(random.uniform(-3.0, 3.0), Eigen::Vector3d::UnitY()).toRotationMatrix();
    pose.translation() = Point3(0, 0, 500);
    LabelledPoints frame{landmarks(adult, angles, pose), side, {}};
    if (side == HandSide::left) {
      for (Point3& point : frame.estimated) point.x() = -point.x();
    }
    frame.labelled = definition.on(frame.estimated, side);
    for (Point3& label : frame.labelled) {
      label += noise_mm * Point3(random.normal(), random.normal(), random.normal());
      if (has_outliers && i % 10 == 0) label += Point3(150, 0, 0);
    }
    frames.push_back(frame);
  }
  return frames;
}

LandmarkDefinition some_definition() {
  LandmarkDefinition definition = LandmarkDefinition::plain(convention_from_name("mediapipe21"));
  for (std::size_t i = 0; i < definition.landmarks.size(); ++i) {
    const auto number = static_cast<double>(i);
    definition.landmarks[i].offset = {0.01 * number, -0.1 + 0.01 * number, 0.05};
    definition.landmarks[i].bent = Eigen::Vector3d(0.05, 0.01 * number, -0.1);
  }
  return definition;
}

TEST(LandmarkFitTest, FindsTheDefinitionThatLabelsWereMadeWith) {
  const LandmarkDefinition truth = some_definition();
  for (const HandSide side : {HandSide::right, HandSide::left}) {
    const auto frames = labelled_hands(truth, 30, 0.0, false, side);
    const LandmarkFit fit = fit_landmarks(LandmarkDefinition::plain(truth.convention), frames);
    for (std::size_t i = 0; i < truth.landmarks.size(); ++i) {
      EXPECT_LT((fit.definition.landmarks[i].offset - truth.landmarks[i].offset).norm(), 1e-4);
      EXPECT_LT((*fit.definition.landmarks[i].bent - *truth.landmarks[i].bent).norm(), 1e-4);
      EXPECT_EQ(fit.landmarks[i].frames, 30);
      EXPECT_GT(fit.landmarks[i].before_mm, 1.0);
    }
    EXPECT_LT(fit.all.after_mm, 1e-4);
    EXPECT_LT(fit.all.validated_mm, 1e-4);
  }
}

TEST(LandmarkFitTest, AFewFramesThatAreWrongHardlyMatter) {
  const LandmarkDefinition truth = some_definition();
  const LandmarkFit fit =
      fit_landmarks(LandmarkDefinition::plain(truth.convention), labelled_hands(truth, 100, 1.0, true));
  for (std::size_t i = 0; i < truth.landmarks.size(); ++i) {
    EXPECT_LT((fit.definition.landmarks[i].offset - truth.landmarks[i].offset).norm(), 0.01);  // 0.9 mm
  }
  EXPECT_GT(fit.all.before_mm, fit.all.after_mm);
  EXPECT_GE(fit.all.validated_mm, fit.all.after_mm);
}

/// What the fit makes least, of one landmark's two offsets; wanted are the labels' places.
double fitted_sum(const std::vector<LabelledPoints>& frames, const LandmarkDefinition& definition) {
  double sum = 0.0;
  const DefinedLandmark& defined = definition.landmarks[5];
  for (const LabelledPoints& frame : frames) {
    const std::vector<Point3> points = definition.on(frame.estimated, frame.side);
    sum += (points[5] - frame.labelled[5]).norm() / palm_length(frame.estimated);
  }
  return sum + 0.5 * kStartWeight * (defined.offset.squaredNorm() + defined.bent->squaredNorm());
}

TEST(LandmarkFitTest, HasTheLeastSumOfDistancesAndTheStartsPull) {
  const auto frames = labelled_hands(some_definition(), 40, 5.0, false);
  const LandmarkFit fit =
      fit_landmarks(LandmarkDefinition::plain(convention_from_name("mediapipe21")), frames);
  const double least = fitted_sum(frames, fit.definition);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double step : {-1e-3, 1e-3}) {
      LandmarkDefinition other = fit.definition;
      other.landmarks[5].offset[axis] += step;
      EXPECT_LT(least, fitted_sum(frames, other)) << axis;
      other = fit.definition;
      (*other.landmarks[5].bent)[axis] += step;
      EXPECT_LT(least, fitted_sum(frames, other)) << axis;
    }
  }
}

TEST(LandmarkFitTest, GoesOnFromItsStart) {
  LandmarkDefinition start = LandmarkDefinition::plain(convention_from_name("icvl16"));
  start.landmarks[6] = {Landmark::index_dip, {0.1, 0.0, 0.0}, Landmark::index_pip, 0.5};
  const LandmarkFit fit = fit_landmarks(start, labelled_hands(start, 20, 0.0, false));
  EXPECT_EQ(fit.definition.landmarks[6].towards, Landmark::index_pip);
  EXPECT_LT((fit.definition.landmarks[6].offset - start.landmarks[6].offset).norm(), 1e-9);
  EXPECT_LT((*fit.definition.landmarks[6].bent - start.landmarks[6].offset).norm(), 1e-9);
  EXPECT_GT(fit.landmarks[6].before_mm, 5.0);
}

TEST(LandmarkFitTest, CrossValidationTellsWhatWasLearnedByHeart) {
  const LandmarkDefinition plain = LandmarkDefinition::plain(convention_from_name("icg20"));
  const LandmarkFit fit = fit_landmarks(plain, labelled_hands(plain, 14, 10.0, false));
  EXPECT_LT(fit.all.after_mm, fit.all.before_mm);
  EXPECT_GT(fit.all.validated_mm, fit.all.before_mm) << "noise cannot be learned";
}

TEST(LandmarkFitTest, LandmarksThatFewFramesKnowStayAndTooFewFramesAreRefused) {
  const LandmarkDefinition truth = some_definition();
  auto frames = labelled_hands(truth, 20, 0.0, false);
  for (std::size_t i = 0; i < 11; ++i) frames[i].labelled[3] = Point3::Constant(kNaN);
  const LandmarkFit fit = fit_landmarks(LandmarkDefinition::plain(truth.convention), frames);
  EXPECT_EQ(fit.definition.landmarks[3].offset, Eigen::Vector3d::Zero());
  EXPECT_EQ(fit.landmarks[3].frames, 9);
  EXPECT_TRUE(std::isnan(fit.landmarks[3].after_mm));
  EXPECT_FALSE(fit.definition.landmarks[4].offset.isZero());
  frames.resize(9);
  EXPECT_THAT(error_of([&] { fit_landmarks(LandmarkDefinition::plain(truth.convention), frames); }),
              HasSubstr("10 frames"));
  EXPECT_THAT(error_of([&] { fit_landmarks(LandmarkDefinition::plain(truth.convention), {}); }),
              HasSubstr("10 frames"));
  EXPECT_THAT(
      error_of([&] { fit_landmarks(LandmarkDefinition::plain(convention_from_name("icg20")), frames); }),
      HasSubstr("labels"));
}

}  // namespace
}  // namespace knuckle
