// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace knuckle {

/// The unpacked chunks of a recording that were asked for last: a few, of 64 MiB together or a single larger
/// one. Safe to be used by many threads; different chunks are unpacked at the same time.
class ChunkCache {
 public:
  using Bytes = std::vector<std::uint8_t>;

  /// Chunk `number` of `bytes` bytes, which `unpack` gives where it is not kept. What `unpack` throws is
  /// thrown on, and the next who asks tries again.
  std::shared_ptr<const Bytes> get(std::uint32_t number, std::uint64_t bytes,
                                   const std::function<Bytes()>& unpack) const;

 private:
  struct Unpacked {
    std::mutex is_unpacking;
    Bytes bytes;
  };
  struct Kept {
    std::uint32_t number = 0;
    std::uint64_t bytes = 0;
    std::shared_ptr<Unpacked> unpacked;
  };

  std::shared_ptr<Unpacked> kept_chunk(std::uint32_t number, std::uint64_t bytes) const;

  mutable std::mutex is_looking_;
  mutable std::vector<Kept> kept_;  ///< the last that was asked for comes last
};

}  // namespace knuckle
