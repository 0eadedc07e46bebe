// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/hand_over.h"

#include <memory>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using Numbers = HandOver<int>;

std::vector<int> taken_of(Numbers& way) {
  std::vector<int> taken;
  while (const auto number = way.take()) taken.push_back(*number);
  return taken;
}

TEST(HandOver, KeepsTheOrderAndEndsWhereItIsClosed) {
  Numbers way(10, Numbers::Lose::newest);
  for (int i = 0; i < 5; ++i) way.put(i);
  way.close();
  way.put(5);
  EXPECT_THAT(taken_of(way), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_EQ(way.lost(), 0);
  EXPECT_FALSE(way.take());
}

TEST(HandOver, WithoutRoomLosesTheOldestOrTheNewest) {
  for (const auto lose : {Numbers::Lose::oldest, Numbers::Lose::newest}) {
    Numbers way(2, lose);
    for (int i = 0; i < 5; ++i) way.put(i);
    way.close();
    EXPECT_EQ(way.lost(), 3);
    if (lose == Numbers::Lose::oldest) {
      EXPECT_THAT(taken_of(way), ElementsAre(3, 4));
    } else {
      EXPECT_THAT(taken_of(way), ElementsAre(0, 1));
    }
  }
}

TEST(HandOver, WhoTakesWaitsForWhatComes) {
  HandOver<std::unique_ptr<int>> way(1000, HandOver<std::unique_ptr<int>>::Lose::newest);
  std::vector<int> taken;
  std::thread taker([&] {
    while (const auto number = way.take()) taken.push_back(**number);
  });
  for (int i = 0; i < 1000; ++i) way.put(std::make_unique<int>(i));
  way.close();
  taker.join();
  ASSERT_EQ(taken.size(), 1000U);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(taken[static_cast<std::size_t>(i)], i);
}

}  // namespace
}  // namespace knuckle
