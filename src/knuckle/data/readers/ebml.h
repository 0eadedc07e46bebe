// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace knuckle {

/// What an element of EBML is (RFC 8794), with the marks of its length, as documents list them.
using EbmlId = std::uint32_t;

/// What stands before an element's content.
struct EbmlHead {
  EbmlId id = 0;
  std::uint64_t bytes = 0;       ///< of the content
  bool is_size_known = true;     ///< else the element ends where one begins that cannot lie in it
  std::uint32_t head_bytes = 0;  ///< of this head itself
};
inline constexpr std::uint64_t kMostEbmlHeadBytes = 4 + 8;  ///< of a head: id and size

/// The head at the front of `bytes`. Throws an Error that starts with `where` where there is none.
EbmlHead parse_ebml_head(std::span<const std::uint8_t> bytes, std::string_view where);

/// A number of variable length, and how long it is.
struct EbmlNumber {
  std::uint64_t value = 0;
  std::uint32_t bytes = 0;
};
/// The number at the front of `bytes`, as of a track in a block. Throws as above.
EbmlNumber parse_ebml_number(std::span<const std::uint8_t> bytes, std::string_view where);

/// An element in memory.
struct EbmlElement {
  EbmlId id = 0;
  std::span<const std::uint8_t> content;
};

/// Takes elements of known size off the front of bytes, which outlive it, as `where` does.
class EbmlCursor {
 public:
  EbmlCursor(std::span<const std::uint8_t> bytes, std::string_view where) : bytes_(bytes), where_(where) {}

  /// Nothing at the end. Throws an Error that starts with `where` where the bytes are no element.
  std::optional<EbmlElement> next();

 private:
  std::span<const std::uint8_t> bytes_;
  std::string_view where_;
};

/// The content as a whole number without a sign, of 0 to 8 bytes. Throws an Error that starts with `where`.
std::uint64_t ebml_u64(std::span<const std::uint8_t> content, std::string_view where);
/// The content as text, as far as to a 0.
std::string ebml_text(std::span<const std::uint8_t> content);

}  // namespace knuckle
