// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/shared_places.h"

#include <algorithm>
#include <numeric>

#include "knuckle/core/testing.h"
#include "knuckle/core/worker_group_testing.h"
#include "knuckle/forest/mixed_hash.h"
#include "knuckle/forest/sample_moves.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::ThreadWorkers;

/// Keys of which some have the same hash.
std::vector<SampleKey> random_keys(int count) {
  std::vector<SampleKey> keys;
  for (int i = 0; i < count; ++i) keys.push_back({mixed_hash(7, static_cast<std::uint64_t>(i / 3)), i});
  return keys;
}

class SharedPlacesOf : public ::testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Workers, SharedPlacesOf, ::testing::Values(1, 2, 3, 5));

TEST_P(SharedPlacesOf, WorkersAreThoseOfAllKeysSorted) {
  std::vector<SampleKey> keys = random_keys(50);
  std::vector<std::size_t> order(keys.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return std::pair(keys[i].hash, keys[i].number); });
  std::vector<std::int64_t> expected(keys.size());
  for (std::size_t place = 0; place < order.size(); ++place) {
    expected[order[place]] = static_cast<std::int64_t>(place);
  }
  const int count = GetParam();
  ThreadWorkers(count).run([&](WorkerGroup& workers) {
    std::vector<SampleKey> own;
    std::vector<std::int64_t> own_expected;
    for (std::size_t i = static_cast<std::size_t>(workers.rank()); i < keys.size();
         i += static_cast<std::size_t>(count)) {
      own.push_back(keys[i]);
      own_expected.push_back(expected[i]);
    }
    const CanonicalPlaces places = canonical_places(workers, own);
    EXPECT_EQ(places.total, 50);
    EXPECT_EQ(places.places, own_expected);
  });
}

TEST_P(SharedPlacesOf, WorkersAddUpToTheSharesOfNodes) {
  const int count = GetParam();
  const auto of = [](int worker, std::size_t node) {
    if (node == 2) return worker == 0 ? 9U : 0U;  // one worker has all of it
    return static_cast<std::uint32_t>((worker + 2) * (static_cast<int>(node) + 1));
  };
  ThreadWorkers(count).run([&](WorkerGroup& workers) {
    std::vector<std::uint32_t> own;
    for (std::size_t node = 0; node < 7; ++node) own.push_back(of(workers.rank(), node));
    const std::vector<NodeShare> shares = summed_shares(workers, own);
    ASSERT_EQ(shares.size(), 7U);
    for (std::size_t node = 0; node < 7; ++node) {
      std::int64_t total = 0;
      std::int64_t before = 0;
      for (int k = 0; k < count; ++k) {
        if (k == workers.rank()) before = total;
        total += of(k, node);
      }
      EXPECT_EQ(shares[node].total, total);
      EXPECT_EQ(shares[node].before, before);
      EXPECT_EQ(shares[node].holder, node == 2 || count == 1 ? 0 : NodeShare::kSeveral);
    }
    EXPECT_TRUE(summed_shares(workers, {}).empty());
  });
}

TEST_P(SharedPlacesOf, WorkersChainAHashAsOneProcessDoes) {
  std::uint64_t expected = 0;
  for (std::uint64_t word = 0; word < 20; ++word) expected = mixed_hash(expected, word);
  ThreadWorkers(GetParam()).run([&](WorkerGroup& workers) {
    const PartOfWork part = part_of_worker(20, workers.rank(), workers.size());
    std::vector<std::uint64_t> own(static_cast<std::size_t>(part.size()));
    std::iota(own.begin(), own.end(), static_cast<std::uint64_t>(part.begin));
    EXPECT_EQ(chained_hash(workers, own), expected);
  });
}

/// Samples that are numbers, of different lengths.
class NumberStore {
 public:
  explicit NumberStore(std::vector<std::int64_t> numbers) : numbers_(std::move(numbers)) {}
  std::size_t message_bytes(std::uint32_t slot) const { return 8U + padding_of(numbers_[slot]); }
  void take(std::uint32_t slot, std::vector<std::byte>& message) {
    append_value(message, numbers_[slot]);
    message.resize(message.size() + padding_of(numbers_[slot]));
    numbers_[slot] = -1;
    free_.push_back(slot);
  }
  std::uint32_t put(MessageReader& reader) {
    if (free_.empty()) {
      free_.push_back(static_cast<std::uint32_t>(numbers_.size()));
      numbers_.push_back(0);
    }
    const std::uint32_t slot = free_.back();
    free_.pop_back();
    numbers_[slot] = reader.value<std::int64_t>();
    reader.bytes(padding_of(numbers_[slot]));
    return slot;
  }
  std::int64_t number(std::uint32_t slot) const { return numbers_[slot]; }
  std::size_t slots() const { return numbers_.size(); }

 private:
  /// Large enough that samples go in several rounds.
  static std::size_t padding_of(std::int64_t number) {
    return static_cast<std::size_t>(kMoveBytes / 16 * (number % 3));
  }
  std::vector<std::int64_t> numbers_;
  std::vector<std::uint32_t> free_;
};

TEST_P(SharedPlacesOf, WorkersGetTheSamplesWhosePlacesAreTheirs) {
  constexpr std::int64_t kCount = 90;
  const auto place_of = [](std::int64_t number) { return number * 37 % kCount; };
  ThreadWorkers(GetParam()).run([&](WorkerGroup& workers) {
    const PartOfWork part = part_of_worker(kCount, workers.rank(), workers.size());
    std::vector<std::int64_t> numbers(static_cast<std::size_t>(part.size()));
    std::iota(numbers.begin(), numbers.end(), part.begin);
    std::vector<std::int64_t> places;
    for (const std::int64_t number : numbers) places.push_back(place_of(number));
    std::vector<std::uint32_t> slots(numbers.size());
    std::iota(slots.begin(), slots.end(), 0U);
    NumberStore store(numbers);
    const std::vector<std::uint32_t> arranged =
        moved_to_places(workers, store, slots, places, equal_cuts(kCount, workers.size()));
    ASSERT_EQ(std::ssize(arranged), part.size());
    for (std::size_t i = 0; i < arranged.size(); ++i) {
      EXPECT_EQ(place_of(store.number(arranged[i])), part.begin + static_cast<std::int64_t>(i));
    }
    EXPECT_LE(store.slots(), numbers.size() + 40) << "room is used again";
  });
}

TEST(SharedPlaces, ASampleForAnotherWorkersPlaceIsRefused) {
  ThreadWorkers(2).run([](WorkerGroup& workers) {
    // The second worker thinks that the first has three places.
    const bool is_first = workers.rank() == 0;
    NumberStore store({0, 3});
    const std::vector<std::uint32_t> slots{0, 1};
    const std::vector<std::int64_t> places =
        is_first ? std::vector<std::int64_t>{0, 1} : std::vector<std::int64_t>{2, 3};
    const auto move = [&] {
      moved_to_places(workers, store, slots, places,
                      is_first ? std::vector<std::int64_t>{0, 2, 4} : std::vector<std::int64_t>{0, 3, 4});
    };
    if (is_first) {
      EXPECT_THAT(error_of(move), HasSubstr("a sample with place 2, expected [0, 2)"));
    } else {
      move();
    }
  });
}

TEST(WorkerMessages, EndEarlyWithAnError) {
  std::vector<std::byte> message;
  append_value(message, std::uint32_t{7});
  MessageReader reader(message);
  EXPECT_EQ(reader.value<std::uint16_t>(), 7);
  EXPECT_THAT(error_of([&] { reader.value<std::uint32_t>(); }), HasSubstr("ends early"));
}

}  // namespace
}  // namespace knuckle
