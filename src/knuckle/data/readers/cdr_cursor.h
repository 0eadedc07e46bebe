// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace knuckle {

/// Reads a message in CDR (OMG's Common Data Representation, version 1), as ROS 2 serialises them: 4 bytes
/// that tell the order of bytes, then values, each at a multiple of its size. The bytes outlive it, as
/// `where` does. All throw an Error that starts with `where` where the bytes end too early.
class CdrCursor {
 public:
  /// Throws where it is no plain CDR: another version, or with a list of parameters.
  CdrCursor(std::span<const std::uint8_t> message, std::string_view where);

  std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  double f64();
  /// `count` bytes, as they are.
  std::span<const std::uint8_t> take(std::uint64_t count);
  /// A text after its length, without the 0 at its end.
  std::string_view text();
  /// How many bytes are left.
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  std::uint64_t number(std::size_t size);

  std::span<const std::uint8_t> bytes_;  ///< after the first 4, from which places are counted
  std::string_view where_;
  std::size_t at_ = 0;
  bool is_big_endian_ = false;
};

}  // namespace knuckle
