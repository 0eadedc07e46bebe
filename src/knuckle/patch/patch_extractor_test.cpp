// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/patch_extractor.h"

#include <cmath>
#include <limits>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::knuckle::testing::error_of;
using ::testing::HasSubstr;

Frame frame_of(Image<float> depth_mm) {
  Frame frame;
  frame.name = "made_up";
  frame.depth_mm = std::move(depth_mm);
  frame.camera.width = frame.depth_mm.width();
  frame.camera.height = frame.depth_mm.height();
  return frame;
}

HandRegion whole_box(const Box& box) {
  HandRegion hand;
  hand.box = box;
  hand.mask = Image<std::uint8_t>(box.width, box.height, 1);
  return hand;
}

/// A tilted plane over the whole frame.
Frame ramp_frame() {
  Image<float> depth(80, 60);
  for (int row = 0; row < 60; ++row) {
    for (int column = 0; column < 80; ++column) depth(column, row) = 500.0f + 2.0f * column + 0.5f * row;
  }
  return frame_of(depth);
}

TEST(PatchExtractor, TakesTheNearestPixelOfTheImage) {
  const Frame frame = ramp_frame();
  const HandRegion hand = whole_box({13, 7, 41, 30});
  const HandPatch patch = *PatchExtractor({32}).extract(frame, hand);
  const PatchGeometry& geometry = patch.geometry;
  int hand_pixels = 0;
  for (int j = 0; j < 32; ++j) {
    for (int i = 0; i < 32; ++i) {
      const ImagePoint place = geometry.to_image({2.0 * i / 31 - 1, 2.0 * j / 31 - 1, patch.pixels(i, j)});
      const int column = static_cast<int>(std::lround(place.u));
      const int row = static_cast<int>(std::lround(place.v));
      if (!hand.box.contains(column, row)) {
        EXPECT_EQ(patch.pixels(i, j), 3.0f);
        continue;
      }
      EXPECT_NEAR(place.depth_mm, frame.depth_mm(column, row), 1e-3);
      ++hand_pixels;
    }
  }
  EXPECT_NEAR(hand_pixels, 32.0 * 32.0 * 30.0 / 41.0, 40);
}

TEST(PatchExtractor, IsTheCroppedImageWhereSizesAgree) {
  const Frame frame = ramp_frame();
  const HandPatch patch = *PatchExtractor({24}).extract(frame, whole_box({5, 9, 24, 24}));
  for (int j = 0; j < 24; ++j) {
    for (int i = 0; i < 24; ++i) {
      const double depth =
          patch.geometry.mean_depth_mm + patch.geometry.depth_deviation_mm * patch.pixels(i, j);
      EXPECT_NEAR(depth, frame.depth_mm(5 + i, 9 + j), 1e-3);
    }
  }
}

TEST(PatchExtractor, GivesHandPixelsZeroMeanAndUnitDeviation) {
  Frame frame = ramp_frame();
  HandRegion hand = whole_box({10, 10, 50, 40});
  Random random(3);
  for (std::uint8_t& pixel : hand.mask.pixels()) pixel = random.uniform() < 0.6 ? 1 : 0;
  const HandPatch patch = *PatchExtractor({48}).extract(frame, hand);
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  for (const float pixel : patch.pixels.pixels()) {
    EXPECT_LE(pixel, 3.0f);
    if (pixel == 3.0f) continue;
    sum += pixel;
    squares += double(pixel) * pixel;
    ++count;
  }
  EXPECT_GT(count, 500);
  EXPECT_NEAR(sum / count, 0.0, 1e-5);
  EXPECT_NEAR(squares / count, 1.0, 1e-5);
}

TEST(PatchExtractor, CutsStrayDepthsToThreeDeviations) {
  Frame frame = frame_of(Image<float>(40, 40, 500.0f));
  for (int i = 0; i < 40; ++i) frame.depth_mm(i, i) += 20.0f;
  frame.depth_mm(20, 10) = 3000.0f;
  frame.depth_mm(10, 20) = 10.0f;
  const HandPatch patch = *PatchExtractor({40}).extract(frame, whole_box({0, 0, 40, 40}));
  EXPECT_EQ(patch.pixels(20, 10), 3.0f);
  EXPECT_EQ(patch.pixels(10, 20), -3.0f);
}

TEST(PatchExtractor, TakesPixelsWithoutMeasurementForBackground) {
  Frame frame = ramp_frame();
  frame.depth_mm(20, 20) = 0.0f;
  frame.depth_mm(21, 20) = std::numeric_limits<float>::quiet_NaN();
  frame.depth_mm(22, 20) = std::numeric_limits<float>::infinity();
  frame.depth_mm(23, 20) = -5.0f;
  const HandPatch patch = *PatchExtractor({20}).extract(frame, whole_box({15, 15, 20, 20}));
  for (int i = 5; i < 9; ++i) EXPECT_EQ(patch.pixels(i, 5), 3.0f);
  for (const float pixel : patch.pixels.pixels()) EXPECT_TRUE(std::isfinite(pixel));
}

TEST(PatchExtractor, HandlesABoxThatReachesOutOfTheImage) {
  const HandPatch patch = *PatchExtractor({20}).extract(ramp_frame(), whole_box({-10, -10, 20, 20}));
  EXPECT_EQ(patch.pixels(0, 0), 3.0f);
  EXPECT_LT(patch.pixels(15, 15), 3.0f);
}

TEST(PatchExtractor, DoesNotStretchAFlatHand) {
  const Frame frame = frame_of(Image<float>(40, 40, 500.0f));
  const HandPatch patch = *PatchExtractor({16}).extract(frame, whole_box({10, 10, 20, 20}));
  EXPECT_EQ(patch.geometry.depth_deviation_mm, PatchExtractor::kSmallestDeviationMm);
  for (const float pixel : patch.pixels.pixels()) EXPECT_EQ(pixel, 0.0f);
}

TEST(PatchExtractor, FindsNothingWithoutHandPixels) {
  const PatchExtractor extractor({16});
  Frame frame = ramp_frame();
  EXPECT_FALSE(extractor.extract(frame, HandRegion{}));
  HandRegion hand = whole_box({10, 10, 20, 20});
  std::ranges::fill(hand.mask.pixels(), std::uint8_t{0});
  EXPECT_FALSE(extractor.extract(frame, hand));
  EXPECT_FALSE(extractor.extract(frame, whole_box({200, 10, 20, 20})));
  std::ranges::fill(frame.depth_mm.pixels(), 0.0f);
  EXPECT_FALSE(extractor.extract(frame, whole_box({10, 10, 20, 20})));
}

TEST(PatchExtractor, SubtractsTheMeanPatchAndWhitens) {
  const Frame frame = ramp_frame();
  const HandRegion hand = whole_box({13, 7, 41, 30});
  const HandPatch plain = *PatchExtractor({3}).extract(frame, hand);
  PatchStatistics statistics{3, Image<float>(3, 3), std::vector<float>(81)};
  for (int i = 0; i < 9; ++i) {
    statistics.mean.data()[i] = 0.1f * static_cast<float>(i);
    statistics.whitening[static_cast<std::size_t>(i) * 9 + (i + 1) % 9] =
        2.0f;  // moves values and doubles them
  }
  const HandPatch patch = *PatchExtractor({3}, statistics).extract(frame, hand);
  for (int i = 0; i < 9; ++i) {
    const int from = (i + 1) % 9;
    EXPECT_FLOAT_EQ(patch.pixels.data()[i],
                    2.0f * (plain.pixels.data()[from] - 0.1f * static_cast<float>(from)));
  }
}

TEST(PatchExtractor, ABoxThatReachesOverTheEndsOfAnImageIsBackgroundThere) {
  // 80 x 60 pixels: what is no row any more may be a column yet.
  const HandPatch patch = *PatchExtractor({40}).extract(ramp_frame(), whole_box({50, 40, 40, 40}));
  for (int j = 0; j < 40; ++j) {
    for (int i = 0; i < 40; ++i) {
      const bool is_in_image = 50 + i < 80 && 40 + j < 60;
      EXPECT_EQ(patch.pixels(i, j) == 3.0f, !is_in_image) << i << ", " << j;
    }
  }
}

TEST(PatchExtractor, ATallBoxIsFittedByItsHeight) {
  const PatchGeometry geometry = patch_geometry({10, 4, 7, 30}, 60);
  EXPECT_DOUBLE_EQ(geometry.centre_u, 13.0);
  EXPECT_DOUBLE_EQ(geometry.centre_v, 18.5);
  EXPECT_DOUBLE_EQ(geometry.image_px_per_patch_px, 0.5);
}

TEST(PatchExtractor, RefusesWhatDoesNotFit) {
  EXPECT_THAT(error_of([] { PatchExtractor extractor({1}); }), HasSubstr("size_px"));
  EXPECT_THAT(error_of([] {
                PatchExtractor({64}, PatchStatistics{96, {}, {}});
              }),
              HasSubstr("size_px is 64, but the model was trained on patches of 96"));
  EXPECT_THAT(error_of([] {
                PatchExtractor({8}, PatchStatistics{8, Image<float>(9, 8), {}});
              }),
              HasSubstr("the mean patch is 9 x 8"));
  EXPECT_THAT(error_of([] {
                PatchExtractor({8}, PatchStatistics{8, {}, std::vector<float>(63)});
              }),
              HasSubstr("the whitening matrix has 63 values, expected 4096"));
  EXPECT_THAT(error_of([] {
                PatchExtractor({8}, PatchStatistics{8, Image<float>(8, 8, NAN), {}});
              }),
              HasSubstr("the mean patch holds a value that is not finite"));
  EXPECT_THAT(error_of([] {
                std::vector<float> whitening(64 * 64);
                whitening[4095] = NAN;
                PatchExtractor({8}, PatchStatistics{8, {}, whitening});
              }),
              HasSubstr("the whitening matrix holds a value that is not finite"));
  HandRegion hand = whole_box({1, 1, 5, 5});
  hand.box.width = 6;
  EXPECT_THAT(error_of([&] { (void)PatchExtractor({8}).extract(ramp_frame(), hand); }),
              HasSubstr("the hand's mask is 5 x 5 pixels, its box 6 x 5"));
  EXPECT_THAT(error_of([] {
                PatchExtractor({8, "cube"}, PatchStatistics{8, Image<float>(8, 8), {}});
              }),
              HasSubstr("patches of a cube take no mean patch and no whitening"));
}

}  // namespace
}  // namespace knuckle
