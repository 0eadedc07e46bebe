// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/forest/feature_rows.h"
#include "knuckle/forest/split_options.h"

namespace knuckle {

/// Samples that other workers have sent, as features: sample i is the i-th entry, whose first `targets`
/// numbers are its targets.
template <class Features>
class ReceivedFeatures {
 public:
  using Block = typename Features::Block;

  ReceivedFeatures(const Features& features, std::span<const std::int16_t* const> entries,
                   std::size_t targets)
      : features_(features), entries_(entries), targets_(targets) {}
  void begin_node(Random& random, const TreeOptions& options, Block& block) const {
    features_.begin_node(random, options, block);
  }
  template <class Loop>
  void gather(std::span<const std::uint32_t> samples, Loop loop, Block& block) const {
    std::vector<const std::int16_t*> rows;
    rows.reserve(samples.size());
    for (const std::uint32_t sample : samples) rows.push_back(entries_[sample] + targets_);
    copy_rows(rows, features_.row_length(block), loop, Features::rows_of(block));
  }
  auto draw(Random& random, int index, int count, const Block& block) const {
    return features_.draw(random, index, count, block);
  }

 private:
  const Features& features_;
  std::span<const std::int16_t* const> entries_;
  std::size_t targets_;
};

}  // namespace knuckle
