// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/chunk_cache.h"

#include <algorithm>

namespace knuckle {
namespace {

constexpr std::size_t kKeptChunks = 4;
constexpr std::uint64_t kKeptBytes = std::uint64_t{64} << 20;

}  // namespace

/// The place of a chunk among those that are kept; whoever comes first unpacks it.
std::shared_ptr<ChunkCache::Unpacked> ChunkCache::kept_chunk(std::uint32_t number,
                                                             std::uint64_t bytes) const {
  const std::lock_guard lock(is_looking_);
  const auto found = std::ranges::find(kept_, number, &Kept::number);
  if (found != kept_.end()) {
    std::rotate(found, found + 1, kept_.end());
    return kept_.back().unpacked;
  }
  kept_.push_back({number, bytes, std::make_shared<Unpacked>()});
  const auto kept_bytes = [&] {
    std::uint64_t sum = 0;
    for (const Kept& kept : kept_) sum += kept.bytes;
    return sum;
  };
  while (kept_.size() > 1 && (kept_.size() > kKeptChunks || kept_bytes() > kKeptBytes))
    kept_.erase(kept_.begin());
  return kept_.back().unpacked;
}

std::shared_ptr<const ChunkCache::Bytes> ChunkCache::get(std::uint32_t number, std::uint64_t bytes,
                                                         const std::function<Bytes()>& unpack) const {
  const std::shared_ptr<Unpacked> unpacked = kept_chunk(number, bytes);
  const std::lock_guard lock(unpacked->is_unpacking);
  if (unpacked->bytes.empty() && bytes > 0) unpacked->bytes = unpack();
  return {unpacked, &unpacked->bytes};
}

}  // namespace knuckle
