// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/shared_leaves.h"

#include <algorithm>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/worker_messages.h"

namespace knuckle {
namespace {

void add_targets(const TrainingSamples& samples, std::span<const std::uint32_t> reached,
                 std::span<double> sum) {
  for (const std::uint32_t sample : reached) {
    const std::span<const float> values = samples.targets(sample);
    for (std::size_t d = 0; d < sum.size(); ++d) sum[d] += values[d];
  }
}

void set_mean(std::span<const double> sum, std::int64_t count, std::span<float> mean) {
  for (std::size_t d = 0; d < sum.size(); ++d) {
    mean[d] = static_cast<float>(sum[d] / static_cast<double>(count));
  }
}

/// Sums of the targets of those leaves that several workers share: workers add theirs in turn. One row per
/// leaf, the same for all workers.
std::vector<double> summed_in_turn(WorkerGroup& workers, const TrainingSamples& samples,
                                   std::span<const SharedLeaf> leaves) {
  const auto targets = static_cast<std::size_t>(samples.target_count());
  std::vector<double> sums;
  for (const SharedLeaf& leaf : leaves) {
    if (leaf.share.holder == NodeShare::kSeveral) sums.resize(sums.size() + targets);
  }
  if (sums.empty()) return sums;
  for (int turn = 0; turn < workers.size(); ++turn) {
    OwnMessages sent(static_cast<std::size_t>(workers.size()));
    if (turn == workers.rank()) {
      std::span<double> left(sums);
      for (const SharedLeaf& leaf : leaves) {
        if (leaf.share.holder != NodeShare::kSeveral) continue;
        add_targets(samples, leaf.samples, left.first(targets));
        left = left.subspan(targets);
      }
      for (std::vector<std::byte>& message : sent) append_values(message, std::span<const double>(sums));
    }
    const ReceivedMessages received = exchanged(workers, std::move(sent));
    MessageReader(received.parts[static_cast<std::size_t>(turn)]).read(std::span(sums));
  }
  return sums;
}

/// Means of the leaves that this worker has alone, as a message.
std::vector<std::byte> own_means(const TrainingSamples& samples, std::span<const SharedLeaf> leaves,
                                 int rank) {
  const auto targets = static_cast<std::size_t>(samples.target_count());
  std::vector<const SharedLeaf*> own;
  for (const SharedLeaf& leaf : leaves) {
    if (leaf.share.holder == rank) own.push_back(&leaf);
  }
  std::vector<float> means(own.size() * targets);
  parallel_for(std::ssize(own), [&](std::int64_t i) {
    const SharedLeaf& leaf = *own[static_cast<std::size_t>(i)];
    std::vector<double> sum(targets, 0.0);
    add_targets(samples, leaf.samples, sum);
    set_mean(sum, leaf.share.total, std::span(means).subspan(static_cast<std::size_t>(i) * targets, targets));
  });
  std::vector<std::byte> message;
  append_values(message, std::span<const float>(means));
  return message;
}

}  // namespace

std::vector<float> shared_leaf_means(WorkerGroup& workers, const TrainingSamples& samples,
                                     std::span<const SharedLeaf> leaves) {
  const auto targets = static_cast<std::size_t>(samples.target_count());
  const std::vector<double> sums = summed_in_turn(workers, samples, leaves);
  OwnMessages sent(static_cast<std::size_t>(workers.size()));
  sent[0] = own_means(samples, leaves, workers.rank());
  const ReceivedMessages received = exchanged(workers, std::move(sent));
  if (workers.rank() != 0) return {};
  std::vector<MessageReader> readers(received.parts.begin(), received.parts.end());
  std::span<const double> left(sums);
  std::vector<float> means(leaves.size() * targets);
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const std::span<float> mean = std::span(means).subspan(i * targets, targets);
    const NodeShare& share = leaves[i].share;
    if (share.holder == NodeShare::kSeveral) {
      set_mean(left.first(targets), share.total, mean);
      left = left.subspan(targets);
    } else {
      readers[static_cast<std::size_t>(share.holder)].read(mean);
    }
  }
  return means;
}

std::vector<ClassCount> shared_class_counts(WorkerGroup& workers, std::span<const std::uint8_t> labels,
                                            std::span<const SharedLeaf> leaves) {
  OwnMessages sent(static_cast<std::size_t>(workers.size()));
  for (const SharedLeaf& leaf : leaves) {
    const auto ones =
        std::ranges::count_if(leaf.samples, [&](std::uint32_t sample) { return labels[sample] != 0; });
    append_value(sent[0], static_cast<std::uint32_t>(ones));
  }
  const ReceivedMessages received = exchanged(workers, std::move(sent));
  if (workers.rank() != 0) return {};
  std::vector<ClassCount> counts;
  for (const SharedLeaf& leaf : leaves) counts.push_back({.ones = 0, .all = leaf.share.total});
  for (const std::span<const std::byte> part : received.parts) {
    MessageReader reader(part);
    for (ClassCount& count : counts) count.ones += reader.value<std::uint32_t>();
  }
  for (const ClassCount& count : counts) {
    if (count.ones > count.all)
      fail("workers' messages: {} of {} samples of a leaf are of class 1", count.ones, count.all);
  }
  return counts;
}

}  // namespace knuckle
