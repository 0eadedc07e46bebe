// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_chunks.h"

#include <algorithm>
#include <utility>

#include "knuckle/storage/hdf5/hdf5_tree.h"

namespace knuckle {

Hdf5Chunks::Hdf5Chunks(const Hdf5Bytes& file, const std::optional<std::uint64_t>& tree,
                       const std::vector<std::uint64_t>& shape, const std::vector<std::uint64_t>& chunk)
    : file_(&file), shape_(shape), chunk_(chunk) {
  if (!tree) return;
  const auto add = [&](std::optional<Hdf5Cursor> key, std::uint64_t address) {
    Leaf leaf{.first = std::nullopt, .address = address};
    if (key) {
      key->skip(8);  // size and filters of its first chunk
      leaf.first = read_place(*key);
      if (!leaves_.empty() && leaf.first <= leaves_.back().first) file_->damaged("chunks are not in order");
    }
    leaves_.push_back(std::move(leaf));
  };
  for_each_leaf(file, *tree, Hdf5TreeKind::chunks, key_bytes(), add);
}

/// File Format Specification, III.A.1: size, filters, and a place with one number more than the array has
/// sides.
std::size_t Hdf5Chunks::key_bytes() const {
  return 8 + 8 * (shape_.size() + 1);
}

Hdf5Chunks::Place Hdf5Chunks::read_place(Hdf5Cursor& key) const {
  Place place(shape_.size());
  for (std::size_t d = 0; d < place.size(); ++d) {
    place[d] = key.number(8);
    if (place[d] % chunk_[d] != 0) file_->damaged("a chunk lies between the places of chunks");
  }
  return place;
}

std::optional<Hdf5Chunk> Hdf5Chunks::find(const Place& place) const {
  const auto next = std::ranges::upper_bound(leaves_, std::optional(place), {}, &Leaf::first);
  if (next == leaves_.begin()) return std::nullopt;
  const auto found = listing(static_cast<std::size_t>(next - leaves_.begin()) - 1);
  const auto entry = std::ranges::lower_bound(found->entries, place, {}, &Entry::place);
  if (entry == found->entries.end() || entry->place != place) return std::nullopt;
  return entry->chunk;
}

std::uint64_t Hdf5Chunks::stored_bytes() const {
  std::uint64_t sum = 0;
  for (std::size_t leaf = 0; leaf < leaves_.size(); ++leaf) {
    for (const Entry& entry : entries_of(leaf)) {
      if (is_in_array(entry.place)) sum += entry.chunk.bytes;
    }
  }
  return sum;
}

std::shared_ptr<const Hdf5Chunks::Listing> Hdf5Chunks::listing(std::size_t leaf) const {
  const std::scoped_lock lock(last_lock_);
  if (!last_ || last_->leaf != leaf) last_ = std::make_shared<const Listing>(Listing{leaf, entries_of(leaf)});
  return last_;
}

std::vector<Hdf5Chunks::Entry> Hdf5Chunks::entries_of(std::size_t leaf) const {
  std::vector<Entry> entries;
  const auto add = [&](Hdf5Cursor key, std::uint64_t address) {
    Entry entry;
    entry.chunk.address = address;
    entry.chunk.bytes = key.u32();
    entry.chunk.left_out = key.u32();
    entry.place = read_place(key);
    const bool is_next = entries.empty() || entries.back().place < entry.place;
    if (!is_next || !is_in_leaf(entry.place, leaf)) file_->damaged("chunks are not in order");
    entries.push_back(std::move(entry));
  };
  for_each_entry(*file_, leaves_[leaf].address, Hdf5TreeKind::chunks, key_bytes(), add);
  return entries;
}

bool Hdf5Chunks::is_in_leaf(const Place& place, std::size_t leaf) const {
  return leaves_[leaf].first <= place && (leaf + 1 == leaves_.size() || place < leaves_[leaf + 1].first);
}

/// An array that was larger once keeps chunks beside it.
bool Hdf5Chunks::is_in_array(const Place& place) const {
  for (std::size_t d = 0; d < place.size(); ++d) {
    if (place[d] >= shape_[d]) return false;
  }
  return true;
}

}  // namespace knuckle
