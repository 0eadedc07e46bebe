// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/sample_dealer.h"

#include <array>
#include <cmath>
#include <limits>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

TEST(SampleDealer, GivesEachGroupItsNumbersInOrderAndItsShareFromTheBeginning) {
  const std::vector<double> weights{1.0, 0.25, 2.0, 0.001};
  const double sum = 3.251;
  const SampleDealer dealer(weights);
  std::array<std::int64_t, 4> dealt{};
  for (std::int64_t place = 0; place < 20000; ++place) {
    const SampleDealer::Dealt to = dealer.at(place);
    ASSERT_EQ(to.number, dealt.at(to.group)++) << place;
    for (std::size_t group = 0; group < weights.size(); ++group) {
      const double share = weights[group] / sum * static_cast<double>(place + 1);
      ASSERT_LE(std::abs(static_cast<double>(dealt.at(group)) - share), 1.0 + static_cast<double>(group))
          << place;
    }
  }
  EXPECT_DOUBLE_EQ(dealer.share(2), 2.0 / sum);
}

TEST(SampleDealer, GivesOneGroupAll) {
  const SampleDealer dealer(std::vector<double>{0.3});
  for (const std::int64_t place : {std::int64_t{0}, std::int64_t{7}, std::int64_t{1} << 40}) {
    EXPECT_EQ(dealer.at(place).group, 0u);
    EXPECT_EQ(dealer.at(place).number, place);
  }
}

TEST(SampleDealer, CountsFarPlacesExactly) {
  const SampleDealer dealer(std::vector<double>{1.0, 3.0});
  const std::int64_t far = std::int64_t{1} << 50;
  const SampleDealer::Dealt first = dealer.at(far);
  for (std::int64_t place = far; place < far + 8; ++place) {
    const SampleDealer::Dealt to = dealer.at(place);
    if (to.group == first.group) {
      EXPECT_LE(to.number - first.number, place - far);
    }
  }
  EXPECT_NEAR(static_cast<double>(dealer.at(far + 3).number) / static_cast<double>(far),
              dealer.at(far + 3).group == 0 ? 0.25 : 0.75, 1e-6);
}

TEST(SampleDealer, RefusesWeightsThatAreNone) {
  for (const double wrong : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(error_of([&] {
                  SampleDealer(std::vector<double>{1.0, wrong});
                }),
                HasSubstr("positive numbers"));
  }
  EXPECT_THAT(error_of([] { SampleDealer(std::vector<double>{}); }), HasSubstr("positive numbers"));
}

}  // namespace
}  // namespace knuckle
