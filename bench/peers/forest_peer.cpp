// SPDX-License-Identifier: Apache-2.0
// Knuckle's forest engine against OpenCV's cv::ml::RTrees on one table of samples: 200 fixed features
// (equation 1) of pixels of made-up scenes, the same number of trees, depth, features tried a node and least
// leaf. Built where OpenCV's ml module is installed (libopencv-ml-dev); not part of the library.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <functional>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/ml.hpp>

#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/random.h"
#include "knuckle/forest/class_statistics.h"
#include "knuckle/forest/forest_testing.h"
#include "knuckle/forest/offset_features.h"
#include "knuckle/forest/tree_grower.h"

namespace knuckle {
namespace {

constexpr int kFeatures = 200;
constexpr int kTried = 14;  // features a node: the root of their number, OpenCV's own default
constexpr int kTrees = 4;
constexpr int kDepth = 25;
constexpr int kLeastLeaf = 5;

/// One row of features a sample.
struct Table {
  std::vector<std::int16_t> values;
  std::vector<std::uint8_t> labels;

  std::size_t rows() const { return labels.size(); }
  std::int16_t at(std::size_t row, std::size_t feature) const { return values[row * kFeatures + feature]; }
};

/// Pixels of balls before a wall, all of them, with noise of 80 mm.
Table table_of(int first_scene, int scenes, const std::vector<OffsetPair>& features) {
  Table table;
  for (int i = first_scene; i < first_scene + scenes; ++i) {
    testing::BallScene scene(static_cast<std::uint64_t>(i), 160, 120, 60);
    Random noise(99, static_cast<std::uint64_t>(i));
    for (float& depth : scene.depth_mm.pixels()) {
      if (depth > 0.0F) depth += static_cast<float>(80.0 * noise.normal());
    }
    const BorderedDepth depth(scene.depth_mm);
    const OffsetScale scale(scene.camera);
    for (const auto& [column, row, label] : scene.pixels) {
      for (const OffsetPair& feature : features) {
        table.values.push_back(offset_feature(depth, column, row, scale.at(depth(column, row)), feature));
      }
      table.labels.push_back(label);
    }
  }
  return table;
}

/// Columns of a table as split features: a model of the concept SplitFeatures.
class TableFeatures {
 public:
  using Feature = std::uint16_t;
  using Candidate = std::uint16_t;
  struct Block {
    std::vector<std::uint16_t> drawn;
    std::vector<std::vector<std::int16_t>> columns;  // those that were drawn
  };
  using Loop = void (*)(std::int64_t count, const std::function<void(std::int64_t)>& work);

  explicit TableFeatures(const Table& table) : table_(&table) {}

  void begin_node(Random& random, const TreeOptions& options, Block& block) const {
    block.drawn.resize(kFeatures);
    std::iota(block.drawn.begin(), block.drawn.end(), std::uint16_t{0});
    for (std::size_t i = 0; i < static_cast<std::size_t>(options.splits_per_node); ++i) {
      std::swap(block.drawn[i], block.drawn[i + random.below(static_cast<std::uint32_t>(kFeatures - i))]);
    }
    block.columns.resize(static_cast<std::size_t>(options.splits_per_node));
  }
  void gather(std::span<const std::uint32_t> samples, Loop loop, Block& block) const {
    loop(std::ssize(block.columns), [&](std::int64_t column) {
      const auto index = static_cast<std::size_t>(column);
      block.columns[index].resize(samples.size());
      for (std::size_t i = 0; i < samples.size(); ++i) {
        block.columns[index][i] = table_->at(samples[i], block.drawn[index]);
      }
    });
  }
  std::uint16_t draw(Random& /*random*/, int index, int /*count*/, const Block& /*block*/) const {
    return static_cast<std::uint16_t>(index);
  }
  static void values(const Block& block, std::uint16_t candidate, std::int16_t* values) {
    std::ranges::copy(block.columns[candidate], values);
  }
  static std::uint16_t feature(const Block& block, std::uint16_t candidate) { return block.drawn[candidate]; }
  static bool can_read(std::uint16_t /*feature*/) { return true; }  // all are drawn here
  std::int16_t value(std::uint32_t sample, std::uint16_t feature) const {
    return table_->at(sample, feature);
  }

 private:
  const Table* table_;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void report(const std::string& name, double wall, double processor, std::size_t right, std::size_t all) {
  fmt::print("{:<10} training {:7.2f} s, {:7.2f} s of processor time, {:.4f} of {} pixels right\n", name,
             wall, processor, static_cast<double>(right) / static_cast<double>(all), all);
}

double processor_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Part of class 1 in the leaf that a row reaches.
double leaf_part(const GrownTree<std::uint16_t>& tree, const Table& training, const Table& table,
                 std::size_t row) {
  std::size_t node = 0;
  while (tree.nodes[node].left >= 0) {
    const bool is_right = table.at(row, tree.nodes[node].feature) >= tree.nodes[node].threshold;
    node = static_cast<std::size_t>(tree.nodes[node].left) + (is_right ? 1 : 0);
  }
  const auto samples = tree.samples_of(tree.nodes[node]);
  std::size_t ones = 0;
  for (const std::uint32_t sample : samples) ones += training.labels[sample];
  return static_cast<double>(ones) / static_cast<double>(samples.size());
}

void run_knuckle(const Table& training, const Table& test) {
  TreeOptions options;
  options.max_depth = kDepth;
  options.splits_per_node = kTried;
  options.samples_per_node = 65535;
  options.min_leaf_samples = kLeastLeaf;
  options.threshold_bins = 256;
  options.bagging_fraction = 0.632;  // what a bootstrap sample, OpenCV's way, holds of different samples
  const auto start = std::chrono::steady_clock::now();
  const double processor = processor_seconds();
  const TableFeatures features(training);
  const ClassStatistics statistics(training.labels);
  std::vector<std::uint32_t> order(training.rows());
  std::iota(order.begin(), order.end(), 0U);
  TreeGrower<TableFeatures, ClassStatistics> grower(features, statistics, options);
  std::vector<GrownTree<std::uint16_t>> trees;
  Progress progress("knuckle", "steps", std::int64_t{kTrees} * kDepth * 1000);
  for (int tree = 0; tree < kTrees; ++tree) {
    SplitLog<std::uint16_t> log;
    trees.push_back(grower.grow(order, derived_seed(1, static_cast<std::uint64_t>(tree)), progress, log,
                                [](const auto&) {}));
  }
  const double wall = seconds_since(start);
  const double spent = processor_seconds() - processor;
  std::size_t right = 0;
  for (std::size_t row = 0; row < test.rows(); ++row) {
    double sum = 0.0;
    for (const GrownTree<std::uint16_t>& tree : trees) sum += leaf_part(tree, training, test, row);
    right += (sum > 0.5 * kTrees) == (test.labels[row] == 1) ? 1U : 0U;
  }
  report("knuckle", wall, spent, right, test.rows());
}

cv::Mat_<float> as_floats(const Table& table) {
  cv::Mat_<float> rows(static_cast<int>(table.rows()), kFeatures);
  std::ranges::copy(table.values, rows.begin());
  return rows;
}

void run_opencv(const Table& training, const Table& test) {
  const cv::Mat_<int> labels(cv::Mat(training.labels, true).reshape(1, static_cast<int>(training.rows())));
  const auto data = cv::ml::TrainData::create(as_floats(training), cv::ml::ROW_SAMPLE, labels);
  const auto forest = cv::ml::RTrees::create();
  forest->setMaxDepth(kDepth);
  forest->setMinSampleCount(2 * kLeastLeaf);
  forest->setActiveVarCount(kTried);
  forest->setTermCriteria({cv::TermCriteria::MAX_ITER, kTrees, 0.0});
  const auto start = std::chrono::steady_clock::now();
  const double processor = processor_seconds();
  forest->train(data);
  const double wall = seconds_since(start);
  const double spent = processor_seconds() - processor;
  cv::Mat answers;
  forest->predict(as_floats(test), answers);
  std::size_t right = 0;
  for (std::size_t row = 0; row < test.rows(); ++row) {
    right += (answers.at<float>(static_cast<int>(row)) > 0.5F) == (test.labels[row] == 1) ? 1U : 0U;
  }
  report("OpenCV", wall, spent, right, test.rows());
}

}  // namespace
}  // namespace knuckle

int main() {
  using namespace knuckle;
  show_progress(false);
  std::vector<OffsetPair> features;
  Random random(1);
  for (int i = 0; i < kFeatures; ++i) {
    const DepthOffset first = drawn_offset({}, random);
    features.push_back({first.x, first.y, 0, 0});
  }
  for (const int scenes : {100, 500}) {
    const Table training = table_of(0, scenes, features);
    const Table test = table_of(100000, 100, features);
    fmt::print("{} samples of {} features, {} trees of depth {}, {} threads\n", training.rows(), kFeatures,
               kTrees, kDepth, thread_count());
    run_knuckle(training, test);
    run_opencv(training, test);
  }
  return 0;
}
