// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace knuckle {

/// The numbers of samples that are in memory, rising, each once.
class FetchedNumbers {
 public:
  explicit FetchedNumbers(std::span<const std::int64_t> indices);

  std::int64_t size() const { return std::ssize(numbers_); }
  /// From 0 to size() - 1.
  std::int64_t operator[](std::int64_t place) const { return numbers_[static_cast<std::size_t>(place)]; }
  /// Where a number stands. Throws an Error where it is not among them.
  std::int64_t place_of(std::int64_t number) const;

 private:
  std::vector<std::int64_t> numbers_;
};

}  // namespace knuckle
