// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_smoothing.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

constexpr Camera kCamera{.width = 320, .height = 240, .fx = 270, .fy = 260, .cx = 160, .cy = 120};
constexpr std::size_t kFirst = 0;
constexpr std::size_t kSecond = 1;

/// Frames without images; their times and sequences are what a test says.
class TimedFrames final : public FrameSource {
 public:
  using Say = std::function<void(std::int64_t, FrameLabel&)>;
  explicit TimedFrames(
      std::int64_t frames, Say say = [](std::int64_t, FrameLabel&) {})
      : frames_(frames), say_(std::move(say)) {}
  std::int64_t size() const override { return frames_; }
  Frame read(std::int64_t) const override { return {}; }
  FrameLabel read_label(std::int64_t index) const override {
    FrameLabel label;
    label.camera = kCamera;
    say_(index, label);
    return label;
  }
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  std::int64_t frames_;
  Say say_;
};

LabelHead head_of(std::int64_t frames) {
  return {.source = "timed:frames",
          .fingerprint = "01",
          .frames = frames,
          .convention = superset_convention(),
          .camera = kCamera};
}

Point3 on_parabola(double time) {
  return Point3(-40.0, 20.0, 500.0) + time * Point3(4.0, -3.0, 2.0) + time * time * Point3(-0.2, 0.1, 0.3);
}

TEST(LabelSmoothing, ReachesOverOneFrameAtLeastAndNotTooMany) {
  const TimedFrames source(3);
  const LabelBook book(head_of(3));
  for (const int reach : {0, -1, 101}) {
    EXPECT_THAT(error_of([&] { smoothed_labels(source, book, LabelState::verified, reach); }),
                HasSubstr(fmt::format("{} were asked for", reach)));
  }
}

/// Labels of the first landmark at `place`, of the second 30 mm beside it; the rest is not labelled.
LabelChange labels_at(HandKey hand, const Point3& place, LabelState state = LabelState::verified) {
  LabelChange change{.frame = hand.frame, .side = hand.side, .act = LabelAct::verify};
  change.landmarks.resize(superset_convention().landmarks.size());
  const Projection projection(kCamera);
  change.landmarks[kFirst] = {.at = projection.to_image(place), .state = state};
  change.landmarks[kSecond] = {.at = projection.to_image(place + Point3(30.0, 0.0, 0.0)), .state = state};
  return change;
}

Point3 place_in(const SmoothedLabels& labels, HandKey hand, std::size_t landmark = kFirst) {
  return Projection(kCamera).to_camera(labels.at(hand).at(landmark));
}

void expect_near(const Point3& found, const Point3& expected, double within_mm) {
  EXPECT_LT((found - expected).norm(), within_mm) << found.transpose() << "; " << expected.transpose();
}

TEST(LabelSmoothing, WhatMovesAlongAParabolaStays) {
  const TimedFrames source(30);
  LabelBook book(head_of(30));
  for (std::int64_t i = 0; i < 30; ++i) book.add(labels_at({i}, on_parabola(static_cast<double>(i))));
  for (const int reach : {3, 4, 30}) {
    const SmoothedLabels smoothed = smoothed_labels(source, book, LabelState::verified, reach);
    ASSERT_EQ(smoothed.size(), 30U);
    for (std::int64_t i = 0; i < 30; ++i) {
      expect_near(place_in(smoothed, {i}), on_parabola(static_cast<double>(i)), 1e-6);
      expect_near(place_in(smoothed, {i}, kSecond),
                  on_parabola(static_cast<double>(i)) + Point3(30.0, 0.0, 0.0), 1e-6);
      EXPECT_TRUE(smoothed.at({i}).at(2).is_missing());
    }
  }
}

/// Of every fourth frame none was taken: it moves evenly in time, and not from frame to frame.
TEST(LabelSmoothing, TimeIsThatOfTheFrames) {
  const auto time = [](std::int64_t i) { return static_cast<double>(i + i / 3); };
  LabelBook book(head_of(24));
  for (std::int64_t i = 0; i < 24; ++i) book.add(labels_at({i}, on_parabola(time(i))));
  const TimedFrames timed(24, [&](std::int64_t i, FrameLabel& label) { label.time_s = time(i) / 30.0; });
  const SmoothedLabels smoothed = smoothed_labels(timed, book, LabelState::verified, 5);
  for (std::int64_t i = 0; i < 24; ++i) expect_near(place_in(smoothed, {i}), on_parabola(time(i)), 1e-6);

  // Where times do not say it, the frames' numbers do; nothing breaks.
  for (const TimedFrames::Say& say :
       {TimedFrames::Say([](std::int64_t, FrameLabel&label) { label.time_s = 7.0; }),
        TimedFrames::Say([&](std::int64_t i, FrameLabel&label) {
          if (i != 5) label.time_s = time(i);
        })}) {
    const SmoothedLabels other = smoothed_labels(TimedFrames(24, say), book, LabelState::verified, 5);
    EXPECT_GT((place_in(other, {8}) - on_parabola(time(8))).norm(), 0.1);
    expect_near(place_in(other, {8}), on_parabola(time(8)), 5.0);
  }
}

TEST(LabelSmoothing, TrembleAveragesOut) {
  const TimedFrames source(60);
  LabelBook book(head_of(60));
  Random random(8, 0);
  double before = 0.0;
  for (std::int64_t i = 0; i < 60; ++i) {
    const Point3 tremble(4.0 * random.normal(), 4.0 * random.normal(), 4.0 * random.normal());
    before += tremble.squaredNorm();
    book.add(labels_at({i}, on_parabola(0.5 * static_cast<double>(i)) + tremble));
  }
  const SmoothedLabels smoothed = smoothed_labels(source, book, LabelState::verified, 6);
  double after = 0.0;
  for (std::int64_t i = 0; i < 60; ++i)
    after += (place_in(smoothed, {i}) - on_parabola(0.5 * static_cast<double>(i))).squaredNorm();
  // A parabola through 13 weighted labels keeps 0.27 of the variance in the middle, more at both ends.
  EXPECT_LT(after, 0.45 * before);
  EXPECT_GT(after, 0.1 * before);
}

/// The labels of five frames, one of which lies aside, against the normal equations written out.
TEST(LabelSmoothing, EachLabelCountsAsMuchAsItCanBeTrusted) {
  const TimedFrames source(5);
  enum class Made : std::uint8_t { by_machine, by_click, by_guess };
  const auto smoothed_with = [&](Made made) {
    LabelBook book(head_of(5));
    for (std::int64_t i = 0; i < 5; ++i) {
      const Point3 place = Point3(0.0, 0.0, 500.0) + (i == 3 ? Point3(10.0, 0.0, 0.0) : Point3::Zero());
      const bool is_by_person = i == 3 && made != Made::by_machine;
      LabelChange change =
          labels_at({i}, place, is_by_person ? LabelState::corrected : LabelState::estimated);
      if (made == Made::by_guess) change.landmarks[kFirst].is_visible = i != 3;
      change.act = LabelAct::correct;
      book.add(change);
      for (LandmarkLabel& label : change.landmarks) label.state = LabelState::verified;
      change.act = LabelAct::verify;
      change.revision = 2;
      book.add(change);
    }
    return place_in(smoothed_labels(source, book, LabelState::verified, 2), {2}).x();
  };
  const auto expected_with = [](double deviation_mm) {
    Eigen::MatrixXd powers(5, 3);
    Eigen::VectorXd weights(5);
    Eigen::VectorXd places = Eigen::VectorXd::Zero(5);
    places[3] = 10.0;
    for (int i = 0; i < 5; ++i) {
      const double away = i - 2.0;
      powers.row(i) << 1.0, away, away * away;
      const double deviation = i == 3 ? deviation_mm : LabelFitOptions().estimate_mm;
      weights[i] = std::exp(-0.5 * std::pow(away / 1.2, 2.0)) / (deviation * deviation);
    }
    const Eigen::MatrixXd squares = powers.transpose() * weights.asDiagonal() * powers;
    return (squares.inverse() * (powers.transpose() * weights.asDiagonal() * places))[0];
  };
  const LabelFitOptions options;
  EXPECT_NEAR(smoothed_with(Made::by_machine), expected_with(options.estimate_mm), 1e-6);
  EXPECT_NEAR(smoothed_with(Made::by_click), expected_with(options.pin_mm), 1e-6);
  EXPECT_NEAR(smoothed_with(Made::by_guess), expected_with(options.guess_mm), 1e-6);
}

TEST(LabelSmoothing, OtherSequencesAndSidesDoNotCount) {
  const TimedFrames source(10, [](std::int64_t i, FrameLabel& label) { label.sequence = i < 5 ? 0 : 1; });
  LabelBook book(head_of(10));
  for (std::int64_t i = 0; i < 10; ++i) {
    book.add(labels_at({i}, Point3(i < 5 ? -50.0 : 50.0, 0.0, 500.0)));
    book.add(labels_at({i, HandSide::left}, Point3(0.0, i < 5 ? 40.0 : -40.0, 600.0)));
  }
  const SmoothedLabels smoothed = smoothed_labels(source, book, LabelState::verified, 8);
  for (std::int64_t i = 0; i < 10; ++i) {
    expect_near(place_in(smoothed, {i}), Point3(i < 5 ? -50.0 : 50.0, 0.0, 500.0), 1e-6);
    expect_near(place_in(smoothed, {i, HandSide::left}), Point3(0.0, i < 5 ? 40.0 : -40.0, 600.0), 1e-6);
  }
}

TEST(LabelSmoothing, FewLabelsAreALineOrStay) {
  const TimedFrames source(40);
  LabelBook book(head_of(40));
  for (const std::int64_t i : {0, 1}) book.add(labels_at({i}, on_parabola(static_cast<double>(i))));
  for (const std::int64_t i : {20, 21, 22}) book.add(labels_at({i}, Point3(i == 21 ? 8.0 : 0.0, 0.0, 500.0)));
  book.add(labels_at({30}, Point3(100.0, 0.0, 500.0), LabelState::estimated));
  const SmoothedLabels smoothed = smoothed_labels(source, book, LabelState::verified, 4);
  EXPECT_EQ(smoothed.size(), 5U) << "one hand is not sure enough";
  for (const std::int64_t i : {0, 1}) {
    const ImagePoint& at = book.find({i})->newest().landmarks[kFirst].at;
    EXPECT_EQ(smoothed.at({i})[kFirst].u, at.u);
    EXPECT_EQ(smoothed.at({i})[kFirst].depth_mm, at.depth_mm);
  }
  const double middle = place_in(smoothed, {21}).x();
  EXPECT_GT(middle, 2.0);
  EXPECT_LT(middle, 4.0) << "a third of what one of three lies aside, its own weight being the largest";
  EXPECT_EQ(smoothed_labels(source, book, LabelState::estimated, 4).size(), 6U);
}

TEST(LabelSmoothing, AReachOutOfRangeIsRefused) {
  const TimedFrames source(1);
  const LabelBook book(head_of(1));
  for (const int reach : {-1, 0, 101}) {
    EXPECT_THAT(error_of([&] { smoothed_labels(source, book, LabelState::verified, reach); }),
                HasSubstr("over 1 to 100 frames on both sides"));
  }
  EXPECT_TRUE(smoothed_labels(source, book, LabelState::verified, 100).empty());
}

}  // namespace
}  // namespace knuckle
