// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/training_source.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;

std::vector<TrainingSource> read(const std::string& toml, const TrainingSource& defaults = {}) {
  const OptionTable document = OptionTable::parse(toml, "train.toml", "/sets");
  std::vector<TrainingSource> sources = training_sources_in(document, defaults);
  document.finish();
  return sources;
}

TEST(TrainingSource, OneIsAText) {
  const auto sources = read("source = 'folder:mine?first=2'\nholdout = 0.25\n", {.side = "left", .most = 9});
  ASSERT_EQ(sources.size(), 1u);
  EXPECT_EQ(sources[0].source, "folder:/sets/mine?first=2");
  EXPECT_EQ(sources[0].holdout, 0.25);
  EXPECT_EQ(sources[0].side, "left");
  EXPECT_EQ(sources[0].most, 9);
  EXPECT_EQ(sources[0].weight, 1.0);
}

TEST(TrainingSource, SeveralAreTables) {
  const auto sources = read(
      "[[source]]\nsource = 'folder:mine'\nweight = 2\nholdout = 0.1\nside = 'left'\n"
      "[[source]]\nsource = 'h5:/other.h5'\nmost = 40\n",
      {.most = 9, .most_things = 3});
  ASSERT_EQ(sources.size(), 2u);
  EXPECT_EQ(sources[0].source, "folder:/sets/mine");
  EXPECT_EQ(sources[0].weight, 2.0);
  EXPECT_EQ(sources[0].holdout, 0.1);
  EXPECT_EQ(sources[0].side, "left");
  EXPECT_EQ(sources[0].most, 9);
  EXPECT_EQ(sources[1].source, "h5:/other.h5");
  EXPECT_EQ(sources[1].weight, 1.0);
  EXPECT_EQ(sources[1].side, "right");
  EXPECT_EQ(sources[1].most, 40);
  EXPECT_EQ(sources[1].most_things, 3);
}

TEST(TrainingSource, WhatIsWrongIsSaidWithItsLine) {
  const auto fault = [](const std::string& toml) { return error_of([&] { read(toml); }); };
  EXPECT_THAT(fault(""), HasSubstr("source: is missing"));
  EXPECT_THAT(fault("source = ['folder:a', 'folder:b']\n"),
              AllOf(HasSubstr("train.toml:1: source"), HasSubstr("[[source]]")));
  EXPECT_THAT(fault("source = 3\n"), HasSubstr("train.toml:1: source"));
  EXPECT_THAT(fault("[[source]]\nweight = 1.0\n"), HasSubstr("source[1].source: is missing"));
  EXPECT_THAT(fault("[[source]]\nsource = 'folder:a'\nweight = 0\n"), HasSubstr("source[1].weight"));
  EXPECT_THAT(fault("[[source]]\nsource = 'folder:a'\nweight = nan\n"), HasSubstr("source[1].weight"));
  EXPECT_THAT(fault("[[source]]\nsource = 'folder:a'\nwieght = 1\n"), HasSubstr("wieght: unknown key"));
  EXPECT_THAT(fault("[[source]]\nsource = 'folder:a'\nside = 'both'\n"), HasSubstr("source[1].side"));
  EXPECT_THAT(fault("source = 'folder:a'\nholdout = 1.0\n"), HasSubstr("train.toml:2: holdout"));
  EXPECT_THAT(fault("holdout = 0.1\n[[source]]\nsource = 'folder:a'\n"), HasSubstr("holdout: unknown key"));
}

TEST(TrainingSource, IsWrittenBackAsItIsRead) {
  const std::string toml =
      "[[source]]\nsource = '/a'\nweight = 2\n[[source]]\nsource = '/b'\nside = 'left'\n";
  const OptionTable document = OptionTable::parse(toml, "train.toml");
  const auto sources = training_sources_in(document, {});
  const auto again = training_sources_in(OptionTable::parse(document.resolved_toml(), "again.toml"), {});
  ASSERT_EQ(again.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(options_as_toml(again[i]), options_as_toml(sources[i]));
}

}  // namespace
}  // namespace knuckle
