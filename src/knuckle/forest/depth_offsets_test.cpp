// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/depth_offsets.h"

#include <limits>
#include <set>

#include "knuckle/core/testing.h"
#include "knuckle/forest/depth_tiles.h"
#include "knuckle/forest/forest_testing.h"
#include "knuckle/forest/offset_features.h"
#include "knuckle/forest/split_search.h"

namespace knuckle {
namespace {

using testing::ball_scenes;
using testing::BallScene;
using testing::error_of;
using ::testing::HasSubstr;
using testing::samples_of;

TEST(StoredDepth, RoundsAndKnowsWhatIsFar) {
  EXPECT_EQ(stored_depth(499.4F), 499);
  EXPECT_EQ(stored_depth(499.5F), 500);
  EXPECT_EQ(stored_depth(0.1F), 1);
  for (const float nothing : {0.0F, -5.0F, 10000.0F, 1e9F, std::numeric_limits<float>::quiet_NaN(),
                              std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(stored_depth(nothing), kFarDepth);
  }
}

/// Equation 1 in double: the probe lies offset * f / d pixels away.
TEST(OffsetFeature, ProbesLieWhereEquation1SaysTheyDo) {
  const Camera camera{.width = 320, .height = 240, .fx = 241.0, .fy = -230.0};
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const auto depth = static_cast<std::int16_t>(random.uniform(60, 5000));
    const int offset = static_cast<int>(random.uniform(-600, 600));
    const PixelScale scale = OffsetScale(camera).at(depth);
    EXPECT_NEAR(shifted(100, offset, scale.x), 100 + offset * 241.0 / depth, 0.55);
    EXPECT_NEAR(shifted(100, offset, scale.y), 100 + offset * 230.0 / depth, 0.55);
  }
  Camera parallel = camera;
  parallel.model = CameraModel::orthographic;
  parallel.fx = parallel.fy = 0.5;
  EXPECT_EQ(shifted(7, 40, OffsetScale(parallel).at(300).x), 27);
  EXPECT_EQ(shifted(7, 40, OffsetScale(parallel).at(3000).x), 27);
}

TEST(OffsetFeature, DoesNotChangeWithDistanceNorResolution) {
  // A step of 100 mm, 50 mm to the right of the pixel's point.
  for (const double focal : {120.0, 240.0, 480.0}) {
    for (const float distance : {400.0F, 800.0F}) {
      const Camera camera{.width = 200, .height = 20, .fx = focal, .fy = focal};
      Image<float> image(200, 20, distance);
      const auto edge = static_cast<int>(60.0 + 50.0 * focal / distance);
      for (int row = 0; row < 20; ++row) {
        for (int column = edge; column < 200; ++column) image(column, row) = distance + 100.0F;
      }
      const BorderedDepth depth(image);
      const PixelScale scale = OffsetScale(camera).at(depth(60, 10));
      EXPECT_EQ(offset_feature(depth, 60, 10, scale, {60, 0, 0, 0}), 100);
      EXPECT_EQ(offset_feature(depth, 60, 10, scale, {40, 0, 0, 0}), 0);
      EXPECT_EQ(offset_feature(depth, 60, 10, scale, {40, 0, 60, 0}), -100);
      EXPECT_EQ(offset_feature(depth, 60, 10, scale, {-4000, 0, 0, 0}), kFarDepth - distance);
    }
  }
}

TEST(DepthTiles, ReadLikeTheWholeImage) {
  for (const auto& [width, height] :
       {std::pair(61, 47), std::pair(8, 8), std::pair(1, 17), std::pair(64, 3)}) {
    const BallScene scene(3, width, height, 0);
    const DepthTiles tiles(scene.depth_mm);
    const BorderedDepth whole(scene.depth_mm);
    for (int row = -30; row < height + 30; ++row) {
      for (int column = -30; column < width + 30; ++column) {
        const bool is_inside = scene.depth_mm.contains(column, row);
        ASSERT_EQ(whole(column, row), is_inside ? stored_depth(scene.depth_mm(column, row)) : kFarDepth);
        ASSERT_EQ(tiles(column, row), whole(column, row)) << column << " " << row;
      }
    }
  }
}

TEST(DepthTiles, KeepOnlyWhatWasMeasured) {
  Image<float> image(320, 240);
  const std::size_t empty = DepthTiles(image).bytes();
  EXPECT_LT(empty, 4000U);
  for (int row = 80; row < 160; ++row) {
    for (int column = 80; column < 160; ++column) image(column, row) = 700.0F;
  }
  EXPECT_EQ(DepthTiles(image).bytes(), empty + std::size_t{2} * 80 * 80);
  EXPECT_NE(DepthTiles(image).hash(), DepthTiles(Image<float>(320, 240)).hash());
}

TEST(DepthTiles, RefuseAnImageOfTooManySquares) {
  EXPECT_NO_THROW(DepthTiles(Image<float>(8, 8 * 65535)));
  EXPECT_THAT(error_of([] { DepthTiles(Image<float>(8, 8 * 65536)); }),
              HasSubstr("depth image of 8 x 524288 pixels: too large to train a forest on"));
}

TEST(DrawnOffsets, AreEvenInTheLogarithmAndInDirection) {
  const OffsetOptions options{.nearest_offset_mm = 10.0, .farthest_offset_mm = 1000.0};
  Random random(4);
  int short_ones = 0;
  int right = 0;
  int down = 0;
  for (int i = 0; i < 20000; ++i) {
    const DepthOffset offset = drawn_offset(options, random);
    const double length = std::hypot(offset.x, offset.y);
    ASSERT_GE(length, 9.0);
    ASSERT_LE(length, 1001.0);
    short_ones += length < 100.0 ? 1 : 0;
    right += offset.x > 0 ? 1 : 0;
    down += offset.y > 0 ? 1 : 0;
  }
  for (const int half : {short_ones, right, down}) EXPECT_NEAR(half / 20000.0, 0.5, 0.02);
}

TEST(OffsetFeatures, BlockHoldsTheValuesOfItsSamples) {
  const PixelSamples images = samples_of(ball_scenes(4));
  const ArrangedSamples all = arranged(images);
  const OffsetFeatures features(images, all, {.offsets_per_node = 20});
  std::vector<std::uint32_t> some;
  for (std::uint32_t i = 0; i < all.samples.size(); i += 5) some.push_back(i);
  Random random(1);
  TreeOptions options;
  OffsetFeatures::Block block;
  features.begin_node(random, options, block);
  EXPECT_EQ(block.pool.size(), 20U);
  features.gather(some, serial_for, block);
  std::vector<std::int16_t> values(some.size());
  std::set<std::pair<int, int>> pairs;
  for (int i = 0; i < 150; ++i) {
    const RowPair candidate = features.draw(random, i, 150, block);
    ASSERT_NE(candidate.first, candidate.second);
    ASSERT_LT(std::max(candidate.first, candidate.second), 20);
    EXPECT_TRUE(i >= 19 || candidate.second == 0);  // first equation 1 as printed
    pairs.emplace(candidate.first, candidate.second);
    OffsetFeatures::values(block, candidate, values.data());
    const OffsetPair feature = OffsetFeatures::feature(block, candidate);
    for (std::size_t s = 0; s < some.size(); ++s) ASSERT_EQ(values[s], features.value(some[s], feature));
  }
  EXPECT_GT(pairs.size(), 100U);
}

TEST(PixelSamples, RefusesWhatItCannotUse) {
  const BallScene scene(1);
  PixelSamples samples(2);
  const auto fault_of = [&](std::int64_t index, LabelledPixel pixel) {
    return error_of([&] { samples.set(index, scene.depth_mm, scene.camera, std::vector{pixel}); });
  };
  EXPECT_THAT(fault_of(2, {1, 1, 0}), HasSubstr("training image 2: there is room for 2"));
  EXPECT_THAT(fault_of(1, {61, 1, 0}), HasSubstr("pixel (61, 1) was not measured"));
  LabelledPixel good = scene.pixels[0];
  good.label = 2;
  EXPECT_THAT(fault_of(1, good), HasSubstr("label 2, expected 0 or 1"));
  Camera other = scene.camera;
  other.width = 60;
  EXPECT_THAT(error_of([&] { samples.set(0, scene.depth_mm, other, scene.pixels); }),
              HasSubstr("61 x 47 pixels, its camera 60 x 47"));
  EXPECT_EQ(samples.sample_count(), 0);
}

}  // namespace
}  // namespace knuckle
