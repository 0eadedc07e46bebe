// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/coordinate_check.h"

#include <fmt/format.h>

#include "knuckle/core/testing.h"
#include "knuckle/eval/metrics/eval_fixtures.h"

namespace knuckle {
namespace {

using testing::example_predictions;
using testing::example_truth;

/// The numbers that another program would write for poses, read as u v d.
PoseNumbers written_as(const PoseCoordinates& coordinates, const Truth& truth,
                       const Predictions& predictions) {
  PoseNumbers numbers{"mine.txt", predictions.sequence.convention, {}, {}};
  for (const HandPose& pose : predictions.sequence.poses) {
    for (const ImagePoint& joint : pose.joints) {
      Eigen::Vector3d written(joint.u, joint.v, joint.depth_mm / coordinates.unit_mm);
      if (coordinates.kind == PoseCoordinates::Kind::xyz)
        written = coordinates.axes.transpose() * truth.projection(0).to_camera(joint) / coordinates.unit_mm;
      numbers.values.insert(numbers.values.end(), written.begin(), written.end());
    }
  }
  return numbers;
}

TEST(LikelyCoordinatesTest, FindsWhatTheNumbersAre) {
  const Truth truth = example_truth(130);
  const Predictions predictions = example_predictions(truth, "mine", 12.0);
  for (const char* axes : {"x,y,z", "x,-y,z", "x,-y,-z"}) {
    for (const double unit_mm : {1.0, 10.0, 1000.0}) {
      const PoseCoordinates written{PoseCoordinates::Kind::xyz, axes_from_text(axes), unit_mm};
      const auto likely = likely_coordinates(truth, written_as(written, truth, predictions));
      ASSERT_TRUE(likely) << as_options(written);
      EXPECT_EQ(as_options(likely->coordinates), as_options(written));
      EXPECT_LT(likely->median_mm, 20.0);
      EXPECT_GT(likely->median_as_read_mm, 100.0);
    }
  }
  const PoseCoordinates in_metres{PoseCoordinates::Kind::uvd, Eigen::Matrix3d::Identity(), 1000.0};
  const auto likely = likely_coordinates(truth, written_as(in_metres, truth, predictions));
  ASSERT_TRUE(likely);
  EXPECT_EQ(as_options(likely->coordinates), "--format uvd --unit m");
}

TEST(LikelyCoordinatesTest, SaysNothingOfWhatIsReadAsItShouldBe) {
  const Truth truth = example_truth(20);
  for (const double deviation_mm : {0.0, 12.0, 300.0}) {  // however bad the method is
    const Predictions predictions = example_predictions(truth, "mine", deviation_mm);
    EXPECT_FALSE(likely_coordinates(truth, written_as({}, truth, predictions))) << deviation_mm;
    PoseNumbers numbers = written_as({PoseCoordinates::Kind::xyz}, truth, predictions);
    numbers.coordinates.kind = PoseCoordinates::Kind::xyz;
    EXPECT_FALSE(likely_coordinates(truth, numbers)) << deviation_mm;
  }
}

TEST(LikelyCoordinatesTest, SaysNothingWhereAnotherReadingIsBetterButBad) {
  const Truth truth = example_truth(20);
  const PoseCoordinates upwards{PoseCoordinates::Kind::xyz, axes_from_text("x,-y,z"), 1.0};
  const auto likely_of = [&](double deviation_mm) {
    PoseNumbers numbers = written_as(upwards, truth, example_predictions(truth, "mine", deviation_mm));
    numbers.coordinates.kind = PoseCoordinates::Kind::xyz;
    return likely_coordinates(truth, numbers);
  };
  const auto near = likely_of(2.0);
  ASSERT_TRUE(near);
  EXPECT_GT(near->median_as_read_mm, 40.0);
  EXPECT_FALSE(likely_of(near->median_as_read_mm / 2.0));
}

TEST(LikelyCoordinatesTest, SaysNothingWhereNothingCanBeCompared) {
  const Truth truth = example_truth(20);
  const Predictions predictions = example_predictions(truth, "mine", 1.0);
  const PoseNumbers in_space = written_as({PoseCoordinates::Kind::xyz}, truth, predictions);
  EXPECT_FALSE(
      likely_coordinates(example_truth(19), in_space));  // another number of frames: an error elsewhere
  PoseNumbers unknown = in_space;
  std::ranges::fill(unknown.values, kNaN);
  EXPECT_FALSE(likely_coordinates(truth, unknown));
}

}  // namespace
}  // namespace knuckle
