// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/pixel_forest_trainer.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <numeric>
#include <set>

#include <sys/wait.h>
#include <unistd.h>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/forest/forest_growth.h"
#include "knuckle/forest/forest_testing.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::ball_scenes;
using testing::BallScene;
using testing::error_of;
using ::testing::HasSubstr;
using testing::samples_of;
using testing::TemporaryFolder;

PixelForestOptions small_pixel_options() {
  PixelForestOptions options;
  options.trees = 3;
  options.tree.splits_per_node = 40;
  options.tree.samples_per_node = 200;
  options.tree.min_leaf_samples = 2;
  options.offsets.offsets_per_node = 32;
  return options;
}

void expect_same(const PixelForest& a, const PixelForest& b) {
  testing::expect_same_trees(a.parts().trees, b.parts().trees);
  EXPECT_EQ(a.parts().leaf_codes, b.parts().leaf_codes);
}

TEST(TrainPixelForest, MemorisesATinySetExactly) {
  const std::vector<BallScene> scenes = ball_scenes(4);
  PixelForestOptions options;
  options.tree.splits_per_node = 300;
  options.tree.min_leaf_samples = 1;
  const PixelForest forest = train_pixel_forest(samples_of(scenes), options);
  for (const BallScene& scene : scenes) {
    const Image<float> probability = forest.probability(scene.depth_mm, scene.camera);
    for (const auto& [column, row, label] : scene.pixels) ASSERT_EQ(probability(column, row), label);
  }
}

TEST(TrainPixelForest, FindsBallsItHasNotSeen) {
  const PixelForest forest = train_pixel_forest(samples_of(ball_scenes(60)), small_pixel_options());
  int right = 0;
  int all = 0;
  for (std::uint64_t seed = 100; seed < 110; ++seed) {
    const BallScene scene(seed);
    const Image<float> probability = forest.probability(scene.depth_mm, scene.camera);
    for (const auto& [column, row, label] : scene.pixels) {
      right += (probability(column, row) > 0.5F) == (label == 1) ? 1 : 0;
      ++all;
    }
  }
  EXPECT_GT(right, 0.97 * all);
}

TEST(TrainPixelForest, LeavesHoldThePartOfClassOne) {
  const std::vector<BallScene> scenes = ball_scenes(1);
  PixelForestOptions options = small_pixel_options();
  options.trees = 1;
  options.tree.max_depth = 0;
  PixelSamples samples(1);
  std::vector<LabelledPixel> pixels(scenes[0].pixels.begin() + 30, scenes[0].pixels.end());
  samples.set(0, scenes[0].depth_mm, scenes[0].camera, pixels);  // 10 of class 0, 40 of class 1
  EXPECT_EQ(train_pixel_forest(samples, options).parts().leaf_codes, std::vector<std::uint8_t>{204});
}

TEST(TrainPixelForest, DoesNotDependOnTheOrderOfImages) {
  const std::vector<BallScene> scenes = ball_scenes(20);
  PixelForestOptions options = small_pixel_options();
  options.tree.bagging_fraction = 0.7;
  const PixelForest forest = train_pixel_forest(samples_of(scenes), options);
  std::vector<std::int64_t> place(20);
  std::iota(place.begin(), place.end(), 0);
  std::rotate(place.begin(), place.begin() + 7, place.end());
  std::reverse(place.begin(), place.begin() + 9);
  std::vector<BallScene> shuffled = scenes;
  for (BallScene& scene : shuffled) std::ranges::reverse(scene.pixels);
  expect_same(forest, train_pixel_forest(samples_of(shuffled, place), options));
}

TEST(TrainPixelForest, DoesNotDependOnThreads) {
  const PixelSamples samples = samples_of(ball_scenes(60));
  PixelForestOptions options = small_pixel_options();
  options.tree.samples_per_node = 2000;  // nodes above and below the size that shares candidates
  set_thread_count(1);
  const PixelForest one = train_pixel_forest(samples, options);
  set_thread_count(2);
  const PixelForest two = train_pixel_forest(samples, options);
  set_thread_count(0);
  expect_same(one, two);
}

TEST(TrainPixelForest, GoesOnFromWhereverItWasStopped) {
  const TemporaryFolder folder;
  const PixelSamples samples = samples_of(ball_scenes(20));
  const PixelForestOptions options = small_pixel_options();
  std::vector<std::size_t> nodes_at_call;
  const TrainingRun watched{.nodes_done = [&](std::size_t nodes) { nodes_at_call.push_back(nodes); }};
  const PixelForest whole = train_pixel_forest(samples, options, watched);
  ASSERT_GT(nodes_at_call.size(), 10U);
  for (std::size_t stop = 1; stop <= nodes_at_call.size(); stop += 3) {
    std::size_t calls = 0;
    TrainingRun run{.checkpoint = folder / "c.model", .checkpoint_interval_s = 0.0};
    run.nodes_done = [&](std::size_t) {
      if (++calls == stop) throw Error("stopped");
    };
    EXPECT_EQ(error_of([&] { (void)train_pixel_forest(samples, options, run); }), "stopped");
    calls = 0;
    run.nodes_done = [&](std::size_t nodes) {
      if (++calls == 1 && stop < nodes_at_call.size()) {
        EXPECT_EQ(nodes, nodes_at_call[stop]);  // nothing is split twice
      }
    };
    expect_same(whole, train_pixel_forest(samples, options, run));
    EXPECT_EQ(calls, nodes_at_call.size() - stop);
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  }
}

/// The same with a process that is killed, at whatever it happens to do.
TEST(TrainPixelForest, SurvivesBeingKilled) {
  const TemporaryFolder folder;
  PixelForestOptions options = small_pixel_options();
  options.tree.splits_per_node = 400;
  set_thread_count(1);
  const PixelSamples samples = samples_of(ball_scenes(20));
  const TrainingRun run{.checkpoint = folder / "c.model", .checkpoint_interval_s = 0.0};
  int kills = 0;
  for (int attempt = 0; attempt < 12; ++attempt) {
    const pid_t child = ::fork();
    if (child == 0) {
      try {
        (void)train_pixel_forest(samples, options, run);
      } catch (...) {
        ::_exit(2);
      }
      ::_exit(0);
    }
    ::usleep(static_cast<useconds_t>(3000 + 1700 * attempt));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    kills += WIFSIGNALED(status) ? 1 : 0;
    EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
  }
  EXPECT_GT(kills, 0);
  const PixelForest resumed = train_pixel_forest(samples, options, run);
  set_thread_count(0);
  expect_same(resumed, train_pixel_forest(samples, options));
}

TEST(TrainPixelForest, RefusesACheckpointOfAnotherTraining) {
  const TemporaryFolder folder;
  const PixelSamples samples = samples_of(ball_scenes(5));
  PixelForestOptions options = small_pixel_options();
  TrainingRun run{.checkpoint = folder / "c.model", .checkpoint_interval_s = 0.0};
  run.nodes_done = [](std::size_t nodes) {
    if (nodes > 3) throw Error("stopped");
  };
  EXPECT_EQ(error_of([&] { (void)train_pixel_forest(samples, options, run); }), "stopped");
  run.nodes_done = nullptr;
  options.offsets.farthest_offset_mm = 500.0;
  EXPECT_THAT(error_of([&] { (void)train_pixel_forest(samples, options, run); }),
              AllOf(HasSubstr("c.model.tree"), HasSubstr("other options or samples")));
}

TEST(TrainPixelForest, RefusesSetsItCannotLearnFrom) {
  const PixelForestOptions options = small_pixel_options();
  EXPECT_THAT(error_of([&] { (void)train_pixel_forest(PixelSamples(3), options); }), HasSubstr("no samples"));
  BallScene scene(1);
  std::erase_if(scene.pixels, [](const LabelledPixel& pixel) { return pixel.label == 1; });
  EXPECT_THAT(error_of([&] { (void)train_pixel_forest(samples_of({scene}), options); }),
              HasSubstr("all 40 samples are of class 0, expected both"));
}

TEST(TrainPixelForest, RefusesBadOptionsAndTooSmallAMemory) {
  const PixelSamples samples = samples_of(ball_scenes(5));
  PixelForestOptions options = small_pixel_options();
  options.offsets.nearest_offset_mm = 900.0;
  EXPECT_THAT(error_of([&] { (void)train_pixel_forest(samples, options); }),
              AllOf(HasSubstr("nearest_offset_mm is 900"), HasSubstr("600")));
  options = small_pixel_options();
  options.offsets.offsets_per_node = 1;
  EXPECT_THAT(error_of([&] { (void)train_pixel_forest(samples, options); }), HasSubstr("offsets_per_node"));
  options = small_pixel_options();
  options.memory_gb = 1e-4;
  EXPECT_THAT(error_of([&] { (void)train_pixel_forest(samples, options); }),
              AllOf(HasSubstr("5 images with 400 samples"), HasSubstr("memory_gb is 0.0001;"),
                    HasSubstr("at most 0 images would fit")));
  // 1,000 images of 1 MB with 2,000 samples each, more than two thirds of which fit into 1 GB.
  options.memory_gb = 1.0;
  const std::string fault = error_of([&] { check_training_memory(1e9, 1000, 2000000, options); });
  const std::string told = "at most ";
  const std::int64_t fitting = std::stoll(fault.substr(fault.find(told) + told.size()));
  EXPECT_NO_THROW(check_training_memory(1e6 * double(fitting), fitting, 2000 * fitting, options));
  EXPECT_THROW(check_training_memory(1e6 * double(fitting + 1), fitting + 1, 2000 * (fitting + 1), options),
               Error);
}

TEST(PixelSamples, TheirHashIsThatOfAllThatATreeSees) {
  const Image<float> depth_mm(20, 10, 500.0f);
  const Camera camera{.width = 20, .height = 10, .fx = 50.0, .fy = 50.0, .cx = 9.5, .cy = 4.5};
  const auto hash_of = [&](const Image<float>& image, const Camera& seen_by, const LabelledPixel& pixel) {
    PixelSamples samples(1);
    samples.set(0, image, seen_by, std::vector{LabelledPixel{1, 1, 0}, pixel});
    return arranged(samples).hash;
  };
  Camera longer = camera;
  longer.fx = longer.fy = 80.0;
  Image<float> nearer = depth_mm;
  nearer(3, 3) = 400.0f;
  const std::set<std::uint64_t> hashes{
      hash_of(depth_mm, camera, {3, 4, 1}), hash_of(depth_mm, camera, {3, 4, 0}),
      hash_of(depth_mm, camera, {4, 4, 1}), hash_of(depth_mm, camera, {3, 5, 1}),
      hash_of(depth_mm, longer, {3, 4, 1}), hash_of(nearer, camera, {3, 4, 1})};
  EXPECT_EQ(hashes.size(), 6U);
  EXPECT_EQ(hash_of(depth_mm, camera, {3, 4, 1}), hash_of(depth_mm, camera, {3, 4, 1}));
}

TEST(Checkpoint, IsRemovedWithTheTreeThatWasGrowing) {
  const testing::TemporaryFolder folder;
  for (const char* name : {"forest.checkpoint", "forest.checkpoint.tree", "other"})
    write_text_file(folder / name, "x");
  remove_checkpoint(folder / "forest.checkpoint");
  remove_checkpoint({});
  std::set<std::string> left;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    left.insert(entry.path().filename());
  EXPECT_EQ(left, std::set<std::string>{"other"});
}

}  // namespace
}  // namespace knuckle
