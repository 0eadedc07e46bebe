// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "knuckle/storage/hdf5/hdf5_bytes.h"

namespace knuckle {

/// Where a chunk of an array lies.
struct Hdf5Chunk {
  std::uint64_t address = 0;
  std::uint32_t bytes = 0;     ///< as stored
  std::uint32_t left_out = 0;  ///< a bit for each filter that was not applied
};

/// The chunks of an array that were written, as its B-tree lists them: of 400,000 chunks 6,000 leaves are
/// known from the beginning, and each is read when one of its chunks is asked for. Safe to use from many
/// threads.
class Hdf5Chunks {
 public:
  /// Without a tree no chunk was written. `shape` and `chunk` have the same number of sides, those of `chunk`
  /// more than 0. `file` outlives this. Throws where the tree is damaged above its leaves.
  Hdf5Chunks(const Hdf5Bytes& file, const std::optional<std::uint64_t>& tree,
             const std::vector<std::uint64_t>& shape, const std::vector<std::uint64_t>& chunk);

  /// The chunk whose first element is at `place`; nothing where it was never written. Throws where the leaf
  /// that should list it is damaged.
  std::optional<Hdf5Chunk> find(const std::vector<std::uint64_t>& place) const;
  /// Of all that lie in the array together. Reads all leaves.
  std::uint64_t stored_bytes() const;

 private:
  using Place = std::vector<std::uint64_t>;
  struct Leaf {
    std::optional<Place> first;  ///< no chunk comes before; nothing: the only leaf
    std::uint64_t address = 0;
  };
  struct Entry {
    Place place;
    Hdf5Chunk chunk;
  };
  /// A leaf that was read.
  struct Listing {
    std::size_t leaf = 0;
    std::vector<Entry> entries;
  };

  std::size_t key_bytes() const;
  Place read_place(Hdf5Cursor& key) const;
  std::shared_ptr<const Listing> listing(std::size_t leaf) const;
  std::vector<Entry> entries_of(std::size_t leaf) const;
  bool is_in_leaf(const Place& place, std::size_t leaf) const;
  bool is_in_array(const Place& place) const;

  const Hdf5Bytes* file_;
  std::vector<std::uint64_t> shape_;
  std::vector<std::uint64_t> chunk_;
  std::vector<Leaf> leaves_;  ///< in the order of their places
  mutable std::mutex last_lock_;
  mutable std::shared_ptr<const Listing> last_;  ///< frames are read one after another
};

}  // namespace knuckle
