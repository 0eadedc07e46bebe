// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/pgm_image.h"

#include "knuckle/core/error.h"
#include "knuckle/core/image_size.h"
#include "knuckle/core/limits.h"

namespace knuckle {
namespace {

bool is_blank(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Takes the text before the pixels apart.
class PgmHeader {
 public:
  PgmHeader(std::string_view bytes, std::string_view where) : rest_(bytes), where_(where) {}

  void expect_signature() {
    if (!rest_.starts_with("P5")) fail("{}: not a binary PGM image (P5)", where_);
    rest_.remove_prefix(2);
  }

  /// The next number, at most `highest`.
  int number(std::string_view name, int highest) {
    skip_blanks_and_comments();
    int value = 0;
    std::size_t digits = 0;
    for (; digits < rest_.size() && is_digit(rest_[digits]); ++digits) {
      value = 10 * value + (rest_[digits] - '0');
      if (value > highest) fail("{}: its {} is above {}", where_, name, highest);
    }
    if (value == 0) fail("{}: the PGM header has no {}", where_, name);
    rest_.remove_prefix(digits);
    return value;
  }

  /// What follows the one blank after the header.
  std::string_view pixels() {
    if (rest_.empty() || !is_blank(rest_.front())) fail("{}: its PGM header is cut short", where_);
    return rest_.substr(1);
  }

 private:
  void skip_blanks_and_comments() {
    while (!rest_.empty() && (is_blank(rest_.front()) || rest_.front() == '#')) {
      const std::size_t end = rest_.front() == '#' ? rest_.find('\n') : 0;
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    }
  }

  std::string_view rest_;
  std::string_view where_;
};

}  // namespace

Image<std::uint16_t> decode_plain16(std::string_view bytes, int width, int height, std::string_view where) {
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (bytes.size() != 2 * count) {
    fail("{}: holds {} bytes of depth, expected {} ({}x{} pixels of 2 bytes)", where, bytes.size(), 2 * count,
         width, height);
  }
  Image<std::uint16_t> image(width, height);
  for (std::size_t i = 0; i < count; ++i) {
    const auto low = static_cast<std::uint8_t>(bytes[2 * i]);
    const auto high = static_cast<std::uint8_t>(bytes[2 * i + 1]);
    image.data()[i] = static_cast<std::uint16_t>(low | high << 8);
  }
  return image;
}

Image<std::uint16_t> decode_pgm16(std::string_view bytes, std::string_view where) {
  PgmHeader header(bytes, where);
  header.expect_signature();
  const int width = header.number("width", limits::kImageSide);
  const int height = header.number("height", limits::kImageSide);
  require_image_size({width, height}, where);
  const int highest = header.number("highest value", 65535);
  if (highest < 256) fail("{}: has 8 bits per pixel, expected 16", where);
  return decode_plain16(header.pixels(), width, height, where);
}

}  // namespace knuckle
