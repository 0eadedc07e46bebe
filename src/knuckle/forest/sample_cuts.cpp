// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/sample_cuts.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

namespace knuckle {
namespace {

/// Nodes that are larger may be shared by several workers.
constexpr std::int64_t kSmallNode = 1024;
/// So much smaller than a worker's part is a node at least that is not cut.
constexpr std::int64_t kPartsPerWorker = 8;
/// Costs are nearly equal where they differ by no more than this part of what a worker has to do: a node that
/// is cut costs besides what is sent of it.
constexpr std::int64_t kNearlyEqual = 16;

/// The samples that a worker holds at most: a quarter more than its share.
std::int64_t most_samples(std::int64_t total, std::int64_t workers) {
  return (5 * total + 4 * workers - 1) / (4 * workers);
}

}  // namespace

/// Where a cut may lie: [first, last].
struct SampleCuts::Range {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

/// Open nodes, and what all those before each cost; at last, what all cost.
struct SampleCuts::Costs {
  std::span<const OpenNode> open;
  std::vector<std::int64_t> before{0};

  explicit Costs(std::span<const OpenNode> nodes) : open(nodes) {
    for (const OpenNode& node : open) before.push_back(before.back() + node.cost);
  }
  std::int64_t all() const { return before.back(); }
  std::int64_t before_node(const OpenNode& node) const {
    return before[static_cast<std::size_t>(&node - open.data())];
  }
  /// Before which the nodes cost so much, if the cost of one is spread evenly over its samples.
  std::int64_t place_of(std::int64_t cost) const {
    const auto next = std::ranges::upper_bound(before, cost) - before.begin();
    const auto index = std::min<std::size_t>(static_cast<std::size_t>(next) - 1, open.size() - 1);
    const OpenNode& node = open[index];
    return node.first + (cost - before[index]) * node.total / node.cost;
  }
  /// The samples of the node that a cut there parts, 0 where it parts none.
  std::int64_t parted_by(std::int64_t place) const {
    const auto next = std::ranges::upper_bound(open, place, {}, &OpenNode::first);
    if (next == open.begin()) return 0;
    const OpenNode& node = next[-1];
    return place > node.first && place < node.first + node.total ? node.total : 0;
  }
};

SampleCuts::SampleCuts(std::span<const std::int64_t> begin, std::int64_t total)
    : places_(begin.begin(), begin.end()),
      smallest_shared_(std::min(kSmallNode, total / (kPartsPerWorker * std::ssize(begin)))) {
  places_.push_back(total);
}

void SampleCuts::follow(std::span<const OpenNode> open) {
  if (open.empty()) return;
  const Costs costs(open);
  const std::int64_t workers = std::ssize(places_) - 1;
  const std::int64_t total = places_.back();
  const std::int64_t most = most_samples(total, workers);
  std::int64_t last = 0;
  for (std::int64_t k = 1; k < workers; ++k) {
    const Range range{std::max(last, total - (workers - k) * most), std::min(total, last + most)};
    last = place_for(costs.all() * k / workers, range, costs);
    places_[static_cast<std::size_t>(k)] = last;
  }
}

/// The place in a range before which nodes cost most nearly so much.
std::int64_t SampleCuts::place_for(std::int64_t cost, const Range& range, const Costs& costs) const {
  const std::int64_t equal = std::clamp(costs.place_of(cost), range.first, range.last);
  const auto begin = std::ranges::lower_bound(costs.open, range.first, {}, &OpenNode::first);
  const auto end = std::ranges::upper_bound(costs.open, range.last, {}, &OpenNode::first);
  if (begin == end) return equal;
  const auto cost_before = [&](const OpenNode& node) { return costs.before_node(node); };
  auto nearest = std::ranges::lower_bound(begin, end, cost, {}, cost_before);
  if (nearest == end || (nearest != begin && cost - cost_before(nearest[-1]) <= cost_before(*nearest) - cost))
    --nearest;
  const std::int64_t workers = std::ssize(places_) - 1;
  const bool is_near = std::abs(cost_before(*nearest) - cost) * kNearlyEqual * workers <= costs.all();
  return is_near || costs.parted_by(equal) <= smallest_shared_ ? nearest->first : equal;
}

}  // namespace knuckle
