// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/cdr_cursor.h"

#include <bit>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::size_t kEncapsulationBytes = 4;

}  // namespace

CdrCursor::CdrCursor(std::span<const std::uint8_t> message, std::string_view where) : where_(where) {
  if (message.size() < kEncapsulationBytes) {
    fail("{}: is cut short: a message of {} bytes, expected at least {}", where_, message.size(),
         kEncapsulationBytes);
  }
  const int kind = message[0] << 8 | message[1];
  if (kind > 1) fail("{}: is serialised as CDR of kind {}, expected 0 or 1, plain CDR", where_, kind);
  is_big_endian_ = kind == 0;
  bytes_ = message.subspan(kEncapsulationBytes);
}

std::span<const std::uint8_t> CdrCursor::take(std::uint64_t count) {
  if (count > left()) fail("{}: is cut short: {} bytes are left, expected {}", where_, left(), count);
  const std::span<const std::uint8_t> taken = bytes_.subspan(at_, static_cast<std::size_t>(count));
  at_ += taken.size();
  return taken;
}

std::uint64_t CdrCursor::number(std::size_t size) {
  take((size - at_ % size) % size);
  const std::span<const std::uint8_t> taken = take(size);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | taken[is_big_endian_ ? i : size - 1 - i];
  return value;
}

double CdrCursor::f64() {
  return std::bit_cast<double>(number(8));
}

std::string_view CdrCursor::text() {
  const std::span<const std::uint8_t> taken = take(u32());
  if (taken.empty()) return "";
  if (taken.back() != 0) fail("{}: is damaged: a text does not end with 0", where_);
  return {reinterpret_cast<const char*>(taken.data()), taken.size() - 1};
}

}  // namespace knuckle
