// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/angle_figures.h"

#include "knuckle/core/angle.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/hand_angles.h"

namespace knuckle {
namespace {

HandRecord hand_with(int id, double index_pip_degrees) {
  HandRecord hand;
  hand.id = id;
  for (int i = 0; i < kHandAngleCount; ++i) {
    const auto angle = static_cast<HandAngle>(i);
    hand.angles_rad.emplace_back(name_of(angle),
                                 angle == HandAngle::index_pip ? index_pip_degrees * kDegree : 0.1);
  }
  return hand;
}

FrameRecord frame_with(std::vector<HandRecord> hands, std::optional<double> time_s = std::nullopt) {
  FrameRecord frame;
  frame.time_s = time_s;
  frame.hands = std::move(hands);
  return frame;
}

const Figure& figure_named(const std::vector<Figure>& figures, const std::string& name) {
  return *std::ranges::find(figures, name, &Figure::name);
}

TEST(AngleFigures, FollowEachHandInDegreesWithGapsWhereItWasNotFitted) {
  HandRecord unfitted;
  unfitted.id = 1;
  const std::vector<NamedRecords> records{
      {"a",
       {frame_with({hand_with(1, 10.0)}), frame_with({hand_with(2, 50.0), unfitted}), frame_with({}),
        frame_with({hand_with(1, 40.0)})}}};
  const std::vector<Figure> figures = angle_figures(records);
  ASSERT_EQ(figures.size(), static_cast<std::size_t>(kHandAngleCount));
  const Figure& figure = figure_named(figures, "angle_index_pip");
  EXPECT_EQ(figure.x, (std::vector{0.0, 1.0, 2.0, 3.0}));
  EXPECT_EQ(figure.x_label, "frame");
  ASSERT_EQ(figure.series.size(), 2u);
  EXPECT_EQ(figure.series[0].name, "a, hand 1");
  EXPECT_NEAR(figure.series[0].values[0], 10.0, 1e-9);
  EXPECT_TRUE(std::isnan(figure.series[0].values[1]));
  EXPECT_TRUE(std::isnan(figure.series[0].values[2]));
  EXPECT_NEAR(figure.series[0].values[3], 40.0, 1e-9);
  EXPECT_NEAR(figure.series[1].values[1], 50.0, 1e-9);
  for (const Figure& each : figures) {
    ASSERT_TRUE(each.y) << each.name;
    EXPECT_LT(each.y->begin, each.y->end) << each.name;
  }
}

TEST(AngleFigures, TheAxisHoldsWhatAHealthyHandCannotDo) {
  const std::vector<NamedRecords> records{{"a", {frame_with({hand_with(1, 200.0)}), frame_with({})}}};
  EXPECT_EQ(figure_named(angle_figures(records), "angle_index_pip").y->end, 210.0);
}

TEST(AngleFigures, StandInTimeWhereItIsKnownAndRises) {
  std::vector<NamedRecords> records{{"a",
                                     {frame_with({hand_with(1, 0.0)}, 5.0), FrameRecord(),
                                      frame_with({}, 5.5), frame_with({hand_with(1, 0.0)}, 7.0)}}};
  Figure figure = angle_figures(records).front();
  EXPECT_EQ(figure.x_label, "time (s)");
  EXPECT_EQ(figure.x, (std::vector{0.0, 0.5, 2.0})) << "a frame that nothing is known of is none";
  records[0].frames[3].time_s = 5.2;
  EXPECT_EQ(angle_figures(records).front().x_label, "frame") << "time went back";
  records[0].frames[3].time_s = std::nullopt;
  EXPECT_EQ(angle_figures(records).front().x_label, "frame") << "a hand without time";
}

TEST(AngleFigures, ATimeThatIsNoNumberIsNone) {
  std::vector<NamedRecords> records{
      {"a", {frame_with({hand_with(1, 0.0)}, kNaN), frame_with({hand_with(1, 0.0)}, kNaN)}},
      {"b", {frame_with({hand_with(1, 0.0)}, 3.0), frame_with({hand_with(1, 0.0)}, 3.5)}}};
  const Figure figure = angle_figures(records).front();
  EXPECT_EQ(figure.x_label, "time (s)") << "the second method knows it";
  EXPECT_EQ(figure.x, (std::vector{0.0, 0.5}));
}

TEST(AngleFigures, OfManyHandsThoseThatWereFollowedLongest) {
  NamedRecords method{"a", {}};
  for (int id = 1; id <= 20; ++id) {
    for (int frame = 0; frame < (id % 2 == 0 && id <= 12 ? 3 : 1); ++frame)
      method.frames.push_back(frame_with({hand_with(id, 0.0)}));
  }
  const Figure figure = angle_figures(std::span(&method, 1)).front();
  std::vector<std::string> names;
  for (const Series& series : figure.series) names.push_back(series.name);
  EXPECT_THAT(names, ::testing::ElementsAre("a, hand 1", "a, hand 2", "a, hand 4", "a, hand 6", "a, hand 8",
                                            "a, hand 10", "a, hand 12"));
}

TEST(AngleFigures, OfALongSequenceEveryNthFrame) {
  const NamedRecords method{"a", std::vector<FrameRecord>(4000, frame_with({hand_with(1, 0.0)}))};
  const Figure figure = angle_figures(std::span(&method, 1)).front();
  EXPECT_EQ(figure.x.size(), 1334u);
  EXPECT_EQ(figure.x[1], 3.0);
  EXPECT_EQ(figure.x_label, "frame, one of 3 frames");
}

TEST(AngleFigures, ASingleFrameMakesNoCurve) {
  NamedRecords method{"a", {frame_with({hand_with(1, 10.0)}, 0.5)}};
  EXPECT_TRUE(angle_figures(std::span(&method, 1)).empty());
  method.frames.emplace_back();  // nothing is known of it
  EXPECT_TRUE(angle_figures(std::span(&method, 1)).empty());
}

TEST(AngleFigures, WithoutAFittedHandThereAreNone) {
  EXPECT_TRUE(angle_figures({}).empty());
  const NamedRecords method{"a", {frame_with({HandRecord()})}};
  EXPECT_TRUE(angle_figures(std::span(&method, 1)).empty());
}

}  // namespace
}  // namespace knuckle
