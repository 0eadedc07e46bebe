// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/fetched_numbers.h"

#include <algorithm>

#include "knuckle/core/error.h"

namespace knuckle {

FetchedNumbers::FetchedNumbers(std::span<const std::int64_t> indices)
    : numbers_(indices.begin(), indices.end()) {
  std::ranges::sort(numbers_);
  const auto twice = std::ranges::unique(numbers_);
  numbers_.erase(twice.begin(), twice.end());
}

std::int64_t FetchedNumbers::place_of(std::int64_t number) const {
  const auto found = std::ranges::lower_bound(numbers_, number);
  if (found == numbers_.end() || *found != number) fail("training: sample {} was not fetched", number);
  return found - numbers_.begin();
}

}  // namespace knuckle
