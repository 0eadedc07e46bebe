// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/likelihood.h"

#include <gtest/gtest.h>

namespace knuckle {
namespace {

TEST(Likelihood, IsOfTheLogarithmOfItsOdds) {
  EXPECT_DOUBLE_EQ(logistic(0.0), 0.5);
  EXPECT_NEAR(logistic(std::log(3.0)), 0.75, 1e-12) << "three to one";
  EXPECT_NEAR(logistic(-std::log(3.0)), 0.25, 1e-12);
  EXPECT_NEAR(log_odds(0.9), 2.1972245773362196, 1e-12) << "nine to one";
  for (const double likelihood : {0.001, 0.2, 0.5, 0.73, 0.999})
    EXPECT_NEAR(logistic(log_odds(likelihood)), likelihood, 1e-12);
}

TEST(Likelihood, NobodyIsSurerThanAThousandth) {
  EXPECT_DOUBLE_EQ(log_odds(0.0), log_odds(1e-3));
  EXPECT_DOUBLE_EQ(log_odds(1.0), log_odds(0.999));
  EXPECT_NEAR(log_odds(1e-3), -6.906754778648554, 1e-12);
  EXPECT_LT(log_odds(0.0), log_odds(2e-3));
}

}  // namespace
}  // namespace knuckle
