// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace knuckle {

/// Reads little-endian numbers from the front of bytes, which outlive it, as `where` does. Throws an Error
/// that starts with `where` where the bytes end too early.
class ByteCursor {
 public:
  ByteCursor(std::span<const std::uint8_t> bytes, std::string_view where) : bytes_(bytes), where_(where) {}

  std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  std::uint64_t u64() { return number(8); }
  float f32();
  double f64();
  std::span<const std::uint8_t> take(std::uint64_t count);
  /// `count` bytes as text.
  std::string_view text(std::uint64_t count);
  void skip(std::uint64_t count) { take(count); }
  std::size_t left() const { return bytes_.size(); }
  std::string_view where() const { return where_; }

 private:
  std::uint64_t number(std::size_t bytes);

  std::span<const std::uint8_t> bytes_;
  std::string_view where_;
};

}  // namespace knuckle
