// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/deflate.h"

#include <cassert>
#include <memory>
#include <new>

#include <libdeflate.h>

#include "knuckle/storage/run_length_deflate.h"

namespace knuckle {
namespace {

/// Of libdeflate's levels 1 to 12 the fastest on depth images, and within 5 % of the size of level 6
/// (docs/performance.md).
constexpr int kLevel = 3;

/// From this share of repeated bytes on nothing but runs is looked for: a rendered hand before nothing has
/// 0.92 and more, a recorded room mostly less than 0.89 (docs/performance.md).
constexpr double kMostlyRuns = 0.9;

using Compressor = std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)>;

/// A compressor is a megabyte of tables: one per thread.
libdeflate_compressor* compressor() {
  thread_local const Compressor own(libdeflate_alloc_compressor(kLevel), libdeflate_free_compressor);
  if (own == nullptr) throw std::bad_alloc();
  return own.get();
}

using Decompressor = std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>;

libdeflate_decompressor* decompressor() {
  thread_local const Decompressor own(libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (own == nullptr) throw std::bad_alloc();
  return own.get();
}

/// Bytes may be any object's: without `__restrict` the compiler must take one value at a time.
void split_bytes(const std::uint16_t* __restrict values, std::size_t count, std::uint8_t* __restrict low,
                 std::uint8_t* __restrict high) {
  for (std::size_t i = 0; i < count; ++i) {
    low[i] = static_cast<std::uint8_t>(values[i]);
    high[i] = static_cast<std::uint8_t>(values[i] >> 8);
  }
}

/// The streams of RFC 1950: a head, which says that the window is 32 KiB, deflate, the checksum.
std::vector<std::uint8_t> zlib_stream(const std::vector<std::uint8_t>& deflate, std::uint32_t checksum) {
  std::vector<std::uint8_t> stream{0x78, 0x01};
  stream.reserve(deflate.size() + 6);
  stream.insert(stream.end(), deflate.begin(), deflate.end());
  for (const int shift : {24, 16, 8, 0}) stream.push_back(static_cast<std::uint8_t>(checksum >> shift));
  return stream;
}

}  // namespace

std::vector<std::uint8_t> deflated(std::span<const std::uint8_t> bytes) {
  if (share_of_repeats(bytes) >= kMostlyRuns) return zlib_stream(run_length_deflated(bytes), adler32(bytes));
  std::vector<std::uint8_t> stream(libdeflate_zlib_compress_bound(compressor(), bytes.size()));
  const std::size_t size =
      libdeflate_zlib_compress(compressor(), bytes.data(), bytes.size(), stream.data(), stream.size());
  assert(size > 0);
  stream.resize(size);
  return stream;
}

std::vector<std::uint8_t> deflated_raw(std::span<const std::uint8_t> bytes) {
  constexpr int kSmall = 9;
  const Compressor own(libdeflate_alloc_compressor(kSmall), libdeflate_free_compressor);
  if (own == nullptr) throw std::bad_alloc();
  std::vector<std::uint8_t> stored(libdeflate_deflate_compress_bound(own.get(), bytes.size()));
  stored.resize(
      libdeflate_deflate_compress(own.get(), bytes.data(), bytes.size(), stored.data(), stored.size()));
  return stored;
}

bool inflate_raw(std::span<const std::uint8_t> stored, std::span<std::uint8_t> to) {
  // Without a place for the length it has to be the whole of `to`.
  return libdeflate_deflate_decompress(decompressor(), stored.data(), stored.size(), to.data(), to.size(),
                                       nullptr) == LIBDEFLATE_SUCCESS;
}

bool inflate(std::span<const std::uint8_t> stream, std::span<std::uint8_t> to) {
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
  constexpr std::size_t kHeadAndSum = 6;
  if (stream.size() >= kHeadAndSum) return inflate_raw(stream.subspan(2, stream.size() - kHeadAndSum), to);
#endif
  return libdeflate_zlib_decompress(decompressor(), stream.data(), stream.size(), to.data(), to.size(),
                                    nullptr) == LIBDEFLATE_SUCCESS;
}

std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  return libdeflate_crc32(before, bytes.data(), bytes.size());
}

std::vector<std::uint8_t> shuffled(std::span<const std::uint16_t> values) {
  std::vector<std::uint8_t> bytes(2 * values.size());
  split_bytes(values.data(), values.size(), bytes.data(), bytes.data() + values.size());
  return bytes;
}

std::uint32_t adler32(std::span<const std::uint8_t> bytes) {
  return libdeflate_adler32(1, bytes.data(), bytes.size());
}

}  // namespace knuckle
