// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace knuckle {

/// How the parts of a recording are compressed.
enum class Packing { none, bz2, lz4, zstd };

/// The `count` bytes that were packed: one bzip2 stream, or one frame of LZ4 or Zstandard. Memory is taken as
/// bytes come, so that a header that promises more than there is costs nothing. Throws an Error that starts
/// with `where` where the packed bytes are damaged or hold more or fewer.
std::vector<std::uint8_t> unpack(std::span<const std::uint8_t> packed, Packing packing, std::uint64_t count,
                                 std::string_view where);

}  // namespace knuckle
