// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/ebml.h"

#include <algorithm>
#include <bit>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::uint32_t kMostIdBytes = 4;
constexpr std::uint32_t kMostNumberBytes = 8;

/// How many bytes a number has that begins with this one: the first bit that is set says it.
std::uint32_t length_of(std::span<const std::uint8_t> bytes, std::uint32_t most, std::string_view where) {
  if (bytes.empty()) fail("{}: is cut short: expected an element", where);
  const auto length = static_cast<std::uint32_t>(std::countl_zero(bytes[0])) + 1;
  if (length > most) fail("{}: is damaged: expected an element, found byte {}", where, bytes[0]);
  if (length > bytes.size()) fail("{}: is cut short within the head of an element", where);
  return length;
}

std::uint64_t big_endian(std::span<const std::uint8_t> bytes) {
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8 | byte;
  return value;
}

}  // namespace

EbmlNumber parse_ebml_number(std::span<const std::uint8_t> bytes, std::string_view where) {
  const std::uint32_t length = length_of(bytes, kMostNumberBytes, where);
  const std::uint64_t mark = std::uint64_t{1} << (7 * length);
  return {big_endian(bytes.first(length)) & (mark - 1), length};
}

EbmlHead parse_ebml_head(std::span<const std::uint8_t> bytes, std::string_view where) {
  const std::uint32_t id_bytes = length_of(bytes, kMostIdBytes, where);
  const EbmlNumber size = parse_ebml_number(bytes.subspan(id_bytes), where);
  const std::uint64_t unknown = (std::uint64_t{1} << (7 * size.bytes)) - 1;
  return {static_cast<EbmlId>(big_endian(bytes.first(id_bytes))), size.value, size.value != unknown,
          id_bytes + size.bytes};
}

std::optional<EbmlElement> EbmlCursor::next() {
  if (bytes_.empty()) return std::nullopt;
  const EbmlHead head = parse_ebml_head(bytes_, where_);
  const std::size_t left = bytes_.size() - head.head_bytes;
  if (!head.is_size_known || head.bytes > left) {
    fail("{}: is damaged: an element has {} bytes, and {} are left", where_, head.bytes, left);
  }
  const EbmlElement element{head.id, bytes_.subspan(head.head_bytes, static_cast<std::size_t>(head.bytes))};
  bytes_ = bytes_.subspan(head.head_bytes + element.content.size());
  return element;
}

std::uint64_t ebml_u64(std::span<const std::uint8_t> content, std::string_view where) {
  if (content.size() > sizeof(std::uint64_t))
    fail("{}: is damaged: a number of {} bytes, expected at most 8", where, content.size());
  return big_endian(content);
}

std::string ebml_text(std::span<const std::uint8_t> content) {
  return {content.begin(), std::ranges::find(content, std::uint8_t{0})};
}

}  // namespace knuckle
