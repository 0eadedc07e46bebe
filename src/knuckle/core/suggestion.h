// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace knuckle {

/// How many letters must be inserted, removed, exchanged for another or swapped with their neighbour to make
/// one text of the other (optimal string alignment). Small and capital letters are equal, and so are '-' and
/// '_'.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// For the end of a message about a name that is not known: " (did you mean 'x'?)" with the nearest of
/// `known`, the first where several are as near; "" where none is near enough to be meant. Near is a distance
/// of at most a third of the longer name (at least one letter) that leaves something of what was typed.
std::string suggestion(std::string_view typed, std::span<const std::string> known);
/// The same of a table of constants.
std::string suggestion(std::string_view typed, std::span<const std::string_view> known);

}  // namespace knuckle
