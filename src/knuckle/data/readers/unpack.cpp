// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/unpack.h"

#include <algorithm>

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

using PackedBytes = std::span<const std::uint8_t>;

/// What a call of a library did.
struct UnpackStep {
  std::size_t taken = 0;  ///< bytes of the input
  std::size_t given = 0;  ///< bytes of the output
  bool is_end = false;
  bool is_damaged = false;
};

class Bz2Unpacker {
 public:
  Bz2Unpacker() {
    if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) throw std::bad_alloc();
  }
  Bz2Unpacker(const Bz2Unpacker&) = delete;
  Bz2Unpacker& operator=(const Bz2Unpacker&) = delete;
  ~Bz2Unpacker() { BZ2_bzDecompressEnd(&stream_); }

  UnpackStep step(PackedBytes from, std::span<std::uint8_t> to) {
    constexpr std::size_t kMost = std::size_t{1} << 30;  // the library counts in 32 bits
    const std::size_t in = std::min(from.size(), kMost);
    const std::size_t out = std::min(to.size(), kMost);
    // The library does not write to its input, but does not say so.
    stream_.next_in = const_cast<char*>(reinterpret_cast<const char*>(from.data()));
    stream_.avail_in = static_cast<unsigned>(in);
    stream_.next_out = reinterpret_cast<char*>(to.data());
    stream_.avail_out = static_cast<unsigned>(out);
    const int status = BZ2_bzDecompress(&stream_);
    return {in - stream_.avail_in, out - stream_.avail_out, status == BZ_STREAM_END,
            status != BZ_OK && status != BZ_STREAM_END};
  }

 private:
  bz_stream stream_{};
};

class Lz4Unpacker {
 public:
  Lz4Unpacker() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context_, LZ4F_VERSION)) != 0) throw std::bad_alloc();
  }
  Lz4Unpacker(const Lz4Unpacker&) = delete;
  Lz4Unpacker& operator=(const Lz4Unpacker&) = delete;
  ~Lz4Unpacker() { LZ4F_freeDecompressionContext(context_); }

  UnpackStep step(PackedBytes from, std::span<std::uint8_t> to) {
    std::size_t taken = from.size();
    std::size_t given = to.size();
    const std::size_t status = LZ4F_decompress(context_, to.data(), &given, from.data(), &taken, nullptr);
    const bool is_damaged = LZ4F_isError(status) != 0;
    if (is_damaged) return {0, 0, false, true};
    return {taken, given, status == 0, false};
  }

 private:
  LZ4F_dctx* context_ = nullptr;
};

class ZstdUnpacker {
 public:
  ZstdUnpacker() : stream_(ZSTD_createDStream()) {
    if (stream_ == nullptr) throw std::bad_alloc();
  }
  ZstdUnpacker(const ZstdUnpacker&) = delete;
  ZstdUnpacker& operator=(const ZstdUnpacker&) = delete;
  ~ZstdUnpacker() { ZSTD_freeDStream(stream_); }

  /// The library refuses frames that want more than 128 MiB to look back upon.
  UnpackStep step(PackedBytes from, std::span<std::uint8_t> to) {
    ZSTD_inBuffer in{from.data(), from.size(), 0};
    ZSTD_outBuffer out{to.data(), to.size(), 0};
    const std::size_t status = ZSTD_decompressStream(stream_, &out, &in);
    if (ZSTD_isError(status) != 0) return {0, 0, false, true};
    return {in.pos, out.pos, status == 0, false};
  }

 private:
  ZSTD_DStream* stream_;
};

template <class Unpacker>
std::vector<std::uint8_t> unpack_with(PackedBytes packed, std::uint64_t count, std::string_view where) {
  constexpr std::size_t kFirstBytes = std::size_t{1} << 16;
  Unpacker unpacker;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::min<std::uint64_t>(count, kFirstBytes)));
  std::size_t length = 0;
  std::uint8_t beyond = 0;  // a byte more than expected has to have a place, to be seen
  while (true) {
    const bool is_full = length == count;
    if (!is_full && length == bytes.size()) {
      bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(count, 2 * length)));
    }
    const std::span<std::uint8_t> free = is_full ? std::span(&beyond, 1) : std::span(bytes).subspan(length);
    const UnpackStep step = unpacker.step(packed, free);
    packed = packed.subspan(step.taken);
    if (step.is_damaged) fail("{}: its packed bytes are damaged", where);
    if (is_full && step.given > 0) fail("{}: unpacks to more than the {} bytes it says", where, count);
    length += step.given;
    if (step.is_end) break;
    if (step.taken == 0 && step.given == 0) fail("{}: its packed bytes are cut short", where);
  }
  if (length != count) fail("{}: unpacks to {} bytes, expected {}", where, length, count);
  if (!packed.empty()) fail("{}: has {} bytes after its packed ones", where, packed.size());
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> unpack(PackedBytes packed, Packing packing, std::uint64_t count,
                                 std::string_view where) {
  if (packing == Packing::bz2) return unpack_with<Bz2Unpacker>(packed, count, where);
  if (packing == Packing::lz4) return unpack_with<Lz4Unpacker>(packed, count, where);
  if (packing == Packing::zstd) return unpack_with<ZstdUnpacker>(packed, count, where);
  if (packed.size() != count) fail("{}: has {} bytes, expected {}", where, packed.size(), count);
  return {packed.begin(), packed.end()};
}

}  // namespace knuckle
