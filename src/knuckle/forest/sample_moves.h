// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/worker_messages.h"
#include "knuckle/forest/shared_places.h"

namespace knuckle {

/// Where a worker keeps samples that may move to others: in slots.
template <class T>
concept SampleStore = requires(T store, const T& full, std::uint32_t slot, std::vector<std::byte>& message,
                               MessageReader& reader) {
  { full.message_bytes(slot) } -> std::same_as<std::size_t>;  // what `take` appends
  store.take(slot, message);                                  // the slot is free then
  { store.put(reader) } -> std::same_as<std::uint32_t>;       // the slot that was taken for it
};

/// Bytes that a worker sends in one go: both messages are held in memory while samples move.
inline constexpr std::int64_t kMoveBytes = std::int64_t{8} << 20;
/// So often at most: a worker has no more than 8 TB.
inline constexpr std::int64_t kMostRounds = std::int64_t{1} << 20;

/// Moves samples to the workers whose parts hold their places. `slots` are those of this worker that take
/// part, `places` theirs among those of all workers (each place is held by one), `cuts` where the workers'
/// parts begin, and the end. Returns the slots of this worker's part, in the order of places. All workers
/// send the same share of what they have to send in one go, so that one that gets as many as it gives needs
/// little more room than before.
template <SampleStore Store>
std::vector<std::uint32_t> moved_to_places(WorkerGroup& workers, Store& store,
                                           std::span<const std::uint32_t> slots,
                                           std::span<const std::int64_t> places,
                                           std::span<const std::int64_t> cuts) {
  const auto count = static_cast<std::size_t>(workers.size());
  const auto rank = static_cast<std::size_t>(workers.rank());
  const std::int64_t begin = cuts[rank];
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> arranged(static_cast<std::size_t>(cuts[rank + 1] - begin), kNone);
  std::vector<std::vector<std::size_t>> leaving(count);
  std::vector<std::size_t> leaving_bytes(count);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (places[i] < cuts.front() || places[i] >= cuts.back()) {  // one may have come with a sample
      fail("a worker's message: a sample with place {}, expected [{}, {})", places[i], cuts.front(),
           cuts.back());
    }
    const auto target = static_cast<std::size_t>(worker_of_place(cuts, places[i]));
    if (target == rank) {
      arranged[static_cast<std::size_t>(places[i] - begin)] = slots[i];
    } else {
      leaving[target].push_back(i);
      leaving_bytes[target] += sizeof(std::int64_t) + store.message_bytes(slots[i]);
    }
  }
  const std::size_t bytes = std::accumulate(leaving_bytes.begin(), leaving_bytes.end(), std::size_t{0});
  const std::vector<std::int64_t> all_bytes = values_of_all(workers, static_cast<std::int64_t>(bytes));
  const std::int64_t most_bytes = std::ranges::max(all_bytes);
  if (most_bytes / kMoveBytes >= kMostRounds) fail("a worker says that it sends {} bytes", most_bytes);
  const auto rounds = static_cast<int>((most_bytes + kMoveBytes - 1) / kMoveBytes);
  for (int round = 0; round < rounds; ++round) {
    OwnMessages sent(count);
    for (std::size_t worker = 0; worker < count; ++worker) {
      const PartOfWork part = part_of_worker(std::ssize(leaving[worker]), round, rounds);
      sent[worker].reserve(leaving_bytes[worker] / static_cast<std::size_t>(rounds));  // about
      for (std::int64_t k = part.begin; k < part.end; ++k) {
        const std::size_t i = leaving[worker][static_cast<std::size_t>(k)];
        append_value(sent[worker], places[i]);
        store.take(slots[i], sent[worker]);
      }
    }
    const ReceivedMessages received = exchanged(workers, std::move(sent));
    MessageReader reader(received.bytes);
    while (!reader.is_at_end()) {
      const auto place = reader.value<std::int64_t>();
      if (place < begin || place >= cuts[rank + 1]) {
        fail("a worker's message: a sample with place {}, expected [{}, {})", place, begin, cuts[rank + 1]);
      }
      arranged[static_cast<std::size_t>(place - begin)] = store.put(reader);
    }
  }
  if (std::ranges::find(arranged, kNone) != arranged.end())
    fail("workers have not sent the samples of all places of worker {} of {}", rank, count);
  return arranged;
}

}  // namespace knuckle
