// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace knuckle {

/// Parts the range of a feature's values into bins of equal width, in whole numbers:
///     bin(x) = floor((x - lowest) * factor / 2^16),   factor = floor(2^16 * count / (highest - lowest + 1)),
/// or x - lowest where the range has no more values than bins. A threshold between bins is then exact: x lies
/// in bin b or above just where x >= first_value(b).
class ValueBins {
 public:
  /// `values` must not be empty; `count` in [2, 256] is the most bins to make.
  ValueBins(std::span<const std::int16_t> values, int count);

  int count() const { return count_; }  ///< bins in use; 1 where all values are equal
  /// The bin of each value of `values`, into `bins` (of the same length).
  void assign(std::span<const std::int16_t> values, std::uint8_t* bins) const;
  /// The smallest value that falls into bin `bin` or above it.
  int first_value(int bin) const;

 private:
  int lowest_ = 0;
  int count_ = 1;
  std::uint32_t factor_ = 0;  ///< 0: one bin per value
};

}  // namespace knuckle
