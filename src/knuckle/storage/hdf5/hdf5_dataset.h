// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/storage/hdf5/hdf5_chunks.h"
#include "knuckle/storage/hdf5/hdf5_number.h"
#include "knuckle/storage/hdf5/hdf5_object.h"

namespace knuckle {

/// An array of numbers in an open file. Safe to be read by many threads.
class Hdf5Dataset {
 public:
  /// The array whose header lies at that address. Throws an Error that names file and array where it is
  /// damaged, no array of numbers, or stored in another way than in one piece or in chunks that shuffle and
  /// deflate made. Where its chunks lie is read with the first values.
  Hdf5Dataset(const Hdf5Bytes& file, std::string name, std::uint64_t address);

  /// Throws where the array is larger than any that a file of this size can hold.
  const std::vector<std::uint64_t>& checked_shape() const;
  const std::vector<std::uint64_t>& shape() const { return shape_; }
  /// Number of values. Throws where they are more than a file of this size can hold: a damaged file must not
  /// decide how much memory is taken.
  std::size_t checked_count() const;
  /// As Hdf5File::read_rows.
  template <class T>
  void read_rows(std::uint64_t first, std::uint64_t count, T* values) const;

 private:
  using Bytes = std::vector<std::uint8_t>;

  [[noreturn]] void fault(std::string_view message) const;
  void read_layout(const std::vector<Hdf5Message>& messages);
  void read_chunk_shape(Hdf5Cursor& cursor);
  std::size_t count_within(std::uint64_t stored_bytes) const;
  const Hdf5Chunks& chunks() const;
  std::uint64_t stored_bytes() const;
  void check_chunks_fit() const;
  void read_filters(const std::vector<Hdf5Message>& messages);
  void read_fill_value(const std::vector<Hdf5Message>& messages);
  void read_stored(std::uint64_t first, std::uint64_t count, std::span<std::uint8_t> to) const;
  void read_piece(std::uint64_t first, std::span<std::uint8_t> to) const;
  void read_chunks(std::uint64_t first, std::uint64_t count, std::span<std::uint8_t> to) const;
  Bytes chunk(const Hdf5Chunk& stored) const;
  std::shared_ptr<const Bytes> kept_chunk(const Hdf5Chunk& stored) const;
  void fill(std::span<std::uint8_t> to) const;

  const Hdf5Bytes* file_;
  std::string name_;
  std::vector<std::uint64_t> shape_;
  Hdf5Number number_;
  Bytes fill_value_;                      ///< of what was never written; empty: 0
  std::optional<Bytes> compact_;          ///< all values, where they lie in the header
  std::optional<std::uint64_t> address_;  ///< of values in one piece
  std::uint64_t piece_bytes_ = 0;         ///< of all values, where they lie in one piece
  std::vector<std::uint64_t> chunk_;      ///< sides of a chunk; empty where the array lies in one piece
  std::size_t chunk_bytes_ = 0;
  std::optional<std::uint64_t> chunk_tree_;  ///< nothing: no chunk was written

  struct LazyChunks {
    std::mutex lock;
    std::optional<Hdf5Chunks> found;
    std::mutex kept_lock;
    std::uint64_t kept_address = 0;
    std::shared_ptr<const Bytes> kept;  ///< the last one that was unpacked, where chunks hold many rows
  };
  std::unique_ptr<LazyChunks> chunks_;  ///< null where the array lies in one piece
  int shuffle_ = -1;                    ///< the filter's place among all; -1: there is none
  int deflate_ = -1;
};

}  // namespace knuckle
