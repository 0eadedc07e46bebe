// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_dataset.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/storage/deflate.h"
#include "knuckle/storage/hdf5/hdf5_attributes.h"

namespace knuckle {
namespace {

constexpr std::uint64_t kMostInflation = 1032;  // 258 bytes for two bits

/// The part of a chunk at `place` that lies in rows [first, first + count) and in the array, line by line
/// (along the last dimension), to its place in `rows`.
void copy_lines(const std::vector<std::uint64_t>& shape, const std::vector<std::uint64_t>& sides,
                std::size_t number_bytes, const std::vector<std::uint64_t>& place,
                std::span<const std::uint8_t> chunk, std::uint64_t first, std::uint64_t count,
                std::uint8_t* rows) {
  const std::size_t rank = shape.size();
  std::vector<std::uint64_t> begin(rank, 0);
  std::vector<std::uint64_t> end(rank);
  for (std::size_t d = 0; d < rank; ++d) end[d] = std::min(sides[d], shape[d] - place[d]);
  if (place[0] < first) begin[0] = first - place[0];
  end[0] = std::min(end[0], first + count - place[0]);
  std::vector<std::uint64_t> at = begin;
  while (true) {
    std::uint64_t from = 0;
    std::uint64_t to = 0;
    for (std::size_t d = 0; d < rank; ++d) {
      from = from * sides[d] + at[d];
      to = to * shape[d] + place[d] + at[d] - (d == 0 ? first : 0);
    }
    const std::uint64_t length = end[rank - 1] - begin[rank - 1];
    std::memcpy(rows + to * number_bytes, chunk.data() + from * number_bytes, length * number_bytes);
    if (rank == 1) return;
    std::size_t d = rank - 2;
    while (++at[d] >= end[d]) {
      at[d] = begin[d];
      if (d == 0) return;
      --d;
    }
  }
}

/// The next chunk's place, or false after the last one of the rows [first, end).
bool advance(const std::vector<std::uint64_t>& shape, const std::vector<std::uint64_t>& sides,
             std::uint64_t first, std::uint64_t end, std::vector<std::uint64_t>& place) {
  for (std::size_t d = place.size(); d-- > 0;) {
    place[d] += sides[d];
    if (place[d] < (d == 0 ? end : shape[d])) return true;
    place[d] = d == 0 ? first / sides[0] * sides[0] : 0;
  }
  return false;
}

template <class T>
std::string expected_numbers() {
  if (std::is_floating_point_v<T>) return fmt::format("at most {}", std::numeric_limits<T>::max());
  return fmt::format("whole numbers from {} to {}", std::numeric_limits<T>::min(),
                     std::numeric_limits<T>::max());
}

}  // namespace

Hdf5Dataset::Hdf5Dataset(const Hdf5Bytes& file, std::string name, std::uint64_t address)
    : file_(&file), name_(std::move(name)) {
  const std::vector<Hdf5Message> messages = read_object(file, address);
  const Hdf5Message* const shape = find_message(messages, Hdf5MessageType::dataspace);
  const Hdf5Message* const type = find_message(messages, Hdf5MessageType::datatype);
  if (shape == nullptr || type == nullptr) fault("expected an array");
  if (shape->is_shared || type->is_shared) fault("expected an array of numbers, found a named type");
  const Hdf5Type found = read_type(Hdf5Cursor(type->bytes, file));
  if (found.kind != Hdf5Type::Kind::number) {
    fault("expected an array of numbers: whole ones of 1, 2, 4 or 8 bytes, or IEEE 754 ones of 4 or 8");
  }
  number_ = found.number;
  shape_ = read_shape(Hdf5Cursor(shape->bytes, file));
  read_filters(messages);
  read_fill_value(messages);
  read_layout(messages);
}

void Hdf5Dataset::fault(std::string_view message) const {
  fail("{}: {}: {}", file_->path().string(), name_, message);
}

/// File Format Specification, IV.A.2.i.
void Hdf5Dataset::read_layout(const std::vector<Hdf5Message>& messages) {
  constexpr unsigned kCompact = 0;
  constexpr unsigned kInOnePiece = 1;
  constexpr unsigned kChunked = 2;
  constexpr unsigned kVirtual = 3;
  const Hdf5Message* const message = find_message(messages, Hdf5MessageType::layout);
  if (message == nullptr || message->is_shared) fault("expected an array");
  Hdf5Cursor cursor(message->bytes, *file_);
  const unsigned version = cursor.u8();
  const unsigned kind = cursor.u8();
  const bool is_elsewhere = find_message(messages, Hdf5MessageType::external_files) != nullptr;
  if (is_elsewhere || (version == 4 && kind == kVirtual)) {
    fault("is stored in another file; expected all in this one");
  }
  if (version < 3 || version > 4 || (version == 4 && kind == kChunked)) {
    file_->too_new(fmt::format("'{}' in a layout of version {}", name_, version));
  }
  if (kind == kCompact) {
    const std::span<const std::uint8_t> values = cursor.take(cursor.u16());
    compact_.emplace(values.begin(), values.end());
    piece_bytes_ = values.size();
  } else if (kind == kInOnePiece) {
    address_ = cursor.address();
    piece_bytes_ = cursor.length();
  } else if (kind == kChunked) {
    read_chunk_shape(cursor);
  } else {
    fault(fmt::format("has a layout of the unknown kind {}; the file is damaged", kind));
  }
}

void Hdf5Dataset::read_chunk_shape(Hdf5Cursor& cursor) {
  const std::size_t sides = cursor.u8();
  if (shape_.empty() || sides != shape_.size() + 1) fault("its chunks have another shape");
  chunk_tree_ = cursor.address();
  std::uint64_t bytes = number_.bytes;
  for (std::size_t d = 0; d < shape_.size(); ++d) {
    chunk_.push_back(cursor.u32());
    bytes = saturated_product(bytes, chunk_.back());
  }
  if (cursor.u32() != number_.bytes) fault("its chunks hold other numbers; the file is damaged");
  if (bytes == 0 || bytes > static_cast<std::uint64_t>(limits::kChunkBytes)) {
    fault(fmt::format("is stored in chunks of {} bytes, expected at most {}", bytes, limits::kChunkBytes));
  }
  chunk_bytes_ = static_cast<std::size_t>(bytes);
  check_chunks_fit();
  chunks_ = std::make_unique<LazyChunks>();
}

const Hdf5Chunks& Hdf5Dataset::chunks() const {
  const std::scoped_lock lock(chunks_->lock);
  if (!chunks_->found) chunks_->found.emplace(*file_, chunk_tree_, shape_, chunk_);
  return *chunks_->found;
}

/// Of all values.
std::uint64_t Hdf5Dataset::stored_bytes() const {
  return chunk_.empty() ? piece_bytes_ : chunks().stored_bytes();
}

/// Chunks may reach beyond the array, but what is read in vain must not be many times the array.
void Hdf5Dataset::check_chunks_fit() const {
  constexpr std::uint64_t kMostTimes = 16;
  std::uint64_t in_chunks = number_.bytes;
  for (std::size_t d = 0; d < shape_.size(); ++d) {
    const std::uint64_t count = shape_[d] / chunk_[d] + (shape_[d] % chunk_[d] == 0 ? 0 : 1);
    in_chunks = saturated_product(in_chunks, saturated_product(count, chunk_[d]));
  }
  const std::uint64_t bytes = saturated_product(value_count(shape_), number_.bytes);
  const std::uint64_t most = saturated_product(std::max<std::uint64_t>(bytes, chunk_bytes_), kMostTimes);
  if (in_chunks > most) {
    fault(fmt::format("holds {} bytes in chunks for {}, expected at most {} times as many", in_chunks, bytes,
                      kMostTimes));
  }
}

/// File Format Specification, IV.A.2.l.
void Hdf5Dataset::read_filters(const std::vector<Hdf5Message>& messages) {
  constexpr unsigned kDeflate = 1;
  constexpr unsigned kShuffle = 2;
  constexpr unsigned kFirstWithName = 256;
  const Hdf5Message* const message = find_message(messages, Hdf5MessageType::filters);
  if (message == nullptr) return;
  Hdf5Cursor cursor(message->bytes, *file_);
  const unsigned version = cursor.u8();
  if (version < 1 || version > 2 || message->is_shared) fault("its filters are of an unknown version");
  const int count = cursor.u8();
  if (version == 1) cursor.skip(6);
  for (int i = 0; i < count; ++i) {
    const unsigned filter = cursor.u16();
    const std::uint64_t name_bytes = version == 1 || filter >= kFirstWithName ? cursor.u16() : 0;
    cursor.skip(2);  // flags
    const std::uint64_t values = cursor.u16();
    cursor.skip(name_bytes);
    cursor.skip(4 * (values + (version == 1 ? values % 2 : 0)));
    int* place = nullptr;
    if (filter == kShuffle && deflate_ < 0) place = &shuffle_;
    if (filter == kDeflate) place = &deflate_;
    if (place == nullptr || *place >= 0) {
      fault(fmt::format("is stored with the filter {}; expected shuffle and deflate alone", filter));
    }
    *place = i;
  }
}

/// File Format Specification, IV.A.2.f.
void Hdf5Dataset::read_fill_value(const std::vector<Hdf5Message>& messages) {
  const Hdf5Message* const message = find_message(messages, Hdf5MessageType::fill_value);
  if (message == nullptr) return;
  Hdf5Cursor cursor(message->bytes, *file_);
  const unsigned version = cursor.u8();
  if (version < 1 || version > 3 || message->is_shared) fault("its fill value is of an unknown version");
  bool is_given = version == 1;
  if (version < 3) {
    cursor.skip(2);  // when room is taken, and filled
    is_given = cursor.u8() != 0 || version == 1;
  } else {
    is_given = (cursor.u8() & 0x20U) != 0;
  }
  if (!is_given) return;
  const std::uint32_t bytes = cursor.u32();
  if (bytes == 0 || bytes == ~std::uint32_t{0}) return;  // the usual one
  if (bytes != number_.bytes) fault("its fill value is of another type; the file is damaged");
  const std::span<const std::uint8_t> value = cursor.take(bytes);
  fill_value_.assign(value.begin(), value.end());
}

const std::vector<std::uint64_t>& Hdf5Dataset::checked_shape() const {
  (void)count_within(chunk_.empty() ? piece_bytes_ : file_->size());
  return shape_;
}

std::size_t Hdf5Dataset::checked_count() const {
  return count_within(stored_bytes());
}

/// Number of values, of which no more than `stored_bytes` are in the file.
std::size_t Hdf5Dataset::count_within(std::uint64_t stored_bytes) const {
  const std::uint64_t count = value_count(shape_);
  const std::uint64_t bytes = saturated_product(count, number_.bytes);
  // What was never written takes no room; only little may be so.
  constexpr std::uint64_t kUnwrittenBytes = std::uint64_t{64} << 20;
  const std::uint64_t expansion = !chunk_.empty() && deflate_ >= 0 ? kMostInflation : 1;
  const bool may_be_unwritten = !chunk_.empty() || (!address_ && !compact_);
  const std::uint64_t most = std::max(saturated_product(std::min(file_->size(), stored_bytes), expansion),
                                      may_be_unwritten ? kUnwrittenBytes : 0);
  if (bytes > most || bytes > saturated_product(file_->size(), kMostInflation)) {
    fault(fmt::format("declares {} values, more than a file of {} bytes can hold; it is damaged", count,
                      file_->size()));
  }
  return static_cast<std::size_t>(count);
}

template <class T>
void Hdf5Dataset::read_rows(std::uint64_t first, std::uint64_t count, T* values) const {
  if (shape_.empty() || count > shape_[0] || first > shape_[0] - count) {
    fault(fmt::format("rows {} to {} were asked for, it has {}", first, first + count,
                      shape_.empty() ? 0 : shape_[0]));
  }
  const std::size_t all = count_within(chunk_.empty() ? piece_bytes_ : file_->size());
  if (all == 0 || count == 0) return;
  const std::size_t numbers = all / static_cast<std::size_t>(shape_[0]) * static_cast<std::size_t>(count);
  if (number_ == number_of<T>()) {
    read_stored(first, count, {reinterpret_cast<std::uint8_t*>(values), numbers * sizeof(T)});
    return;
  }
  Bytes stored(numbers * number_.bytes);
  read_stored(first, count, stored);
  const std::string unfit = convert_numbers(number_, stored, std::span(values, numbers));
  if (!unfit.empty()) fault(fmt::format("holds {}, expected {}", unfit, expected_numbers<T>()));
}

void Hdf5Dataset::read_stored(std::uint64_t first, std::uint64_t count, std::span<std::uint8_t> to) const {
  if (chunk_.empty()) {
    read_piece(first, to);
  } else {
    read_chunks(first, count, to);
  }
}

void Hdf5Dataset::read_piece(std::uint64_t first, std::span<std::uint8_t> to) const {
  const std::uint64_t skipped = first * (value_count(shape_) / shape_[0]) * number_.bytes;
  if (compact_) {
    std::ranges::copy(std::span(*compact_).subspan(static_cast<std::size_t>(skipped), to.size()), to.begin());
  } else if (address_) {
    if (*address_ > file_->size()) fault("lies beyond the file's end; it is damaged");
    file_->read_to(*address_ + skipped, to);
  } else {
    fill(to);
  }
}

void Hdf5Dataset::read_chunks(std::uint64_t first, std::uint64_t count, std::span<std::uint8_t> to) const {
  fill(to);  // what was never written
  std::vector<std::uint64_t> place(shape_.size(), 0);
  place[0] = first / chunk_[0] * chunk_[0];
  do {
    const std::optional<Hdf5Chunk> written = chunks().find(place);
    if (!written) continue;
    copy_lines(shape_, chunk_, number_.bytes, place, *kept_chunk(*written), first, count, to.data());
  } while (advance(shape_, chunk_, first, first + count, place));
}

void Hdf5Dataset::fill(std::span<std::uint8_t> to) const {
  if (fill_value_.empty()) {
    std::ranges::fill(to, std::uint8_t{0});
    return;
  }
  const std::size_t one = fill_value_.size();
  for (std::size_t i = 0; i < to.size(); i += one) std::memcpy(to.data() + i, fill_value_.data(), one);
}

/// Rows are read one by one: a chunk of many is not unpacked for each.
std::shared_ptr<const Hdf5Dataset::Bytes> Hdf5Dataset::kept_chunk(const Hdf5Chunk& stored) const {
  if (chunk_[0] == 1) return std::make_shared<const Bytes>(chunk(stored));
  {
    const std::scoped_lock lock(chunks_->kept_lock);
    if (chunks_->kept && chunks_->kept_address == stored.address) return chunks_->kept;
    chunks_->kept.reset();
  }
  auto unpacked = std::make_shared<const Bytes>(chunk(stored));
  const std::scoped_lock lock(chunks_->kept_lock);
  chunks_->kept_address = stored.address;
  chunks_->kept = unpacked;
  return unpacked;
}

Hdf5Dataset::Bytes Hdf5Dataset::chunk(const Hdf5Chunk& stored) const {
  constexpr std::size_t kSlack = 4096;
  if (stored.bytes > chunk_bytes_ + chunk_bytes_ / 8 + kSlack) {
    fault("a chunk is larger than it may be; the file is damaged");
  }
  Bytes chunk = file_->read(stored.address, stored.bytes);
  const auto is_applied = [&](int filter) { return filter >= 0 && (stored.left_out >> filter & 1U) == 0; };
  if (is_applied(deflate_)) {
    if (chunk_bytes_ / kMostInflation > chunk.size()) {
      fault("a chunk is smaller than it may be; the file is damaged");
    }
    Bytes inflated(chunk_bytes_);
    if (!inflate(chunk, inflated)) fault("a chunk cannot be inflated; the file is damaged");
    chunk.swap(inflated);
  }
  if (chunk.size() != chunk_bytes_) fault("a chunk has another size; the file is damaged");
  if (is_applied(shuffle_) && number_.bytes > 1) return unshuffled(chunk, number_.bytes);
  return chunk;
}

template void Hdf5Dataset::read_rows(std::uint64_t, std::uint64_t, float*) const;
template void Hdf5Dataset::read_rows(std::uint64_t, std::uint64_t, double*) const;
template void Hdf5Dataset::read_rows(std::uint64_t, std::uint64_t, std::int8_t*) const;
template void Hdf5Dataset::read_rows(std::uint64_t, std::uint64_t, std::uint8_t*) const;
template void Hdf5Dataset::read_rows(std::uint64_t, std::uint64_t, std::int16_t*) const;
template void Hdf5Dataset::read_rows(std::uint64_t, std::uint64_t, std::uint16_t*) const;
template void Hdf5Dataset::read_rows(std::uint64_t, std::uint64_t, std::int32_t*) const;
template void Hdf5Dataset::read_rows(std::uint64_t, std::uint64_t, std::uint32_t*) const;
template void Hdf5Dataset::read_rows(std::uint64_t, std::uint64_t, std::int64_t*) const;
template void Hdf5Dataset::read_rows(std::uint64_t, std::uint64_t, std::uint64_t*) const;

}  // namespace knuckle
