// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/calibrated_confidence.h"

#include <cmath>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TEST(CalibratedConfidence, IsAMonotoneMapOfTheUnitInterval) {
  EXPECT_EQ(calibrated_confidence(0.0, 1.3, 1.5), 0.0);
  EXPECT_EQ(calibrated_confidence(1.0, -1.3, 1.5), 1.0);
  EXPECT_NEAR(calibrated_confidence(0.3, 0.0, 1.0), 0.3, 1e-12);
  const double logit = 1.3 + 1.5 * std::log(0.7 / 0.3);
  EXPECT_NEAR(calibrated_confidence(0.7, 1.3, 1.5), 1.0 / (1.0 + std::exp(-logit)), 1e-12);
  double before = 0.0;
  for (int i = 1; i < 100; ++i) {
    const double calibrated = calibrated_confidence(0.01 * i, 1.3, 1.5);
    EXPECT_GT(calibrated, before);
    before = calibrated;
  }
}

}  // namespace
}  // namespace knuckle
