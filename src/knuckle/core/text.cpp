// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cwctype>

#include <fmt/ranges.h>
#include <locale.h>
#include <wctype.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\f\v";
constexpr std::size_t kLongestQuote = 40;

std::string quoted(std::string_view text) {
  return fmt::format("'{}{}'", printable(text.substr(0, kLongestQuote)),
                     text.size() > kLongestQuote ? "..." : "");
}

template <class T>
T parse(std::string_view text, std::string_view where, std::string_view what) {
  std::string_view digits = trimmed(text);
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-')
    digits.remove_prefix(1);  // from_chars takes no plus
  T value{};
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (fault == std::errc::result_out_of_range) fail("{}: {} is out of range", where, quoted(text));
  if (fault != std::errc() || end != digits.data() + digits.size()) {
    fail("{}: expected {}, found {}", where, what, quoted(text));
  }
  return value;
}

}  // namespace

std::vector<double> parse_numbers(std::string_view text, std::string_view where,
                                  std::string_view separators) {
  const std::string ends = std::string(kBlanks) + std::string(separators);
  std::vector<double> numbers;
  for (std::size_t begin = text.find_first_not_of(ends); begin != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(ends, begin), text.size());
    numbers.push_back(parse_number(text.substr(begin, end - begin), where));
    begin = text.find_first_not_of(ends, end);
  }
  return numbers;
}

double parse_number(std::string_view text, std::string_view where) {
  return parse<double>(text, where, "a number");
}

long long parse_integer(std::string_view text, std::string_view where) {
  return parse<long long>(text, where, "a whole number");
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

std::string joined(const std::vector<std::string>& parts, std::string_view separator) {
  return fmt::format("{}", fmt::join(parts, separator));
}

namespace {

/// A character of UTF-8 at the front of a text; length 0 where there is none.
struct Utf8Character {
  std::uint32_t code = 0;
  std::size_t length = 0;
};

Utf8Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i]));
  };
  const std::uint32_t first = byte(0);
  if (first < 0x80) return {first, 1};
  std::size_t length = 0;
  if (first >= 0xC2 && first <= 0xDF) length = 2;
  if (first >= 0xE0 && first <= 0xEF) length = 3;
  if (first >= 0xF0 && first <= 0xF4) length = 4;
  if (length == 0 || text.size() < length) return {};
  std::uint32_t code = first & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3FU);
  }
  constexpr std::array<std::uint32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (code < kLeast[length] || code > 0x10FFFF || is_surrogate) return {};
  return {code, length};
}

/// Characters that show nothing, change how others are shown, or whose meaning is private: Unicode's
/// categories Cf, Co and Zs but for the blank.
bool is_invisible(std::uint32_t code) {
  constexpr std::array<std::array<std::uint32_t, 2>, 24> kRanges{
      {{0xA0, 0xA0},       {0xAD, 0xAD},       {0x600, 0x605},     {0x61C, 0x61C},     {0x6DD, 0x6DD},
       {0x70F, 0x70F},     {0x890, 0x891},     {0x8E2, 0x8E2},     {0x1680, 0x1680},   {0x180E, 0x180E},
       {0x2000, 0x200F},   {0x2028, 0x202F},   {0x205F, 0x206F},   {0x3000, 0x3000},   {0xE000, 0xF8FF},
       {0xFEFF, 0xFEFF},   {0xFFF9, 0xFFFB},   {0x110BD, 0x110BD}, {0x110CD, 0x110CD}, {0x13430, 0x1345F},
       {0x1BCA0, 0x1BCA3}, {0x1D173, 0x1D17A}, {0xE0000, 0xE007F}, {0xF0000, 0x10FFFF}}};
  return std::ranges::any_of(kRanges,
                             [code](const auto& range) { return code >= range[0] && code <= range[1]; });
}

/// Whether a terminal would not show a character as it is.
bool is_control(std::uint32_t code) {
  if (code < 0x7F) return code < 0x20;
  static const locale_t unicode = ::newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);
  return is_invisible(code) || unicode == nullptr || ::iswprint_l(static_cast<wint_t>(code), unicode) == 0;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const auto [code, length] = first_character(text);
    if (length == 0 || (length == 1 && is_control(code))) {
      const auto byte = static_cast<unsigned char>(text[0]);
      shown += byte == '\n' ? "\\n" : byte == '\t' ? "\\t" : fmt::format("\\x{:02x}", byte);
    } else if (is_control(code)) {
      shown += fmt::format("\\u{{{:x}}}", code);
    } else {
      shown += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(1, length));
  }
  return shown;
}

std::string shortened(std::string_view text, std::size_t most) {
  constexpr std::string_view kGap = "...";
  if (text.size() <= most) return std::string(text);
  const auto is_within = [&](std::size_t i) {  // a character that began before
    return i < text.size() && (static_cast<unsigned char>(text[i]) & 0xC0U) == 0x80;
  };
  const std::size_t half = (most - kGap.size()) / 2;
  std::size_t front = half;
  while (front > 0 && half - front < 3 && is_within(front)) --front;
  std::size_t back = text.size() - half;
  while (back + half < text.size() + 3 && is_within(back)) ++back;
  return fmt::format("{}{}{}", text.substr(0, front), kGap, text.substr(back));
}

std::string message_line(std::string_view text) {
  constexpr std::size_t kMostBytes = 4096;
  return printable(shortened(text, kMostBytes));
}

}  // namespace knuckle
