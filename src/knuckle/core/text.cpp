// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/text.h"

#include <charconv>

#include <fmt/ranges.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\f\v";
constexpr std::size_t kLongestQuote = 40;

std::string quoted(std::string_view text) {
  return fmt::format("'{}{}'", text.substr(0, kLongestQuote), text.size() > kLongestQuote ? "..." : "");
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

std::string joined(const std::vector<std::string>& parts, std::string_view separator) {
  return fmt::format("{}", fmt::join(parts, separator));
}

}  // namespace knuckle
