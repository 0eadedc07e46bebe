// SPDX-License-Identifier: Apache-2.0
// Rows of arrays that are stored in chunks: the library hands out the bytes as they lie in the file, all else
// is done here, within bounds and outside of its lock.
#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include "knuckle/storage/deflate.h"
#include "knuckle/storage/hdf5/hdf5_handle.h"

namespace knuckle {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::size_t chunk_bytes(const Hdf5Dataset& dataset) {
  std::size_t bytes = dataset.number_bytes;
  for (const std::uint64_t side : dataset.chunks) bytes *= static_cast<std::size_t>(side);
  return bytes;
}

/// The first bytes of all numbers, then the second bytes of all, ...: back to numbers.
Bytes unshuffled(const Bytes& bytes, std::size_t number_bytes) {
  const std::size_t count = bytes.size() / number_bytes;
  Bytes numbers(bytes.size());
  const std::uint8_t* __restrict from = bytes.data();
  std::uint8_t* __restrict to = numbers.data();
  if (number_bytes == 2) {  // depth: most of all that is read
    for (std::size_t i = 0; i < count; ++i) {
      to[2 * i] = from[i];
      to[2 * i + 1] = from[count + i];
    }
    return numbers;
  }
  for (std::size_t byte = 0; byte < number_bytes; ++byte) {
    for (std::size_t i = 0; i < count; ++i) to[number_bytes * i + byte] = from[count * byte + i];
  }
  return numbers;
}

/// The part of a chunk that lies in rows [first, first + count) and in the array, line by line (along the
/// last dimension), to its place in `rows`.
void copy_lines(const Hdf5Dataset& dataset, const std::vector<std::uint64_t>& place, const Bytes& chunk,
                std::uint64_t first, std::uint64_t count, std::uint8_t* rows) {
  const std::size_t rank = dataset.shape.size();
  std::vector<std::uint64_t> begin(rank, 0);
  std::vector<std::uint64_t> end(rank);
  for (std::size_t d = 0; d < rank; ++d) {
    end[d] = std::min(dataset.chunks[d], dataset.shape[d] - place[d]);
  }
  if (place[0] < first) begin[0] = first - place[0];
  end[0] = std::min(end[0], first + count - place[0]);
  std::vector<std::uint64_t> at = begin;
  while (true) {
    std::uint64_t from = 0;
    std::uint64_t to = 0;
    for (std::size_t d = 0; d < rank; ++d) {
      from = from * dataset.chunks[d] + at[d];
      to = to * dataset.shape[d] + place[d] + at[d] - (d == 0 ? first : 0);
    }
    const std::uint64_t length = end[rank - 1] - begin[rank - 1];
    std::memcpy(rows + to * dataset.number_bytes, chunk.data() + from * dataset.number_bytes,
                length * dataset.number_bytes);
    if (rank == 1) return;
    std::size_t d = rank - 2;
    while (++at[d] >= end[d]) {
      at[d] = begin[d];
      if (d == 0) return;
      --d;
    }
  }
}

bool has_type(const Hdf5Dataset& dataset, hid_t memory_type) {
  const Hdf5Lock lock;
  const Hdf5Id type(H5Dget_type(dataset.id), H5Tclose);
  return H5Tequal(type, memory_type) > 0;
}

/// Walks through all chunks (1 ms for 100,000), so it is asked only where a chunk was not found. True where
/// that cannot be told.
bool was_written(const Hdf5Dataset& dataset, const std::vector<hsize_t>& offset) {
  unsigned filters = 0;
  haddr_t address = 0;
  hsize_t size = 0;
  return H5Dget_chunk_info_by_coord(dataset.id, offset.data(), &filters, &address, &size) < 0 ||
         address != HADDR_UNDEF;
}

/// The next chunk's place, or false after the last one of these rows.
bool advance(const Hdf5Dataset& dataset, std::uint64_t first, std::uint64_t end,
             std::vector<std::uint64_t>& place) {
  for (std::size_t d = place.size(); d-- > 0;) {
    place[d] += dataset.chunks[d];
    if (place[d] < (d == 0 ? end : dataset.shape[d])) return true;
    place[d] = d == 0 ? first / dataset.chunks[0] * dataset.chunks[0] : 0;
  }
  return false;
}

}  // namespace

std::vector<std::uint8_t> Hdf5File::Handle::stored_chunk(std::string_view name, const Hdf5Dataset& dataset,
                                                         const std::vector<std::uint64_t>& place,
                                                         std::uint32_t& left_out) const {
  const Hdf5Lock lock;
  const std::vector<hsize_t> offset = as_dimensions(place);
  hsize_t size = 0;
  // Searched in the tree of chunks; the library also fails for a chunk that was never written.
  if (H5Dget_chunk_storage_size(dataset.id, offset.data(), &size) < 0) {
    if (was_written(dataset, offset)) fault(name, "a chunk cannot be found; the file is damaged");
    return {};
  }
  const std::size_t bytes = chunk_bytes(dataset);
  constexpr std::size_t kSlack = 4096;
  if (size > bytes + bytes / 8 + kSlack) fault(name, "a chunk is larger than it may be; the file is damaged");
  Bytes stored(size);
  if (size > 0 && H5Dread_chunk(dataset.id, H5P_DEFAULT, offset.data(), &left_out, stored.data()) < 0) {
    fault(name, "a chunk cannot be read; the file is damaged");
  }
  return stored;
}

std::vector<std::uint8_t> Hdf5File::Handle::chunk(std::string_view name, const Hdf5Dataset& dataset,
                                                  const std::vector<std::uint64_t>& place) const {
  std::uint32_t left_out = 0;
  Bytes chunk = stored_chunk(name, dataset, place, left_out);
  const std::size_t bytes = chunk_bytes(dataset);
  if (chunk.empty()) return Bytes(bytes, 0);
  const auto is_applied = [&](int filter) { return filter >= 0 && (left_out >> filter & 1U) == 0; };
  if (is_applied(dataset.deflate)) {
    Bytes inflated(bytes);
    if (!inflate(chunk, inflated)) fault(name, "a chunk cannot be inflated; the file is damaged");
    chunk.swap(inflated);
  }
  if (chunk.size() != bytes) fault(name, "a chunk has another size; the file is damaged");
  if (is_applied(dataset.shuffle) && dataset.number_bytes > 1) return unshuffled(chunk, dataset.number_bytes);
  return chunk;
}

void Hdf5File::Handle::read_chunked(std::string_view name, const Hdf5Dataset& dataset, std::uint64_t first,
                                    std::uint64_t count, hid_t memory_type, std::size_t memory_bytes,
                                    void* values) const {
  const std::vector<std::uint64_t>& extent = dataset.shape;
  if (count > extent[0] || first > extent[0] - count) {
    fault(name, fmt::format("rows {} to {} were asked for, it has {}", first, first + count, extent[0]));
  }
  std::size_t numbers = static_cast<std::size_t>(count);
  for (std::size_t d = 1; d < extent.size(); ++d) numbers *= static_cast<std::size_t>(extent[d]);
  if (numbers == 0) return;
  const bool is_converted = !has_type(dataset, memory_type);
  Bytes stored_numbers(is_converted ? numbers * std::max(dataset.number_bytes, memory_bytes) : 0);
  std::uint8_t* const rows = is_converted ? stored_numbers.data() : static_cast<std::uint8_t*>(values);
  std::vector<std::uint64_t> place(extent.size(), 0);
  place[0] = first / dataset.chunks[0] * dataset.chunks[0];
  do {
    copy_lines(dataset, place, chunk(name, dataset, place), first, count, rows);
  } while (advance(dataset, first, first + count, place));
  if (!is_converted) return;
  const Hdf5Lock lock;
  const Hdf5Id type(H5Dget_type(dataset.id), H5Tclose);
  if (H5Tconvert(type, memory_type, numbers, rows, nullptr, H5P_DEFAULT) < 0) {
    fault(name, "its numbers cannot be converted");
  }
  std::memcpy(values, rows, numbers * memory_bytes);
}

}  // namespace knuckle
