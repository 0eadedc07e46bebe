// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/labelled_source.h"

#include "knuckle/core/own_convention.h"
#include "knuckle/core/testing.h"
#include "knuckle/label/label_agreement.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

using testing::closing_hand_head;
using testing::ClosingHand;
using ::testing::HasSubstr;
using testing::kLabelCamera;
using testing::pose_of_points;

LabelChange truth_as_labels(const ClosingHand& source, HandKey hand, LabelState state,
                            double shift_px = 0.0) {
  LabelChange change{.frame = hand.frame, .side = hand.side, .act = LabelAct::verify};
  for (const ImagePoint& joint : pose_of_points(source.truth(hand.frame)).joints)
    change.landmarks.push_back({.at = {joint.u + shift_px, joint.v, joint.depth_mm}, .state = state});
  return change;
}

class LabelledSourceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    book_.add(truth_as_labels(source_, {0}, LabelState::verified));
    book_.add(truth_as_labels(source_, {1}, LabelState::corrected));
    book_.add(truth_as_labels(source_, {1, HandSide::left}, LabelState::verified, 30.0));
    book_.add(truth_as_labels(source_, {2}, LabelState::estimated));
  }

  ClosingHand source_{4};
  LabelBook book_{closing_hand_head(4)};
};

TEST_F(LabelledSourceTest, VerifiedHandsAreTheTruth) {
  const LabelledSource labelled(source_, book_, {});
  EXPECT_EQ(labelled.labelled_count(), 2);
  const Frame frame = labelled.read(0);
  ASSERT_TRUE(frame.truth);
  EXPECT_EQ(frame.side, HandSide::right);
  EXPECT_NEAR(frame.truth->joints[5].u, pose_of_points(source_.truth(0)).joints[5].u, 1e-9);
  EXPECT_EQ(labelled.read_label(0).truth->joints[5].u, frame.truth->joints[5].u);
  EXPECT_EQ(labelled.read_label(1).side, HandSide::left) << "the surer hand of the frame";
  EXPECT_FALSE(labelled.read(2).truth);
  EXPECT_FALSE(labelled.read(3).truth);
}

/// Whose pixels begin at their corner.
class CornerSource final : public FrameSource {
 public:
  std::int64_t size() const override { return hand_.size(); }
  Frame read(std::int64_t index) const override { return hand_.read(index); }
  FrameLabel read_label(std::int64_t index) const override { return hand_.read_label(index); }
  std::optional<Convention> convention() const override { return std::nullopt; }
  PixelOrigin pixel_origin() const override { return PixelOrigin::corner; }

 private:
  ClosingHand hand_{4};
};

TEST_F(LabelledSourceTest, PixelsBeginWhereTheSourcesDo) {
  EXPECT_EQ(LabelledSource(CornerSource(), book_, {}).pixel_origin(), PixelOrigin::corner);
  EXPECT_EQ(LabelledSource(source_, book_, {}).pixel_origin(), PixelOrigin::centre);
}

TEST_F(LabelledSourceTest, LessSureHandsAndOneSideCanBeAskedFor) {
  EXPECT_EQ(LabelledSource(source_, book_, {.least = LabelState::estimated}).labelled_count(), 3);
  const LabelledSource right(source_, book_, {.least = LabelState::corrected, .side = HandSide::right});
  EXPECT_EQ(right.labelled_count(), 2);
  EXPECT_EQ(right.read_label(1).side, HandSide::right);
}

TEST_F(LabelledSourceTest, BothHandsOfAFrameAreThere) {
  LabelChange look = book_.find({1, HandSide::left})->newest();
  look.act = LabelAct::look;
  look.revision = 2;
  look.landmarks[5].is_visible = false;
  book_.add(look);
  const LabelledSource labelled(source_, book_, {.least = LabelState::corrected});
  EXPECT_EQ(labelled.two_handed_count(), 1);
  const Frame frame = labelled.read(1);
  ASSERT_EQ(frame.hands.size(), 2U);
  EXPECT_EQ(frame.hands[0].side, HandSide::left) << "that of the truth first";
  EXPECT_EQ(frame.hands[0].pose.joints[5].u, frame.truth->joints[5].u);
  EXPECT_NEAR(frame.hands[1].pose.joints[5].u, pose_of_points(source_.truth(1)).joints[5].u, 1e-9);
  EXPECT_EQ(frame.hands[0].occluders[5], Occluder::own_hand) << "it is hidden";
  EXPECT_EQ(frame.hands[0].occluders[6], Occluder::none);
  EXPECT_EQ(frame.hands[1].occluders[5], Occluder::none);
  EXPECT_TRUE(labelled.read(0).hands.empty()) << "whether there is another hand nobody has said";
  EXPECT_EQ(LabelledSource(source_, book_, {}).two_handed_count(), 0) << "one of them is only corrected";
  const LabelledSource right(source_, book_, {.least = LabelState::corrected, .side = HandSide::right});
  EXPECT_TRUE(right.read(1).hands.empty());
}

TEST_F(LabelledSourceTest, HiddenLandmarksCanBeLeftOut) {
  LabelChange change = truth_as_labels(source_, {3}, LabelState::verified);
  change.landmarks[7].is_visible = false;
  book_.add(change);
  EXPECT_FALSE(LabelledSource(source_, book_, {}).read_label(3).truth->joints[7].is_missing());
  EXPECT_TRUE(
      LabelledSource(source_, book_, {.keeps_hidden = false}).read_label(3).truth->joints[7].is_missing());
}

TEST_F(LabelledSourceTest, EveryConventionIsServed) {
  const HandPose truth = pose_of_points(source_.truth(0));
  for (const Convention& convention : conventions()) {
    const LabelledSource labelled(source_, book_, {.convention = convention});
    const HandPose pose = *labelled.read_label(0).truth;
    EXPECT_EQ(pose.convention, convention);
    EXPECT_FALSE(pose.is_missing()) << convention.name;
    for (int i = 0; i < convention.size(); ++i) {
      const Landmark landmark = convention.landmarks[static_cast<std::size_t>(i)];
      if (static_cast<int>(landmark) >= kSupersetSize || definition_of_own_landmarks(convention)) continue;
      EXPECT_EQ(pose.joints[static_cast<std::size_t>(i)].u,
                truth.joints[static_cast<std::size_t>(landmark)].u);
    }
  }
}

std::shared_ptr<const LabelMask> mask_of_column(int column, int width = kLabelCamera.width) {
  Image<std::uint8_t> pixels(width, kLabelCamera.height);
  for (int row = 0; row < pixels.height(); ++row) pixels(column, row) = 1;
  return std::make_shared<const LabelMask>(mask_from_pixels_of_hand(pixels));
}

TEST_F(LabelledSourceTest, MasksAreThoseOfAllHandsThatCount) {
  EXPECT_TRUE(LabelledSource(source_, book_, {}).read(0).mask.empty()) << "nobody has painted";
  const auto brushed = [&](HandKey hand, int column) {
    LabelChange change = book_.find(hand)->newest();
    change.act = LabelAct::brush;
    change.revision += 1;
    change.mask = mask_of_column(column);
    book_.add(change);
  };
  brushed({1}, 20);
  brushed({1, HandSide::left}, 50);
  const LabelledSource verified(source_, book_, {});
  EXPECT_EQ(verified.without_mask_count(), 1) << "frame 0";
  EXPECT_EQ(std::ranges::count(verified.read(0).mask.pixels(), 1), 0);
  EXPECT_EQ(verified.read(1).mask, pixels_of(*mask_of_column(50))) << "the right one is only corrected";
  const Image<std::uint8_t> both =
      LabelledSource(source_, book_, {.least = LabelState::corrected}).read(1).mask;
  EXPECT_EQ(std::ranges::count(both.pixels(), 1), 2 * kLabelCamera.height);
  EXPECT_EQ(box_of(both), (Box{20, 0, 31, kLabelCamera.height}));
  const LabelledSource right(source_, book_, {.least = LabelState::corrected, .side = HandSide::right});
  EXPECT_EQ(right.read(1).mask, pixels_of(*mask_of_column(20)));
}

TEST_F(LabelledSourceTest, AMaskOfAnotherSizeIsRefused) {
  LabelChange change = book_.find({0})->newest();
  change.act = LabelAct::brush;
  change.revision += 1;
  change.mask = mask_of_column(3, 50);
  book_.add(change);
  EXPECT_THAT(testing::error_of([&] { LabelledSource(source_, book_, {}).read(0); }),
              HasSubstr(book_.head().source + ": frame 0: the mask of its labels is of 50x120 pixels"));
  change.revision += 1;
  change.mask =
      std::make_shared<const LabelMask>(mask_from_pixels_of_hand(Image<std::uint8_t>(kLabelCamera.width, 7)));
  book_.add(change);
  EXPECT_THAT(testing::error_of([&] { LabelledSource(source_, book_, {}).read(0); }), HasSubstr("160x7"));
}

TEST_F(LabelledSourceTest, TheSecondHandOfAFrameIsTheLessSureOne) {
  const LabelledSource second(source_, book_, {.least = LabelState::corrected, .takes_second = true});
  EXPECT_EQ(second.labelled_count(), 1);
  EXPECT_EQ(second.read_label(1).side, HandSide::right);
  EXPECT_FALSE(second.read_label(0).truth);
  EXPECT_EQ(LabelledSource(source_, book_, {.takes_second = true}).labelled_count(), 0);
}

TEST_F(LabelledSourceTest, LandmarksOfWhichLabelsSayNothingAreRefused) {
  const Convention& others = register_convention("knobs", {own_landmark("knob", Landmark::palm)});
  EXPECT_THAT(testing::error_of([&] { LabelledSource(source_, book_, {.convention = others}); }),
              HasSubstr("say nothing of the landmarks of knobs"));
}

TEST_F(LabelledSourceTest, LabelsOfAnotherSourceAreRefused) {
  const ClosingHand shorter(3);
  EXPECT_THAT(testing::error_of([&] { LabelledSource(shorter, book_, {}); }),
              HasSubstr("4 frames, the source has 3"));
}

TEST_F(LabelledSourceTest, LandmarksOfWhichTheLabelsSayNothingAreRefused) {
  const Convention& elsewhere = register_convention("label_elsewhere", {Landmark::nyu_wrist_1});
  EXPECT_THAT(testing::error_of([&] { LabelledSource(source_, book_, {.convention = elsewhere}); }),
              HasSubstr("labels in knuckle22 say nothing of the landmarks of label_elsewhere"));
}

TEST(LabelAgreement, DistancesAreThoseInSpace) {
  const ClosingHand source(3);
  LabelBook one(closing_hand_head(3));
  LabelBook other(closing_hand_head(3));
  one.add(truth_as_labels(source, {0}, LabelState::verified));
  other.add(truth_as_labels(source, {0}, LabelState::verified, 2.0));
  one.add(truth_as_labels(source, {1}, LabelState::verified));
  other.add(truth_as_labels(source, {1}, LabelState::corrected));
  one.add(truth_as_labels(source, {2}, LabelState::verified));
  const auto camera_of = [](std::int64_t) { return kLabelCamera; };
  const LabelAgreement agreement = agreement_of(one, other, LabelState::verified, camera_of);
  EXPECT_EQ(agreement.hands, 1);
  EXPECT_EQ(agreement.all.hands, kSupersetSize);
  const double depth = pose_of_points(source.truth(0)).joints[3].depth_mm;
  EXPECT_NEAR(agreement.landmarks[3].mean_mm, 2.0 * depth / kLabelCamera.fx, 1e-6);
  EXPECT_GE(agreement.all.largest_mm, agreement.all.mean_mm);
  ASSERT_EQ(agreement.each.size(), 1U);
  EXPECT_EQ(agreement.each[0].landmarks, kSupersetSize);
  EXPECT_NEAR(agreement.each[0].mean_mm, agreement.all.mean_mm, 1e-9);
  EXPECT_TRUE(std::isnan(agreement.each[0].mask_iou)) << "nobody has painted";
  EXPECT_EQ(agreement_of(one, other, LabelState::corrected, camera_of).hands, 2);
  EXPECT_EQ(agreement_of(one, one, LabelState::verified, camera_of).all.largest_mm, 0.0);
  LabelBook longer(closing_hand_head(9));
  EXPECT_THAT(testing::error_of([&] { (void)agreement_of(one, longer, LabelState::verified, camera_of); }),
              HasSubstr("cannot be compared"));
}

TEST(LabelAgreement, MasksOverlapByTheirShareOfPixelsInAny) {
  LabelBook one(closing_hand_head(2));
  LabelBook other(closing_hand_head(2));
  const auto painted = [](std::int64_t frame, int columns, int width = kLabelCamera.width) {
    Image<std::uint8_t> pixels(width, kLabelCamera.height);
    for (int row = 0; row < pixels.height(); ++row) std::fill_n(&pixels(0, row), columns, std::uint8_t{1});
    LabelChange change{.frame = frame, .act = LabelAct::brush};
    change.landmarks.resize(kSupersetSize);
    change.mask = std::make_shared<const LabelMask>(mask_from_pixels_of_hand(pixels));
    return change;
  };
  one.add(painted(0, 4));
  other.add(painted(0, 6));
  one.add(painted(1, 0));
  other.add(painted(1, 0));
  const auto camera_of = [](std::int64_t) { return kLabelCamera; };
  const LabelAgreement agreement = agreement_of(one, other, LabelState::corrected, camera_of);
  ASSERT_EQ(agreement.each.size(), 2U);
  EXPECT_NEAR(agreement.each[0].mask_iou, 4.0 / 6.0, 1e-12);
  EXPECT_TRUE(std::isnan(agreement.each[0].mean_mm));
  EXPECT_EQ(agreement.each[1].mask_iou, 1.0) << "both say that no pixel is hand";
  LabelBook smaller(closing_hand_head(2));
  smaller.add(painted(0, 4, 50));
  EXPECT_THAT(testing::error_of([&] { (void)agreement_of(one, smaller, LabelState::corrected, camera_of); }),
              HasSubstr("160x120 and of 50x120"));
}

}  // namespace
}  // namespace knuckle
