// SPDX-License-Identifier: Apache-2.0
// What another worker says is not believed where it cannot be.
#include <array>
#include <cmath>
#include <limits>

#include "knuckle/core/testing.h"
#include "knuckle/core/worker_group_testing.h"
#include "knuckle/forest/forest_growth.h"
#include "knuckle/forest/offset_features.h"
#include "knuckle/forest/pixel_pairs.h"
#include "knuckle/forest/sample_moves.h"
#include "knuckle/forest/scoring_targets.h"
#include "knuckle/forest/shared_leaves.h"
#include "knuckle/forest/shared_places.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::message_of;
using testing::ToldWorkers;

/// The length of a message, as it is announced.
std::vector<std::byte> length(std::int64_t bytes) {
  return message_of(bytes);
}

/// What of a node the other worker says, as summed_shares sends it.
std::string fault_of_share(std::int64_t total, std::int64_t before, std::int64_t holder) {
  // One node is worker 1's to sum up: this one sends its number and is told the sum.
  ToldWorkers workers({{}, message_of(total, before, holder)});
  return error_of([&] { summed_shares(workers, std::array{3U}); });
}

TEST(ToldWorkers, SharesThatNoNodeHasAreRefused) {
  const auto is_refused = HasSubstr("a worker's message: a node of");
  EXPECT_THAT(fault_of_share(2, 0, NodeShare::kSeveral), is_refused) << "this worker has three";
  EXPECT_THAT(fault_of_share(5, 3, NodeShare::kSeveral), is_refused);
  EXPECT_THAT(fault_of_share(5, -1, NodeShare::kSeveral), is_refused);
  EXPECT_THAT(fault_of_share(5, 0, 2), is_refused);
  EXPECT_THAT(fault_of_share(5, 0, -2), is_refused);
  EXPECT_THAT(fault_of_share(std::int64_t{1} << 60, 0, 0), is_refused);
  ToldWorkers workers({{}, message_of(std::int64_t{5}, std::int64_t{2}, std::int64_t{1})});
  EXPECT_EQ(summed_shares(workers, std::array{3U})[0].holder, 1);
}

TEST(ToldWorkers, NumbersOfSamplesThatCannotBeAreRefused) {
  for (const std::int64_t count : {std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()}) {
    ToldWorkers workers({message_of(count)});
    EXPECT_THAT(error_of([&] { sum_of_workers(workers, 1); }), HasSubstr("worker 1 of 2: has"));
  }
}

TEST(ToldWorkers, APlaceThatNoSampleHasIsRefused) {
  // A key of the upper half of all hashes is worker 1's to sort, which says where it comes.
  const std::array own{SampleKey{~std::uint64_t{0}, 0}};
  for (const std::int64_t place : {std::int64_t{-1}, std::int64_t{1}}) {
    ToldWorkers workers({length(0), {}, message_of(std::int64_t{1}), length(8), message_of(place)});
    EXPECT_THAT(error_of([&] { canonical_places(workers, own); }), HasSubstr("a sample with place"));
  }
}

/// Slots of 32 bits.
struct Slots {
  std::size_t message_bytes(std::uint32_t /*slot*/) const { return 8 + sizeof(std::uint32_t); }
  void take(std::uint32_t slot, std::vector<std::byte>& message) { append_value(message, slot); }
  std::uint32_t put(MessageReader& reader) { return reader.value<std::uint32_t>(); }
};

TEST(ToldWorkers, ASampleThatIsNotSentIsMissed) {
  Slots slots;
  const std::array<std::int64_t, 3> cuts{0, 2, 3};
  const auto moved = [&](ToldWorkers& workers) {
    return moved_to_places(workers, slots, std::array{7U}, std::array{std::int64_t{0}}, cuts);
  };
  ToldWorkers sends({length(12), length(12), message_of(std::int64_t{1}, 9U)});
  EXPECT_EQ(moved(sends), (std::vector<std::uint32_t>{7, 9}));
  ToldWorkers keeps({length(0)});
  EXPECT_THAT(error_of([&] { moved(keeps); }), HasSubstr("have not sent the samples of all places"));
  ToldWorkers boasts({length(std::numeric_limits<std::int64_t>::max())});
  EXPECT_THAT(error_of([&] { moved(boasts); }), HasSubstr("a worker says that it sends"));
}

TEST(ToldWorkers, ASampleOfAPlaceThatIsNoWorkersIsRefused) {
  Slots slots;
  const std::array<std::int64_t, 3> cuts{0, 2, 3};
  for (const std::int64_t place : {std::int64_t{-1}, std::int64_t{3}}) {
    ToldWorkers workers({});
    EXPECT_THAT(error_of([&] { moved_to_places(workers, slots, std::array{7U}, std::array{place}, cuts); }),
                HasSubstr("a sample with place"));
  }
}

TEST(ToldWorkers, MoreSamplesOfAClassThanALeafHasAreRefused) {
  const std::array<std::uint32_t, 1> own{0};
  const SharedLeaf leaf{own, {.first = 0, .total = 2, .before = 0, .holder = NodeShare::kSeveral}};
  const std::array<std::uint8_t, 1> labels{1};
  ToldWorkers sound({length(4), message_of(1U)});
  EXPECT_EQ(shared_class_counts(sound, labels, std::span(&leaf, 1))[0].ones, 2);
  ToldWorkers wrong({length(4), message_of(2U)});
  EXPECT_THAT(error_of([&] { shared_class_counts(wrong, labels, std::span(&leaf, 1)); }),
              HasSubstr("3 of 2 samples of a leaf"));
}

TEST(ToldWorkers, ASumThatIsNoNumberIsRefused) {
  TrainingSamples samples(1, 1, 1);
  samples.set(0, std::array{1.0F}, std::array{1.0F});
  const std::array order{0U};
  ToldWorkers workers({length(0), {}, length(24), message_of(std::nan(""), 0.0, std::int64_t{2})});
  const SamplesInOrder rows{.order = order, .workers = &workers, .count = {.total = 2, .before = 0}};
  EXPECT_THAT(error_of([&] { make_scoring_targets(samples, rows, {}, 1); }), HasSubstr("a sum of 2 rows"));
}

/// A training sample of two features.
TrainingSamples two_samples() {
  TrainingSamples samples(2, 2, 1);
  samples.set(0, std::array{1.0F, 2.0F}, std::array{1.0F});
  samples.set(1, std::array{3.0F, 1.0F}, std::array{2.0F});
  return samples;
}

TEST(ToldWorkers, SplitsReadWhatSamplesHave) {
  const TrainingSamples samples = two_samples();
  const PixelPairFeatures features(samples);
  using Split = NodeSplit<PixelPair>;
  const auto check = [&](const Split& split) { check_splits(features, std::span<const Split>(&split, 1)); };
  EXPECT_NO_THROW(check({.feature = {1, 0}, .threshold = 0, .gain = 1.0F}));
  EXPECT_NO_THROW(check({.feature = {9, 9}, .threshold = 0, .gain = 0.0F})) << "a leaf reads nothing";
  EXPECT_THAT(error_of([&] {
                check({.feature = {2, 0}, .threshold = 0, .gain = 1.0F});
              }),
              HasSubstr("reads what no sample has"));
  EXPECT_THAT(error_of([&] {
                check({.feature = {0, 2}, .threshold = 0, .gain = 1.0F});
              }),
              HasSubstr("reads what no sample has"));
}

TEST(ToldWorkers, OffsetsAreThoseThatThereAre) {
  constexpr std::int16_t kMost = kMostOffset;
  EXPECT_TRUE(OffsetFeatures::can_read({kMost, -kMost, -kMost, kMost}));
  EXPECT_FALSE(OffsetFeatures::can_read({kMost + 1, 0, 0, 0}));
  EXPECT_FALSE(OffsetFeatures::can_read({0, -kMost - 1, 0, 0}));
  EXPECT_FALSE(OffsetFeatures::can_read({0, 0, kMost + 1, 0}));
  EXPECT_FALSE(OffsetFeatures::can_read({0, 0, 0, -kMost - 1}));
}

TEST(ToldWorkers, ALogOfPartsOfSplitsIsRefused) {
  ToldWorkers workers({length(0), {}});
  EXPECT_TRUE(log_of_first<PixelPair>(workers, {}).empty());
  ToldWorkers others({length(3), std::vector<std::byte>(3)});
  EXPECT_TRUE(log_of_first<PixelPair>(others, {}).empty()) << "only worker 0 has one";
}

}  // namespace
}  // namespace knuckle
