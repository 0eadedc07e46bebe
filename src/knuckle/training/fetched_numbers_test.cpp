// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/fetched_numbers.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

TEST(FetchedNumbers, RiseAndStandOnce) {
  const FetchedNumbers numbers(std::vector<std::int64_t>{7, 3, 7, 12, 3});
  ASSERT_EQ(numbers.size(), 3);
  EXPECT_EQ(numbers[0], 3);
  EXPECT_EQ(numbers[1], 7);
  EXPECT_EQ(numbers[2], 12);
}

TEST(FetchedNumbers, AreFoundWhereTheyStand) {
  const FetchedNumbers numbers(std::vector<std::int64_t>{7, 3, 12});
  for (std::int64_t place = 0; place < numbers.size(); ++place)
    EXPECT_EQ(numbers.place_of(numbers[place]), place);
}

TEST(FetchedNumbers, ThatAreNotThereAreNamed) {
  const FetchedNumbers numbers(std::vector<std::int64_t>{7, 3, 12});
  for (const std::int64_t missing : {2, 5, 13}) {
    EXPECT_THAT(error_of([&] { numbers.place_of(missing); }),
                HasSubstr("sample " + std::to_string(missing) + " was not fetched"));
  }
}

}  // namespace
}  // namespace knuckle
