// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/shared_places.h"

#include <algorithm>
#include <cstddef>
#include <tuple>

#include "knuckle/core/error.h"
#include "knuckle/core/worker_messages.h"
#include "knuckle/forest/mixed_hash.h"

namespace knuckle {
namespace {

/// The worker that sorts a hash.
std::size_t sorter_of(std::uint64_t hash, int workers) {
  return static_cast<std::size_t>(((hash >> 32U) * static_cast<std::uint64_t>(workers)) >> 32U);
}

/// A key, and where it came from: the n-th that a worker has sent.
struct SentKey {
  SampleKey key;
  std::size_t worker = 0;
  std::size_t ordinal = 0;

  bool operator<(const SentKey& other) const {
    return std::tuple(key.hash, key.number, worker, ordinal) <
           std::tuple(other.key.hash, other.key.number, other.worker, other.ordinal);
  }
};

/// What a worker tells another of a node.
struct SummedPart {
  std::int64_t total = 0;
  std::int64_t before = 0;
  std::int64_t holder = NodeShare::kSeveral;
};

/// Of samples that any training has: numbers of them can be added up.
constexpr std::int64_t kMostThings = std::int64_t{1} << 48;
constexpr std::int64_t kNumberBytes = sizeof(std::uint32_t);
constexpr std::int64_t kSumBytes = sizeof(SummedPart);

SummedPart summed(std::span<const std::uint32_t> parts) {
  SummedPart sum;
  int holders = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    sum.total += parts[k];
    if (parts[k] == 0) continue;
    ++holders;
    sum.holder = static_cast<std::int64_t>(k);
  }
  if (holders != 1) sum.holder = NodeShare::kSeveral;
  return sum;
}

/// What another worker tells of a node of which this one has `own` samples.
void check(const SummedPart& sum, std::int64_t own, int workers) {
  const bool is_sound = sum.before >= 0 && sum.before <= kMostThings && sum.total <= kMostThings &&
                        sum.before + own <= sum.total && sum.holder >= NodeShare::kSeveral &&
                        sum.holder < workers;
  if (!is_sound) {
    fail("a worker's message: a node of {} samples, {} of them before, with worker {} of {}", sum.total,
         sum.before, sum.holder, workers);
  }
}

}  // namespace

CanonicalPlaces canonical_places(WorkerGroup& workers, std::span<const SampleKey> own) {
  const auto count = static_cast<std::size_t>(workers.size());
  OwnMessages keys(count);
  for (const SampleKey& key : own) append_value(keys[sorter_of(key.hash, workers.size())], key);
  const ReceivedMessages received = exchanged(workers, std::move(keys));
  std::vector<SentKey> sorted;
  for (std::size_t worker = 0; worker < count; ++worker) {
    MessageReader reader(received.parts[worker]);
    for (std::size_t i = 0; !reader.is_at_end(); ++i)
      sorted.push_back({reader.value<SampleKey>(), worker, i});
  }
  std::ranges::sort(sorted, std::less<>());
  const SumOfWorkers sorted_before = sum_of_workers(workers, std::ssize(sorted));

  // Each sender gets the places back in the order in which it has sent the keys.
  std::vector<std::vector<std::int64_t>> answers(count);
  for (std::size_t worker = 0; worker < count; ++worker) {
    answers[worker].resize(received.parts[worker].size() / sizeof(SampleKey));
  }
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    answers[sorted[i].worker][sorted[i].ordinal] = sorted_before.before + static_cast<std::int64_t>(i);
  }
  OwnMessages replies(count);
  for (std::size_t worker = 0; worker < count; ++worker) {
    append_values(replies[worker], std::span<const std::int64_t>(answers[worker]));
  }
  const ReceivedMessages heard = exchanged(workers, std::move(replies));
  std::vector<MessageReader> readers(heard.parts.begin(), heard.parts.end());
  CanonicalPlaces result;
  result.total = sorted_before.total;
  for (const SampleKey& key : own) {
    const auto place = readers[sorter_of(key.hash, workers.size())].value<std::int64_t>();
    if (place < 0 || place >= result.total)
      fail("a worker's message: a sample with place {}, expected [0, {})", place, result.total);
    result.places.push_back(place);
  }
  return result;
}

std::vector<std::int64_t> equal_cuts(std::int64_t total, int workers) {
  std::vector<std::int64_t> cuts;
  for (int rank = 0; rank < workers; ++rank) cuts.push_back(part_of_worker(total, rank, workers).begin);
  cuts.push_back(total);
  return cuts;
}

int worker_of_place(std::span<const std::int64_t> cuts, std::int64_t place) {
  return static_cast<int>(std::ranges::upper_bound(cuts, place) - cuts.begin()) - 1;
}

std::vector<NodeShare> summed_shares(WorkerGroup& workers, std::span<const std::uint32_t> own) {
  if (own.empty()) return {};
  const int count = workers.size();
  const std::int64_t nodes = std::ssize(own);
  OwnMessages numbers(static_cast<std::size_t>(count));
  for (int worker = 0; worker < count; ++worker) {
    const PartOfWork part = part_of_worker(nodes, worker, count);
    append_values(numbers[static_cast<std::size_t>(worker)],
                  own.subspan(static_cast<std::size_t>(part.begin), static_cast<std::size_t>(part.size())));
  }
  const std::int64_t own_nodes = part_of_worker(nodes, workers.rank(), count).size();
  const ReceivedMessages received =
      exchanged(workers, std::move(numbers),
                std::vector<std::int64_t>(static_cast<std::size_t>(count), own_nodes * kNumberBytes));
  std::vector<MessageReader> readers(received.parts.begin(), received.parts.end());
  OwnMessages sums(static_cast<std::size_t>(count));
  std::vector<std::uint32_t> parts(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < own_nodes; ++i) {
    for (std::size_t k = 0; k < parts.size(); ++k) parts[k] = readers[k].value<std::uint32_t>();
    SummedPart sum = summed(parts);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      append_value(sums[k], sum);
      sum.before += parts[k];
    }
  }
  std::vector<std::int64_t> sizes;
  for (int worker = 0; worker < count; ++worker) {
    sizes.push_back(part_of_worker(nodes, worker, count).size() * kSumBytes);
  }
  const ReceivedMessages heard = exchanged(workers, std::move(sums), sizes);
  std::vector<NodeShare> shares;
  std::vector<MessageReader> sum_readers(heard.parts.begin(), heard.parts.end());
  for (int worker = 0; worker < count; ++worker) {
    const PartOfWork part = part_of_worker(nodes, worker, count);
    for (std::int64_t i = part.begin; i < part.end; ++i) {
      const auto sum = sum_readers[static_cast<std::size_t>(worker)].value<SummedPart>();
      check(sum, own[static_cast<std::size_t>(i)], count);
      shares.push_back({.first = 0,
                        .total = sum.total,
                        .before = sum.before,
                        .holder = static_cast<std::int32_t>(sum.holder)});
    }
  }
  return shares;
}

SumOfWorkers sum_of_workers(WorkerGroup& workers, std::int64_t own) {
  const std::vector<std::int64_t> all = values_of_all(workers, own);
  SumOfWorkers sum;
  for (int k = 0; k < workers.size(); ++k) {
    const std::int64_t part = all[static_cast<std::size_t>(k)];
    if (part < 0 || part > kMostThings) fail("worker {} of {}: has {} samples", k, workers.size(), part);
    if (k == workers.rank()) sum.before = sum.total;
    sum.total += part;
  }
  return sum;
}

std::uint64_t chained_hash(WorkerGroup& workers, std::span<const std::uint64_t> words) {
  std::uint64_t hash = 0;
  for (int turn = 0; turn < workers.size(); ++turn) {
    if (turn == workers.rank()) {
      for (const std::uint64_t word : words) hash = mixed_hash(hash, word);
    }
    hash = values_of_all(workers, hash)[static_cast<std::size_t>(turn)];
  }
  return hash;
}

}  // namespace knuckle
