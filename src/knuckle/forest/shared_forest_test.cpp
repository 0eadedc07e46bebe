// SPDX-License-Identifier: Apache-2.0
// Forests that several workers train together are those of one process.
#include <filesystem>
#include <optional>
#include <stdexcept>

#include "knuckle/core/testing.h"
#include "knuckle/core/worker_group_testing.h"
#include "knuckle/forest/forest_testing.h"
#include "knuckle/forest/forest_trainer.h"
#include "knuckle/forest/pixel_forest_trainer.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::ball_scenes;
using testing::BallScene;
using testing::error_of;
using ::testing::HasSubstr;
using testing::RandomRows;
using testing::TemporaryFolder;
using testing::ThreadWorkers;

/// The rows of one worker of several, with a gap: a sample that is not set.
TrainingSamples part_of(const RandomRows& rows, const PartOfWork& part) {
  TrainingSamples samples(part.size(), static_cast<int>(rows.features[0].size()),
                          static_cast<int>(rows.targets[0].size()));
  for (std::int64_t i = part.begin; i < part.end; ++i) {
    const auto row = static_cast<std::size_t>(i);
    if (i % 11 != 3) samples.set(i - part.begin, rows.features[row], rows.targets[row]);
  }
  return samples;
}

RegressionForest trained_alone(const RandomRows& rows, const RegressionForestOptions& options) {
  return train_regression_forest(part_of(rows, {0, std::ssize(rows.features)}), options);
}

RegressionForest trained_by(int count, const RandomRows& rows, const RegressionForestOptions& options) {
  std::optional<RegressionForest> forest;
  ThreadWorkers(count).run([&](WorkerGroup& workers) {
    const PartOfWork part = part_of_worker(std::ssize(rows.features), workers.rank(), count);
    TrainingSamples samples = part_of(rows, part);
    auto trained = train_regression_forest(workers, samples, part.begin, options);
    EXPECT_EQ(trained.has_value(), workers.rank() == 0);
    if (trained) forest = std::move(trained);
  });
  return *forest;
}

void expect_equal_forests(const RegressionForest& a, const RegressionForest& b) {
  testing::expect_same_trees(a.parts().trees, b.parts().trees);
  EXPECT_EQ(a.parts().leaves.decoded(), b.parts().leaves.decoded());
}

class SharedForestOf : public ::testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Workers, SharedForestOf, ::testing::Values(1, 2, 3, 4));

TEST_P(SharedForestOf, WorkersIsTheRegressionForestOfOne) {
  const RandomRows rows(3000, 25, 20);  // more targets than are scored
  RegressionForestOptions options;
  options.trees = 2;
  options.tree.splits_per_node = 30;
  options.tree.samples_per_node = 700;  // fewer than the first nodes have
  options.tree.min_leaf_samples = 2;
  options.tree.bagging_fraction = 0.8;
  options.leaf_bits = 32;
  expect_equal_forests(trained_alone(rows, options), trained_by(GetParam(), rows, options));
}

TEST_P(SharedForestOf, WorkersHasTheLeavesOfOneWhereTheyAreShared) {
  const RandomRows rows(5000, 10, 3);  // beyond a chunk of the sum of targets
  RegressionForestOptions options;
  options.trees = 2;
  options.tree.splits_per_node = 10;
  options.tree.max_depth = 1;
  options.scoring_dimensions = 2;
  options.leaf_bits = 32;
  expect_equal_forests(trained_alone(rows, options), trained_by(GetParam(), rows, options));
}

TEST_P(SharedForestOf, WorkersTakesSamplesThatAreAllAlike) {
  RandomRows rows(200, 10, 3);
  for (std::size_t i = 0; i < 200; ++i) {
    rows.features[i] = rows.features[i % 3];
    rows.targets[i] = rows.targets[i % 3];
  }
  RegressionForestOptions options;
  options.trees = 1;
  options.tree.splits_per_node = 10;
  expect_equal_forests(trained_alone(rows, options), trained_by(GetParam(), rows, options));
}

PixelForestOptions pixel_options() {
  PixelForestOptions options;
  options.trees = 2;
  options.tree.splits_per_node = 40;
  options.tree.samples_per_node = 200;
  options.tree.min_leaf_samples = 2;
  options.tree.bagging_fraction = 0.9;
  options.offsets.offsets_per_node = 32;
  return options;
}

/// Some scenes have no pixels.
PixelSamples part_of(const std::vector<BallScene>& scenes, const PartOfWork& part) {
  PixelSamples samples(part.size());
  for (std::int64_t i = part.begin; i < part.end; ++i) {
    const BallScene& scene = scenes[static_cast<std::size_t>(i)];
    const std::vector<LabelledPixel> none;
    samples.set(i - part.begin, scene.depth_mm, scene.camera, i % 7 == 2 ? none : scene.pixels);
  }
  return samples;
}

PixelForest trained_alone(const std::vector<BallScene>& scenes, const PixelForestOptions& options) {
  return train_pixel_forest(part_of(scenes, {0, std::ssize(scenes)}), options);
}

PixelForest trained_by(int count, const std::vector<BallScene>& scenes, const PixelForestOptions& options,
                       const TrainingRun& run = {}) {
  std::optional<PixelForest> forest;
  ThreadWorkers(count).run([&](WorkerGroup& workers) {
    const PartOfWork part = part_of_worker(std::ssize(scenes), workers.rank(), count);
    PixelSamples samples = part_of(scenes, part);
    TrainingRun own = run;
    if (workers.rank() > 0) own.checkpoint.clear();
    auto trained = train_pixel_forest(workers, samples, part.begin, options, own);
    EXPECT_EQ(trained.has_value(), workers.rank() == 0);
    if (trained) forest = std::move(trained);
  });
  return *forest;
}

void expect_equal_forests(const PixelForest& a, const PixelForest& b) {
  testing::expect_same_trees(a.parts().trees, b.parts().trees);
  EXPECT_EQ(a.parts().leaf_codes, b.parts().leaf_codes);
}

TEST_P(SharedForestOf, WorkersIsThePixelForestOfOne) {
  const std::vector<BallScene> scenes = ball_scenes(40);
  expect_equal_forests(trained_alone(scenes, pixel_options()),
                       trained_by(GetParam(), scenes, pixel_options()));
}

TEST_P(SharedForestOf, WorkersTakesTheSameImageTwice) {
  std::vector<BallScene> scenes = ball_scenes(6);
  scenes.insert(scenes.end(), 6, scenes[1]);
  expect_equal_forests(trained_alone(scenes, pixel_options()),
                       trained_by(GetParam(), scenes, pixel_options()));
}

TEST(SharedForest, OfMoreWorkersThanSamplesIsThatOfOne) {
  const RandomRows rows(3, 5, 2);
  RegressionForestOptions options;
  options.trees = 2;
  options.tree.splits_per_node = 10;
  options.tree.min_leaf_samples = 1;
  expect_equal_forests(trained_alone(rows, options), trained_by(5, rows, options));
}

struct Stop : std::runtime_error {
  Stop() : std::runtime_error("stopped") {}
};

/// Stops all workers after the same batch of nodes: one alone would leave the others waiting.
void stop_after(std::size_t batches, const std::vector<BallScene>& scenes,
                const std::filesystem::path& checkpoint) {
  ThreadWorkers(3).run([&](WorkerGroup& workers) {
    const PartOfWork part = part_of_worker(std::ssize(scenes), workers.rank(), 3);
    PixelSamples samples = part_of(scenes, part);
    TrainingRun run;
    if (workers.rank() == 0) run.checkpoint = checkpoint;
    std::size_t done = 0;
    run.nodes_done = [&](std::size_t) {
      if (++done == batches) throw Stop();
    };
    static_cast<void>(train_pixel_forest(workers, samples, part.begin, pixel_options(), run));
  });
}

TEST(SharedForest, GoesOnWithAnotherNumberOfWorkersFromWhereverItWasStopped) {
  const TemporaryFolder folder;
  const std::vector<BallScene> scenes = ball_scenes(20);
  const PixelForest whole = trained_alone(scenes, pixel_options());
  for (const std::size_t stop : {1, 4, 7, 10}) {
    EXPECT_THROW(stop_after(stop, scenes, folder / "c.model"), Stop);
    ASSERT_TRUE(std::filesystem::exists(folder / "c.model.tree"));
    const TrainingRun resumed{.checkpoint = folder / "c.model"};
    expect_equal_forests(whole, stop % 2 == 0 ? trained_by(2, scenes, pixel_options(), resumed)
                                              : train_pixel_forest(part_of(scenes, {0, std::ssize(scenes)}),
                                                                   pixel_options(), resumed));
    EXPECT_FALSE(std::filesystem::exists(folder / "c.model"));
    EXPECT_FALSE(std::filesystem::exists(folder / "c.model.tree"));
  }
}

TEST(SharedForest, WorkersThatSendTooFewSamplesAreNoticed) {
  const RandomRows rows(400, 5, 2);
  const auto train = [&](WorkerGroup& workers) {
    const PartOfWork part = part_of_worker(400, workers.rank(), 2);
    TrainingSamples samples = part_of(rows, part);
    RegressionForestOptions options;
    options.tree.splits_per_node = 10;
    options.tree.samples_per_node = workers.rank() == 0 ? 1000 : 100;
    static_cast<void>(train_regression_forest(workers, samples, part.begin, options));
  };
  EXPECT_THAT(error_of([&] { ThreadWorkers(2).run(train); }),
              AllOf(HasSubstr("samples of node 0, expected 363"), HasSubstr("workers have sent")));
}

TEST(SharedForest, NamesTheFault) {
  const RandomRows rows(40, 5, 2);
  RegressionForestOptions options;
  options.memory_gb = 1e-6;
  EXPECT_THAT(error_of([&] { trained_by(2, rows, options); }), HasSubstr("memory_gb"));
  EXPECT_THAT(error_of([&] {
                ThreadWorkers(2).run([](WorkerGroup& workers) {
                  TrainingSamples none(5, 3, 2);
                  static_cast<void>(train_regression_forest(workers, none, 0, RegressionForestOptions()));
                });
              }),
              HasSubstr("forest training: there are no samples"));
  std::vector<BallScene> scenes = ball_scenes(4);
  for (BallScene& scene : scenes) {
    std::erase_if(scene.pixels, [](const LabelledPixel& pixel) { return pixel.label == 0; });
  }
  EXPECT_THAT(error_of([&] { trained_by(2, scenes, pixel_options()); }), HasSubstr("expected both classes"));
}

}  // namespace
}  // namespace knuckle
