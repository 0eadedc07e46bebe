// SPDX-License-Identifier: Apache-2.0
// What another worker says while a tree grows is not believed where it cannot be.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/progress.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/worker_group_testing.h"
#include "knuckle/forest/class_statistics.h"
#include "knuckle/forest/pixel_pairs.h"
#include "knuckle/forest/shared_growth.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::message_of;
using testing::ToldWorkers;

using Told = std::vector<std::vector<std::byte>>;
using Grower = SharedTreeGrower<PixelPairFeatures, ClassStatistics>;

/// What this worker's two samples of four are split by: one goes to each side.
constexpr NodeSplit<PixelPair> kSplit{.feature = {1, 0}, .threshold = 0, .gain = 1.0F};

/// Grows a tree of one level from four samples, the first two of them this worker's.
void grow(Told told, Grower::Log log, std::int64_t before = 0) {
  TrainingSamples samples(2, 2, 1);
  samples.set(0, std::array{1.0F, 2.0F}, std::array{1.0F});
  samples.set(1, std::array{3.0F, 1.0F}, std::array{2.0F});
  const PixelPairFeatures features(samples);
  const std::array<std::uint8_t, 2> labels{0, 1};
  const ClassStatistics statistics(labels);
  TreeOptions options;
  options.max_depth = 1;
  options.splits_per_node = 5;
  options.min_leaf_samples = 1;
  ToldWorkers workers(std::move(told));
  Progress progress("grow", "steps", Grower::kStepsPerLevel);
  Grower grower(workers, features, statistics, options, nullptr);
  grower.grow({.samples = {0, 1}, .count = {.total = 4, .before = before}}, 1, progress, log,
              [](const Grower::Log&) {});
}

std::string fault_of(const Told& told, const Grower::Log& log, std::int64_t before = 0) {
  return error_of([&] { grow(told, log, before); });
}

/// What worker 1 says of a node that it sums up: its samples in all, none of them before this worker's.
std::vector<std::byte> sum_of(std::int64_t total) {
  return message_of(total, std::int64_t{0}, std::int64_t{NodeShare::kSeveral});
}

/// The root is worker 1's to sum up; its own part begins with the third sample.
Told root(std::int64_t total = 4, std::int64_t begin_of_other = 2) {
  return {{}, sum_of(total), message_of(begin_of_other)};
}

Told and_then(Told told, const Told& more) {
  told.insert(told.end(), more.begin(), more.end());
  return told;
}

TEST(ToldGrowth, ATreeOfMoreSamplesThanThereAreIsRefused) {
  EXPECT_THAT(fault_of(root(5), {kSplit}), HasSubstr("have 5 samples of a tree, expected 4"));
}

TEST(ToldGrowth, PartsThatDoNotFollowOneAnotherAreRefused) {
  const auto is_refused = HasSubstr("do not follow one another");
  EXPECT_THAT(fault_of(root(4, 5), {kSplit}), is_refused) << "behind all samples";
  EXPECT_THAT(fault_of(root(4, -1), {kSplit}), is_refused) << "before this worker's";
  EXPECT_THAT(fault_of(root(), {kSplit}, 1), is_refused) << "the first sample is nobody's";
}

TEST(ToldGrowth, AMessageOfSamplesThatGoesOnIsRefused) {
  const std::vector<std::byte> no_samples = message_of(0U, std::uint16_t{7});
  EXPECT_THAT(fault_of(and_then(root(), {message_of(std::ssize(no_samples)), no_samples}), {}),
              HasSubstr("a worker's message of samples has 2 bytes too many"));
}

TEST(ToldGrowth, ChildrenOfMoreSamplesThanTheirNodeAreRefused) {
  // Each worker sums up one of the children: worker 1 has one sample of the left one, and says what the
  // right one has in all.
  const auto children = [](std::int64_t right) { return Told{message_of(1U), sum_of(right)}; };
  EXPECT_THAT(fault_of(and_then(root(), children(3)), {kSplit}),
              HasSubstr("disagree on the samples of a node"));
  EXPECT_NO_THROW(grow(and_then(root(), children(2)), {kSplit}));
}

}  // namespace
}  // namespace knuckle
