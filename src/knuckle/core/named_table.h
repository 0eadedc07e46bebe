// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <ranges>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "knuckle/core/suggestion.h"
#include "knuckle/core/text.h"

namespace knuckle {

// The factories of all seams have one shape: a constant array of rows, each with the member `name` and what
// makes a thing of that name.

/// The names of a table's rows, in order.
template <class Row, std::size_t size>
constexpr std::array<std::string_view, size> names_of(const std::array<Row, size>& rows) {
  std::array<std::string_view, size> names;
  std::ranges::transform(rows, names.begin(), &Row::name);
  return names;
}

template <class Row>
std::vector<std::string_view> names_of(const std::vector<Row>& rows) {
  std::vector<std::string_view> names;
  for (const Row& row : rows) names.push_back(row.name);
  return names;
}

/// The row of that name; null where there is none.
template <std::ranges::contiguous_range Rows>
constexpr auto row_named(const Rows& rows, std::string_view name) {
  const auto row = std::ranges::find(rows, name, &std::ranges::range_value_t<Rows>::name);
  return row == std::ranges::end(rows) ? nullptr : &*row;
}

/// What to say where a name is in no row: the name, the nearest known one, and all of them. `what` says what
/// it should have named: "segmentation method".
inline std::string unknown_name(std::string_view what, std::string_view name,
                                std::span<const std::string_view> known) {
  return fmt::format("unknown {} '{}'{}; known are {}", what, name, suggestion(name, known),
                     joined({known.begin(), known.end()}));
}

}  // namespace knuckle
