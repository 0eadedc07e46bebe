// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/byte_cursor.h"

#include <bit>

#include "knuckle/core/error.h"

namespace knuckle {

std::uint64_t ByteCursor::number(std::size_t bytes) {
  std::uint64_t value = 0;
  const std::span<const std::uint8_t> taken = take(bytes);
  for (std::size_t i = 0; i < bytes; ++i) value |= std::uint64_t{taken[i]} << (8 * i);
  return value;
}

float ByteCursor::f32() {
  return std::bit_cast<float>(u32());
}

double ByteCursor::f64() {
  return std::bit_cast<double>(u64());
}

std::span<const std::uint8_t> ByteCursor::take(std::uint64_t count) {
  if (count > bytes_.size()) {
    fail("{}: is cut short: {} bytes are left, expected {}", where_, bytes_.size(), count);
  }
  const std::span<const std::uint8_t> taken = bytes_.first(static_cast<std::size_t>(count));
  bytes_ = bytes_.subspan(static_cast<std::size_t>(count));
  return taken;
}

std::string_view ByteCursor::text(std::uint64_t count) {
  const std::span<const std::uint8_t> taken = take(count);
  return {reinterpret_cast<const char*>(taken.data()), taken.size()};
}

}  // namespace knuckle
