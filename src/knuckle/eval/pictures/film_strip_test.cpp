// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/film_strip.h"

#include <algorithm>

#include "knuckle/core/testing.h"
#include "knuckle/eval/metrics/eval_fixtures.h"
#include "knuckle/eval/pictures/drawing.h"

namespace knuckle {
namespace {

using testing::error_of;
using testing::FakeSource;
using ::testing::HasSubstr;

constexpr int kSize = 80;
constexpr int kGap = 4;

/// How many pixels of a tile have this colour.
std::ptrdiff_t count_in(const Image<Rgb>& strip, int x, int y, const Rgb& colour) {
  return std::ranges::count(cropped(strip, {x, y, kSize, kSize}).pixels(), colour);
}

TEST(FilmStrip, HasATileForEachFrameInTheirOrder) {
  const Truth truth = testing::example_truth(5);
  const FakeSource source(truth);
  const Image<Rgb> strip =
      film_strip({&source, &truth, nullptr, {}}, {.columns = 3, .picture_size_px = kSize});
  EXPECT_EQ(strip.width(), kGap + 3 * (kSize + kGap));
  EXPECT_EQ(strip.height(), kGap + 2 * (kSize + kGap));
  const Rgb paper = strip(0, 0);
  for (int i = 0; i < 6; ++i) {
    const int x = kGap + i % 3 * (kSize + kGap);
    const int y = kGap + i / 3 * (kSize + kGap);
    EXPECT_EQ(count_in(strip, x, y, kTruthColour) > 0, i < 5) << i;
    EXPECT_EQ(count_in(strip, x, y, paper) == kSize * kSize, i == 5) << i;
  }
}

TEST(FilmStrip, ShowsMethodsOneBelowTheOther) {
  const Truth truth = testing::example_truth(2);
  const FakeSource source(truth);
  Predictions right{"right", truth.sequence};
  Predictions none{"none", truth.sequence};
  for (HandPose& pose : none.sequence.poses) pose = HandPose::missing(pose.convention);
  const std::vector<Predictions> methods{right, none};
  const Image<Rgb> strip =
      film_strip({&source, &truth, nullptr, methods}, {.columns = 5, .picture_size_px = kSize});
  ASSERT_EQ(strip.height(), kGap + 2 * kSize + kGap);
  ASSERT_EQ(strip.width(), kGap + 2 * (kSize + kGap));
  EXPECT_GT(count_in(strip, kGap, kGap, kEstimateColour), 0);
  EXPECT_EQ(count_in(strip, kGap, kGap + kSize, kEstimateColour), 0);
}

TEST(FilmStrip, LeavesOutFramesEvenlyAndRefusesWhatNoImageHolds) {
  const Truth truth = testing::example_truth(40);
  const FakeSource source(truth);
  const GalleryInput input{&source, &truth, nullptr, {}};
  EXPECT_EQ(film_strip(input, {.columns = 4, .picture_size_px = kSize, .most_frames = 8}).height(),
            kGap + 2 * (kSize + kGap));
  // One column of 40 would be 20,164 pixels high, so there are two.
  const Image<Rgb> wider = film_strip(input, {.columns = 1, .picture_size_px = 500});
  EXPECT_EQ(wider.width(), kGap + 2 * (500 + kGap));
  EXPECT_EQ(wider.height(), kGap + 20 * (500 + kGap));
  const Truth many = testing::example_truth(90);
  const FakeSource source_of_many(many);
  EXPECT_THAT(error_of([&] {
                film_strip({&source_of_many, &many, nullptr, {}}, {.picture_size_px = 2000});
              }),
              HasSubstr("smaller pictures"));
  EXPECT_THAT(error_of([&] { film_strip(input, {.columns = 0}); }), HasSubstr("columns"));
  EXPECT_THAT(error_of([] { film_strip({}); }), HasSubstr("no frame"));
}

}  // namespace
}  // namespace knuckle
