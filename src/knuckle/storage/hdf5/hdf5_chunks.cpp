// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_chunks.h"

#include <algorithm>
#include <limits>

#include "knuckle/storage/hdf5/hdf5_attributes.h"
#include "knuckle/storage/hdf5/hdf5_tree.h"

namespace knuckle {

Hdf5Chunks::Hdf5Chunks(const Hdf5Bytes& file, const std::optional<std::uint64_t>& tree,
                       const std::vector<std::uint64_t>& shape, const std::vector<std::uint64_t>& chunk)
    : chunk_(chunk), counts_(shape.size()) {
  for (std::size_t d = 0; d < shape.size(); ++d)
    counts_[d] = shape[d] / chunk[d] + (shape[d] % chunk[d] != 0 ? 1 : 0);
  if (value_count(counts_) == std::numeric_limits<std::uint64_t>::max())
    file.damaged("an array has too many chunks");
  const std::size_t rank = shape.size();
  std::vector<std::uint64_t> place(rank);
  const auto add = [&](Hdf5Cursor key, std::uint64_t address) {
    Hdf5Chunk found;
    found.address = address;
    found.bytes = key.u32();
    found.left_out = key.u32();
    bool is_in_array = true;
    for (std::size_t d = 0; d < rank; ++d) {
      place[d] = key.number(8);
      if (place[d] % chunk_[d] != 0) file.damaged("a chunk lies between the places of chunks");
      is_in_array = is_in_array && place[d] < shape[d];
    }
    if (!is_in_array) return;  // the array was larger once
    found.number = number_of(place);
    if (!chunks_.empty() && found.number <= chunks_.back().number) file.damaged("chunks are not in order");
    stored_bytes_ += found.bytes;
    chunks_.push_back(found);
  };
  constexpr std::size_t kPlaceBytes = 8;
  if (!tree) return;
  for_each_leaf_entry(file, *tree, Hdf5TreeKind::chunks, 8 + kPlaceBytes * (rank + 1), add);
}

std::uint64_t Hdf5Chunks::number_of(const std::vector<std::uint64_t>& place) const {
  std::uint64_t number = 0;
  for (std::size_t d = 0; d < place.size(); ++d) number = number * counts_[d] + place[d] / chunk_[d];
  return number;
}

const Hdf5Chunk* Hdf5Chunks::find(const std::vector<std::uint64_t>& place) const {
  const std::uint64_t number = number_of(place);
  const auto found = std::ranges::lower_bound(chunks_, number, {}, &Hdf5Chunk::number);
  return found != chunks_.end() && found->number == number ? &*found : nullptr;
}

}  // namespace knuckle
