// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/pixel_forest.h"

#include <fstream>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/forest/forest_testing.h"
#include "knuckle/forest/pixel_forest_trainer.h"
#include "knuckle/storage/model_testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::ball_scenes;
using testing::BallScene;
using testing::error_of;
using ::testing::HasSubstr;
using testing::samples_of;
using testing::written_model;

PixelForest small_pixel_forest() {
  PixelForestOptions options;
  options.trees = 3;
  options.tree.splits_per_node = 50;
  options.tree.min_leaf_samples = 1;
  return train_pixel_forest(samples_of(ball_scenes(12)), options);
}

/// The walk as the paper states it, recursive, on the image itself.
int code_at(const PixelForest::Parts& parts, std::int32_t index, const BorderedDepth& depth,
            const Camera& camera, int column, int row) {
  const PixelForest::Node& node = parts.trees.nodes[static_cast<std::size_t>(index)];
  if (node.next < 0) return parts.leaf_codes[static_cast<std::size_t>(~node.next)];
  const PixelScale scale = OffsetScale(camera).at(depth(column, row));
  const bool is_right = offset_feature(depth, column, row, scale, node.feature) >= node.threshold;
  return code_at(parts, node.next + (is_right ? 1 : 0), depth, camera, column, row);
}

void expect_recursive_walk(const PixelForest& forest, const Image<float>& depth_mm, const Camera& camera) {
  const Image<float> probability = forest.probability(depth_mm, camera);
  const BorderedDepth depth(depth_mm);
  for (int row = 0; row < depth_mm.height(); ++row) {
    for (int column = 0; column < depth_mm.width(); ++column) {
      int sum = 0;
      for (const std::uint32_t root : forest.parts().trees.roots) {
        sum += code_at(forest.parts(), static_cast<std::int32_t>(root), depth, camera, column, row);
      }
      const float expected =
          static_cast<float>(sum) / static_cast<float>(forest.tree_count() * PixelForest::kMostCode);
      ASSERT_EQ(probability(column, row), depth(column, row) == kFarDepth ? 0.0F : expected);
    }
  }
}

TEST(PixelForest, FlatWalkIsTheRecursiveWalkBitForBit) {
  const PixelForest forest = small_pixel_forest();
  for (std::uint64_t seed = 50; seed < 54; ++seed) {
    BallScene scene(seed, 90, 70);
    expect_recursive_walk(forest, scene.depth_mm, scene.camera);
    scene.camera.model = CameraModel::orthographic;
    scene.camera.fx = scene.camera.fy = 0.2;
    expect_recursive_walk(forest, scene.depth_mm, scene.camera);
  }
  Random random(9);
  Image<float> noise(33, 21);  // also depths at which the scale of offsets is cut
  for (float& depth : noise.pixels()) depth = static_cast<float>(random.uniform(-10.0, 60.0));
  expect_recursive_walk(forest, noise, {.width = 33, .height = 21, .fx = 600.0, .fy = 600.0});
}

TEST(PixelForest, DecidesEarlyButNotOtherwise) {
  const PixelForest forest = small_pixel_forest();
  const BallScene scene(60, 160, 120);
  const Image<float> probability = forest.probability(scene.depth_mm, scene.camera);
  // The values that occur, and one above all.
  for (const float threshold : {0.0F, 0.3F, 1.0F / 3.0F, 0.5F, 2.0F / 3.0F, 0.8F, 0.99F, 1.0F}) {
    const Image<std::uint8_t> mask = forest.above(scene.depth_mm, scene.camera, threshold);
    for (std::size_t i = 0; i < mask.size(); ++i) {
      ASSERT_EQ(mask.data()[i], probability.data()[i] > threshold ? 1 : 0) << threshold;
    }
  }
}

TEST(PixelForest, DoesNotDependOnThreads) {
  const PixelForest forest = small_pixel_forest();
  const BallScene scene(70, 160, 120);
  set_thread_count(1);
  const Image<float> one = forest.probability(scene.depth_mm, scene.camera);
  set_thread_count(0);
  EXPECT_EQ(one, forest.probability(scene.depth_mm, scene.camera));
}

TEST(PixelForest, TakesImagesWithoutMeasurement) {
  const PixelForest forest = small_pixel_forest();
  EXPECT_TRUE(forest.probability({}, {}).empty());
  const Camera camera{.width = 5, .height = 4, .fx = 10.0, .fy = 10.0};
  EXPECT_EQ(forest.probability(Image<float>(5, 4), camera), Image<float>(5, 4));
  EXPECT_THAT(error_of([&] { (void)forest.probability(Image<float>(5, 5), camera); }),
              HasSubstr("5 x 5 pixels, its camera 5 x 4"));
}

TEST(PixelForest, SavedAndLoadedAnswersTheSame) {
  const PixelForest forest = small_pixel_forest();
  const PixelForest loaded =
      read_pixel_forest(written_model([&](ModelWriter& file) { write_forest(file, forest); }));
  EXPECT_EQ(loaded.parts().leaf_codes, forest.parts().leaf_codes);
  const BallScene scene(81);
  EXPECT_EQ(loaded.probability(scene.depth_mm, scene.camera),
            forest.probability(scene.depth_mm, scene.camera));
}

TEST(PixelForest, RefusesNodesThatLeadNowhereAndWideOffsets) {
  const PixelForest::Parts good = small_pixel_forest().parts();
  const auto fault_of = [&](const std::function<void(PixelForest::Parts&)>& damage) {
    PixelForest::Parts parts = good;
    damage(parts);
    return error_of([&] { PixelForest(parts, "x.model"); });
  };
  EXPECT_THAT(fault_of([](auto& p) { p.trees.nodes[0].next = 0; }),
              AllOf(HasSubstr("x.model"), HasSubstr("leads nowhere")));
  EXPECT_THAT(fault_of([](auto& p) { p.leaf_codes.pop_back(); }), HasSubstr("leads nowhere"));
  EXPECT_THAT(fault_of([](auto& p) { p.trees.nodes[0].feature.second_y = 4001; }),
              HasSubstr("offset of 4001 mm"));
  EXPECT_THAT(fault_of([](auto& p) { p.trees.roots.clear(); }), HasSubstr("no first tree"));
}

TEST(PixelForest, RefusesFilesOfWhichAPartIsWrong) {
  const auto fault_of = [](const std::function<void(ModelWriter&)>& write) {
    return error_of([&] { (void)read_pixel_forest(written_model(write)); });
  };
  EXPECT_THAT(fault_of([](ModelWriter& file) {
                write_forest(file, small_pixel_forest());
                file.set("far_depth_mm", 5000.0);
              }),
              AllOf(HasSubstr("test.model"), HasSubstr("far_depth_mm is 5000")));
  EXPECT_THAT(fault_of([](ModelWriter& file) { file.set("far_depth_mm", 10000.0); }),
              AllOf(HasSubstr("test.model"), HasSubstr("tree_root")));
}

}  // namespace
}  // namespace knuckle
