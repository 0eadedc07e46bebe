// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/named_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace knuckle {
namespace {

struct Planet {
  std::string_view name;
  int moons;
};

constexpr std::array kPlanets{Planet{"venus", 0}, Planet{"mars", 2}, Planet{"jupiter", 95}};

TEST(NamedTable, FindsRowsByTheirWholeName) {
  EXPECT_THAT(names_of(kPlanets), ::testing::ElementsAre("venus", "mars", "jupiter"));
  ASSERT_NE(row_named(kPlanets, "mars"), nullptr);
  EXPECT_EQ(row_named(kPlanets, "mars")->moons, 2);
  EXPECT_EQ(row_named(kPlanets, "mar"), nullptr);
  EXPECT_EQ(row_named(kPlanets, ""), nullptr);
}

TEST(NamedTable, TellsAnUnknownNameWithTheNearestAndAll) {
  EXPECT_EQ(unknown_name("planet", "marz", names_of(kPlanets)),
            "unknown planet 'marz' (did you mean 'mars'?); known are venus, mars, jupiter");
}

}  // namespace
}  // namespace knuckle
