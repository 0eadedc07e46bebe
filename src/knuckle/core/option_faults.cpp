// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/option_faults.h"

#include <algorithm>

#include "knuckle/core/error.h"
#include "knuckle/core/suggestion.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

std::string quoted_list(std::span<const std::string_view> known) {
  std::vector<std::string> quoted;
  for (const std::string_view name : known) quoted.push_back(fmt::format("\"{}\"", name));
  return joined(quoted);
}

bool is_known(std::string_view value, std::span<const std::string_view> known) {
  return std::ranges::find(known, value) != known.end();
}

}  // namespace

OptionFault range_fault(double value, const Interval& range) {
  if (range.contains(value)) return std::nullopt;
  return fmt::format("is {}, expected a value in {}", value, range.text());
}

OptionFault choice_fault(std::string_view value, std::span<const std::string_view> known) {
  if (is_known(value, known)) return std::nullopt;
  return fmt::format("is \"{}\"{}, expected one of {}", value, suggestion(value, known), quoted_list(known));
}

OptionFault list_fault(const std::vector<double>& values, const Interval& range, std::size_t shortest,
                       std::size_t longest) {
  if (values.size() < shortest || values.size() > longest) {
    return fmt::format(
        "holds {} numbers, expected {}", values.size(),
        shortest == longest ? fmt::format("{}", shortest) : fmt::format("{} to {}", shortest, longest));
  }
  for (const double value : values) {
    if (OptionFault fault = range_fault(value, range)) return "one " + *fault;
  }
  return std::nullopt;
}

OptionFault texts_fault(const std::vector<std::string>& values, std::span<const std::string_view> known) {
  if (known.empty()) return std::nullopt;
  for (const std::string& value : values) {
    if (OptionFault fault = choice_fault(value, known)) return "one " + *fault;
  }
  return std::nullopt;
}

}  // namespace knuckle
