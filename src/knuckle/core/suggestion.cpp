// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/suggestion.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace knuckle {
namespace {

constexpr std::size_t kLongestName = 64;  // what is longer is not a slip of a finger

char folded(char letter) {
  if (letter == '-') return '_';
  return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
}

/// The nearest of the names, or an empty text.
template <class Name>
std::string_view nearest(std::string_view typed, std::span<const Name> known) {
  if (typed.size() > kLongestName) return {};
  std::string_view best;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const std::string_view name : known) {
    if (name.size() > kLongestName) continue;
    const std::size_t allowed = std::max<std::size_t>(1, std::max(typed.size(), name.size()) / 3);
    const std::size_t distance = edit_distance(typed, name);
    const bool is_near = distance <= allowed && distance < std::min(typed.size(), name.size());
    if (is_near && distance < least) {
      best = name;
      least = distance;
    }
  }
  return best;
}

template <class Name>
std::string suggestion_among(std::string_view typed, std::span<const Name> known) {
  const std::string_view name = nearest(typed, known);
  return name.empty() ? std::string() : fmt::format(" (did you mean '{}'?)", name);
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // Row i holds the distances between the first i letters of `a` and each start of `b`.
  std::vector<std::size_t> before;  // row i - 2
  std::vector<std::size_t> above(b.size() + 1);
  std::iota(above.begin(), above.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::vector<std::size_t> row(b.size() + 1, i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool is_equal = folded(a[i - 1]) == folded(b[j - 1]);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (is_equal ? 0 : 1)});
      const bool is_swapped =
          i > 1 && j > 1 && folded(a[i - 1]) == folded(b[j - 2]) && folded(a[i - 2]) == folded(b[j - 1]);
      if (is_swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before = std::exchange(above, std::move(row));
  }
  return above.back();
}

std::string suggestion(std::string_view typed, std::span<const std::string> known) {
  return suggestion_among(typed, known);
}

std::string suggestion(std::string_view typed, std::span<const std::string_view> known) {
  return suggestion_among(typed, known);
}

}  // namespace knuckle
