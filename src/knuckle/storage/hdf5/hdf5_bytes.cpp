// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_bytes.h"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::string_view kHdf5Signature = "\x89HDF\r\n\x1a\n";

bool is_size_of_numbers(std::size_t bytes) {
  return bytes == 2 || bytes == 4 || bytes == 8;
}

}  // namespace

Hdf5Bytes::Hdf5Bytes(std::filesystem::path path) : path_(std::move(path)), file_(path_) {
  read_superblock();
}

void Hdf5Bytes::damaged(std::string_view why) const {
  fail("{}: the HDF5 file is damaged: {}", path_.string(), why);
}

void Hdf5Bytes::too_new(std::string_view what) const {
  fail(
      "{}: has {}, which is not read; write it again in the library's earliest format (h5py: "
      "libver='earliest')",
      path_.string(), what);
}

void Hdf5Bytes::read_superblock() {
  constexpr std::uint64_t kFirstPlaceAfterZero = 512;
  constexpr std::uint64_t kMostBytes = 128;
  for (std::uint64_t place = 0;; place = std::max(kFirstPlaceAfterZero, 2 * place)) {
    if (place >= size()) fail("{}: no HDF5 file, or its beginning is damaged", path_.string());
    const std::vector<std::uint8_t> start = read_at_most(place, kHdf5Signature.size());
    if (!std::ranges::equal(start, kHdf5Signature, {}, {},
                            [](char c) { return static_cast<std::uint8_t>(c); }))
      continue;
    base_ = place;
    break;
  }
  const std::vector<std::uint8_t> bytes = read_at_most(0, kMostBytes);
  Hdf5Cursor cursor(bytes, *this);
  cursor.skip(kHdf5Signature.size());
  const int version = cursor.u8();
  if (version > 3) too_new(fmt::format("a superblock of version {}", version));
  const bool is_first_kind = version < 2;
  if (is_first_kind) cursor.skip(4);
  address_bytes_ = cursor.u8();
  length_bytes_ = cursor.u8();
  if (!is_size_of_numbers(address_bytes_) || !is_size_of_numbers(length_bytes_)) {
    damaged(fmt::format("addresses of {} bytes, lengths of {}", address_bytes_, length_bytes_));
  }
  cursor.skip(is_first_kind ? 9 : 1);  // sizes of nodes, flags
  if (version == 1) cursor.skip(4);
  cursor.address();  // the base: where the superblock was found
  cursor.address();  // free space, or extension
  const std::uint64_t end = cursor.defined_address();
  if (end > size()) {
    fail("{}: the HDF5 file is cut short: it has {} bytes, expected {}", path_.string(), size(), end);
  }
  if (is_first_kind) {
    cursor.address();  // driver
    cursor.length();   // the root's name
  }
  root_ = cursor.defined_address();
}

std::vector<std::uint8_t> Hdf5Bytes::read(std::uint64_t address, std::uint64_t count) const {
  if (address > size() - base_ || count > size() - base_ - address) {
    damaged(fmt::format("{} bytes at {} lie beyond its end", count, address));
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(count));
  read_to(address, bytes);
  return bytes;
}

std::vector<std::uint8_t> Hdf5Bytes::read_at_most(std::uint64_t address, std::uint64_t count) const {
  const std::uint64_t last = size() - base_;
  return read(address, address < last ? std::min(count, last - address) : count);
}

void Hdf5Bytes::read_to(std::uint64_t address, std::span<std::uint8_t> to) const {
  if (address > size() - base_ || to.size() > size() - base_ - address) {
    damaged(fmt::format("{} bytes at {} lie beyond its end", to.size(), address));
  }
  std::size_t done = 0;
  while (done < to.size()) {
    const ssize_t count = ::pread(file_.descriptor(), to.data() + done, to.size() - done,
                                  static_cast<off_t>(base_ + address + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("{}: cannot read: {}", path_.string(), std::generic_category().message(errno));
    if (count == 0) fail("{}: was changed while it was read: it was cut short", path_.string());
    done += static_cast<std::size_t>(count);
  }
}

std::uint64_t Hdf5Cursor::number(std::size_t bytes) {
  std::uint64_t value = 0;
  const std::span<const std::uint8_t> taken = take(bytes);
  for (std::size_t i = 0; i < bytes; ++i) value |= std::uint64_t{taken[i]} << (8 * i);
  return value;
}

std::optional<std::uint64_t> Hdf5Cursor::address() {
  const std::size_t bytes = file_->address_bytes();
  const std::uint64_t value = number(bytes);
  const std::uint64_t undefined = ~std::uint64_t{0} >> (64 - 8 * bytes);
  return value == undefined ? std::nullopt : std::optional(value);
}

std::uint64_t Hdf5Cursor::defined_address() {
  const std::optional<std::uint64_t> found = address();
  if (!found) file_->damaged("an address is missing");
  return *found;
}

std::span<const std::uint8_t> Hdf5Cursor::take(std::uint64_t count) {
  if (count > bytes_.size()) file_->damaged("a structure ends too early");
  const std::span<const std::uint8_t> taken = bytes_.first(static_cast<std::size_t>(count));
  bytes_ = bytes_.subspan(static_cast<std::size_t>(count));
  return taken;
}

void Hdf5Cursor::expect_signature(std::string_view signature) {
  const std::span<const std::uint8_t> found = take(signature.size());
  if (!std::equal(found.begin(), found.end(), signature.begin())) {
    file_->damaged(fmt::format("a structure does not begin with {}", signature));
  }
}

}  // namespace knuckle
