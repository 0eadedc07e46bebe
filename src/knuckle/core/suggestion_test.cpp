// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/suggestion.h"

#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

/// The definition, without a table.
std::size_t distance_by_recursion(std::string_view a, std::string_view b) {
  if (a.empty() || b.empty()) return a.size() + b.size();
  const std::string_view a_start = a.substr(0, a.size() - 1);
  const std::string_view b_start = b.substr(0, b.size() - 1);
  std::size_t least = std::min({distance_by_recursion(a_start, b) + 1, distance_by_recursion(a, b_start) + 1,
                                distance_by_recursion(a_start, b_start) + (a.back() == b.back() ? 0u : 1u)});
  if (a.size() > 1 && b.size() > 1 && a.back() == b_start.back() && a_start.back() == b.back()) {
    least = std::min(least, distance_by_recursion(a.substr(0, a.size() - 2), b.substr(0, b.size() - 2)) + 1);
  }
  return least;
}

std::string random_word(Random& random, std::uint32_t longest) {
  std::string word(random.below(longest + 1), ' ');
  for (char& letter : word) letter = static_cast<char>('a' + random.below(3));
  return word;
}

TEST(EditDistance, IsThatOfItsDefinition) {
  Random random(7);
  for (int i = 0; i < 300; ++i) {
    const std::string a = random_word(random, 5);
    const std::string b = random_word(random, 5);
    ASSERT_EQ(edit_distance(a, b), distance_by_recursion(a, b)) << a << " and " << b;
    ASSERT_EQ(edit_distance(a, b), edit_distance(b, a));
  }
}

TEST(EditDistance, TakesCapitalsAndDashesForTheSame) {
  EXPECT_EQ(edit_distance("Depth-Unit", "depth_unit"), 0u);
  EXPECT_EQ(edit_distance("widht", "width"), 1u);
}

TEST(Suggestion, NamesTheNearest) {
  const std::vector<std::string> known{"width", "height", "depth_unit_mm", "fx", "fy"};
  EXPECT_EQ(suggestion("widht", known), " (did you mean 'width'?)");
  EXPECT_EQ(suggestion("hight", known), " (did you mean 'height'?)");
  EXPECT_EQ(suggestion("depth_units_mm", known), " (did you mean 'depth_unit_mm'?)");
  EXPECT_EQ(suggestion("depth_unit", known), " (did you mean 'depth_unit_mm'?)");
  EXPECT_EQ(suggestion("WIDTH", known), " (did you mean 'width'?)");
  EXPECT_EQ(suggestion("fz", known), " (did you mean 'fx'?)");
}

TEST(Suggestion, IsEmptyWhereNoneIsNear) {
  const std::vector<std::string_view> known{"width", "height", "f"};
  EXPECT_EQ(suggestion("colour", known), "");
  EXPECT_EQ(suggestion("g", known), "");
  EXPECT_EQ(suggestion("", known), "");
  EXPECT_EQ(suggestion("width", std::vector<std::string_view>{}), "");
  EXPECT_EQ(suggestion(std::string(100000, 'w'), known), "");
}

}  // namespace
}  // namespace knuckle
