// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace knuckle {

/// Consecutive numbers [first, first + count).
struct IndexRange {
  std::int64_t first = 0;
  std::int64_t count = 0;

  std::int64_t end() const { return first + count; }
  bool operator==(const IndexRange&) const = default;
};

/// One of several parts of a piece of work, which are done apart, on other machines maybe.
struct Shard {
  std::int64_t number = 0;  ///< from 0 to count - 1
  std::int64_t count = 1;

  bool operator==(const Shard&) const = default;
};

/// "I/N" as a shard; "auto" is that of the task of a Slurm job array 0-(N-1), as its environment tells.
/// Throws an Error that says what was expected where the text is neither, no such task is running, or its
/// array is numbered in another way.
Shard shard_from_text(std::string_view text);

/// The part of `whole` that is a shard's: parts are contiguous, follow each other, and their lengths differ
/// by one at most. Throws an Error where there are more shards than numbers.
IndexRange part_of(const IndexRange& whole, const Shard& shard);

}  // namespace knuckle
