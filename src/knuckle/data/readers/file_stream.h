// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "knuckle/data/readers/recording_file.h"

namespace knuckle {

/// A part of a file, read once from its start to its end, in pieces; inflated on the way where zlib (RFC
/// 1950) packed it. Holds 64 KiB, however long the part is. For one thread; the file outlives it.
class FileStream {
 public:
  enum class Packing { none, zlib };

  /// The `count` bytes from `at`.
  FileStream(const RecordingFile& file, std::uint64_t at, std::uint64_t count, Packing packing);
  ~FileStream();
  FileStream(FileStream&&) noexcept;
  FileStream& operator=(FileStream&&) noexcept;

  /// Fills all of `bytes`. Throws an Error that names the file and the part's place where it ends before, or
  /// is damaged.
  void read(std::span<std::uint8_t> bytes);
  void skip(std::uint64_t count);
  /// Bytes that were read or skipped.
  std::uint64_t taken() const { return taken_; }
  /// Throws unless all was read, and zlib's sum fits what was.
  void require_end();
  /// "file: at byte 13", the part's start, for messages.
  std::string place() const;

 private:
  class Inflater;

  void refill();
  /// Nothing more will come from the file.
  bool is_drained() const;
  std::size_t give(std::span<std::uint8_t> bytes);

  const RecordingFile* file_;
  std::uint64_t start_;
  std::uint64_t at_;
  std::uint64_t end_;
  std::uint64_t taken_ = 0;
  std::vector<std::uint8_t> block_;
  std::span<const std::uint8_t> left_;  ///< of the block
  std::unique_ptr<Inflater> inflater_;  ///< none where nothing is packed
};

}  // namespace knuckle
