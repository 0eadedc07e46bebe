// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "knuckle/storage/hdf5/hdf5_bytes.h"

namespace knuckle {

/// Where a chunk of an array lies.
struct Hdf5Chunk {
  std::uint64_t number = 0;  ///< among all chunks of the array, row-major
  std::uint64_t address = 0;
  std::uint32_t bytes = 0;     ///< as stored
  std::uint32_t left_out = 0;  ///< a bit for each filter that was not applied
};

/// All chunks of an array that were written, read at once from its B-tree: 2 MB for 100,000.
class Hdf5Chunks {
 public:
  Hdf5Chunks() = default;
  /// Without a tree no chunk was written. `shape` and `chunk` have the same number of sides, those of `chunk`
  /// more than 0.
  Hdf5Chunks(const Hdf5Bytes& file, const std::optional<std::uint64_t>& tree,
             const std::vector<std::uint64_t>& shape, const std::vector<std::uint64_t>& chunk);

  /// The chunk whose first element is at `place`; null where it was never written.
  const Hdf5Chunk* find(const std::vector<std::uint64_t>& place) const;
  std::uint64_t stored_bytes() const { return stored_bytes_; }  ///< of all together

 private:
  std::uint64_t number_of(const std::vector<std::uint64_t>& place) const;

  std::vector<std::uint64_t> chunk_;
  std::vector<std::uint64_t> counts_;  ///< of chunks along each dimension
  std::vector<Hdf5Chunk> chunks_;      ///< by number
  std::uint64_t stored_bytes_ = 0;
};

}  // namespace knuckle
