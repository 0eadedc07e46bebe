// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/refiner_factory.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::knuckle::testing::error_of;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(RefinerFactory, MakesEveryMethodByName) {
  for (const std::string_view name : refiner_names()) {
    EXPECT_NE(create_refiner(name, OptionTable::parse("", "a.toml")), nullptr) << name;
    const std::string toml = "method = \"" + std::string(name) + "\"";
    EXPECT_NE(create_refiner(OptionTable::parse(toml, "a.toml")), nullptr) << name;
  }
}

TEST(RefinerFactory, NamesTheFaultAndTheKnown) {
  const auto error_from = [](const char* toml) {
    return error_of([&] { (void)create_refiner(OptionTable::parse(toml, "a.toml")); });
  };
  EXPECT_THAT(error_from(""), AllOf(HasSubstr("a.toml"), HasSubstr("method")));
  EXPECT_THAT(error_from("method = \"magic\""),
              AllOf(HasSubstr("a.toml"), HasSubstr("magic"), HasSubstr("depth_lookup")));
  EXPECT_THAT(error_from("method = \"depth_lookup\"\nwindow = 3"),
              AllOf(HasSubstr("a.toml"), HasSubstr("window")));
  EXPECT_THAT(error_from("method = \"depth_lookup\"\nsurface_offset_mm = 99"),
              HasSubstr("surface_offset_mm"));
  EXPECT_THAT(error_of([] { (void)create_refiner("magic", OptionTable::parse("", "a.toml")); }),
              AllOf(HasSubstr("magic"), HasSubstr("depth_lookup")));
}

}  // namespace
}  // namespace knuckle
