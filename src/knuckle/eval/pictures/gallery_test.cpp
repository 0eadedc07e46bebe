// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/gallery.h"

#include <algorithm>

#include "knuckle/core/testing.h"
#include "knuckle/data/fitted_hand_testing.h"
#include "knuckle/eval/metrics/eval_fixtures.h"
#include "knuckle/eval/pictures/surface_picture.h"

namespace knuckle {
namespace {

using testing::example_truth;
using testing::FakeSource;

/// FakeSource's flat ground has a depth of 510 mm.
HandRecord hand_at(double z_mm) {
  return testing::fitted_hand({0.0, 60.0, z_mm});
}

NamedRecords method_with(const HandRecord& hand, int frames) {
  NamedRecords method{"fitted", std::vector<FrameRecord>(static_cast<std::size_t>(frames))};
  method.frames[0].hands = {hand};
  return method;
}

std::ptrdiff_t count_in(const Image<Rgb>& picture, const Rgb& colour) {
  return std::ranges::count(picture.pixels(), colour);
}

TEST(Gallery, ShowsTheFittedSurfaceAndItsDifference) {
  const Truth truth = example_truth(2);
  const FakeSource source(truth);
  const NamedRecords method = method_with(hand_at(400.0), 2);
  const std::vector<GalleryRow> rows = make_gallery({&source, &truth, nullptr, {}, std::span(&method, 1)});
  ASSERT_EQ(rows.size(), 2u);
  ASSERT_EQ(rows[0].pictures.size(), 3u);
  EXPECT_TRUE(rows[0].shows_difference);
  EXPECT_EQ(rows[0].pictures[0].caption, "truth");
  EXPECT_EQ(rows[0].pictures[1].caption, "fitted: surface");
  EXPECT_EQ(rows[0].pictures[2].caption, "fitted: difference");
  EXPECT_GT(count_in(rows[0].pictures[2].picture, kMeasuredBehind), 300)
      << "the hand floats 10 cm before all";
  EXPECT_EQ(count_in(rows[0].pictures[2].picture, kMeasuredBefore), 0);
  // The second frame's record holds no hand.
  ASSERT_EQ(rows[1].pictures.size(), 2u);
  EXPECT_FALSE(rows[1].shows_difference);
  EXPECT_EQ(rows[1].pictures[1].caption, "fitted");
  EXPECT_EQ(rows[1].pictures[1].note, "no hand");
}

TEST(Gallery, AHandWithoutAFittedModelIsDrawnAsASkeleton) {
  const FakeSource source;
  HandRecord hand = hand_at(450.0);
  hand.skeleton.clear();
  const NamedRecords method = method_with(hand, 4);
  const std::vector<GalleryRow> rows = make_gallery({&source, nullptr, nullptr, {}, std::span(&method, 1)});
  ASSERT_EQ(rows[0].pictures.size(), 2u) << "the whole frame, and the hand";
  EXPECT_FALSE(rows[0].shows_difference);
  EXPECT_GT(count_in(rows[0].pictures[1].picture, kEstimateColour), 20);
}

TEST(Gallery, TheCropHoldsAllRecordedHandsWhereThereIsNoTruth) {
  const FakeSource source;
  NamedRecords method = method_with(hand_at(900.0), 4);
  HandRecord other = hand_at(900.0);
  for (Point3& point : method.frames[0].hands[0].landmarks_mm) point.x() -= 200.0;
  for (Point3& point : other.landmarks_mm) point.x() += 200.0;
  method.frames[0].hands.push_back(other);
  const std::vector<GalleryRow> rows = make_gallery({&source, nullptr, nullptr, {}, std::span(&method, 1)});
  // Both hands lie behind the ground: one left and one right in the picture, none in its middle.
  const Image<Rgb>& picture = rows[0].pictures.back().picture;
  const int fifth = picture.width() / 5;
  const auto blue_from = [&](int column, int width) {
    return count_in(cropped(picture, {column, 0, width, picture.height()}), kMeasuredBefore);
  };
  EXPECT_GT(blue_from(0, 2 * fifth), 100);
  EXPECT_EQ(blue_from(2 * fifth, fifth), 0);
  EXPECT_GT(blue_from(3 * fifth, 2 * fifth), 100);
}

TEST(Gallery, LandmarksBeyondAllReasonAreNoCrash) {
  const FakeSource source;
  for (const double far : {1e12, -1e300}) {
    HandRecord hand = hand_at(500.0);
    hand.landmarks_mm[3].x() = far;
    hand.landmarks_mm[9] = Point3(far, far, std::abs(far));
    const NamedRecords method = method_with(hand, 4);
    EXPECT_EQ(make_gallery({&source, nullptr, nullptr, {}, std::span(&method, 1)}).size(), 4u);
  }
}

}  // namespace
}  // namespace knuckle
