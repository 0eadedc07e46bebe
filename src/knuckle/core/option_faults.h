// SPDX-License-Identifier: Apache-2.0
// What reading and checking options share; not for other modules.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/options.h"

namespace knuckle {

/// What is wrong with a value, if anything. Each kind of option has one such function, for reading and
/// checking.
using OptionFault = std::optional<std::string>;

/// The value lies outside of its range.
OptionFault range_fault(double value, const Interval& range);
/// The text is none of those that are known.
OptionFault choice_fault(std::string_view value, std::span<const std::string_view> known);
/// The list is too short or too long, or one of its numbers lies outside of the range.
OptionFault list_fault(const std::vector<double>& values, const Interval& range, std::size_t shortest,
                       std::size_t longest);
/// One of the texts is none of those that are known.
OptionFault texts_fault(const std::vector<std::string>& values, std::span<const std::string_view> known);

}  // namespace knuckle
