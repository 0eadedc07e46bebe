// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace knuckle {

/// Writes the fields of one message in protocol buffers' wire format, in the order of the calls.
class ProtobufWriter {
 public:
  void integer(std::uint32_t number, std::int64_t value) {
    varint(number << 3);
    varint(static_cast<std::uint64_t>(value));
  }
  void real(std::uint32_t number, float value) {
    varint(number << 3 | 5);
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (int i = 0; i < 4; ++i) bytes_.push_back(static_cast<char>(bits >> (8 * i) & 0xFF));
  }
  /// A text, a message or packed numbers.
  void bytes(std::uint32_t number, std::string_view value) {
    varint(number << 3 | 2);
    varint(value.size());
    bytes_.append(value);
  }
  void message(std::uint32_t number, const ProtobufWriter& value) { bytes(number, value.bytes_); }

  /// All that was written.
  const std::string& text() const { return bytes_; }
  std::string take() { return std::move(bytes_); }

 private:
  void varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_.push_back(static_cast<char>(value | 0x80));
    bytes_.push_back(static_cast<char>(value));
  }

  std::string bytes_;
};

}  // namespace knuckle
