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

OptionFault range_fault(double value, const Interval& range);
OptionFault choice_fault(std::string_view value, std::span<const std::string_view> known);
OptionFault list_fault(const std::vector<double>& values, const Interval& range, std::size_t shortest,
                       std::size_t longest);
OptionFault texts_fault(const std::vector<std::string>& values, std::span<const std::string_view> known);

}  // namespace knuckle
