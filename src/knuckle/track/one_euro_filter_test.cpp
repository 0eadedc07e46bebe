// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/one_euro_filter.h"

#include <cmath>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

constexpr double kStep = 1.0 / 30.0;

Eigen::VectorXd one(double value) {
  return Eigen::VectorXd::Constant(1, value);
}

TEST(LowPassShare, IsThatOfAnExponentialOverAnySteps) {
  EXPECT_NEAR(low_pass_share(1.0, 1.0 / (2.0 * 3.14159265358979)), 1.0 - std::exp(-1.0), 1e-9);
  const double once = low_pass_share(2.0, 0.06);
  const double twice = 1.0 - std::pow(1.0 - low_pass_share(2.0, 0.03), 2);
  EXPECT_NEAR(once, twice, 1e-12);
  EXPECT_LT(low_pass_share(1e-3, 1e-3), 1e-5);
  EXPECT_NEAR(low_pass_share(1000, 1), 1.0, 1e-12);
}

TEST(OneEuroFilter, KeepsTheFirstValueAndWhatRests) {
  OneEuroFilter filter({});
  Eigen::VectorXd value(3);
  value << 1, -2, 3;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(filter.smooth(value, kStep), value);
  filter.reset();
  EXPECT_EQ(filter.smooth(one(7), kStep), one(7)) << "another size after a reset";
}

TEST(OneEuroFilter, WithoutSpeedIsALowPassOfItsCutoff) {
  OneEuroFilter filter({.rest_cutoff_hz = 2.0, .cutoff_per_speed = 0.0});
  filter.smooth(one(0), kStep);
  double expected = 0.0;
  for (const double seconds : {0.03, 0.01, 0.2, 0.05}) {
    expected += low_pass_share(2.0, seconds) * (1.0 - expected);
    EXPECT_NEAR(filter.smooth(one(1), seconds)[0], expected, 1e-12);
  }
}

TEST(OneEuroFilter, LagsLessTheFasterItGoes) {
  const auto lag_of = [](double speed) {
    OneEuroFilter filter({.rest_cutoff_hz = 1.0, .cutoff_per_speed = 0.05});
    double smoothed = 0.0;
    for (int i = 0; i < 300; ++i) smoothed = filter.smooth(one(speed * i * kStep), kStep)[0];
    return (speed * 299 * kStep - smoothed) / speed;  // seconds
  };
  EXPECT_GT(lag_of(1.0), 0.1);
  EXPECT_LT(lag_of(100.0), 0.5 * lag_of(1.0));
  EXPECT_LT(lag_of(1000.0), 0.005);
}

TEST(OneEuroFilter, TakesNoiseFromWhatRests) {
  OneEuroFilter filter({.rest_cutoff_hz = 1.0, .cutoff_per_speed = 0.01});
  Random random(4);
  double squares = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double smoothed = filter.smooth(one(random.normal()), kStep)[0];
    if (i >= 100) squares += smoothed * smoothed;
  }
  EXPECT_LT(std::sqrt(squares / 1900), 0.4);
}

TEST(OneEuroFilter, RefusesWhatIsNotFiniteAndTimeThatStandsStill) {
  OneEuroFilter filter({});
  filter.smooth(one(1), kStep);
  EXPECT_THAT(error_of([&] { filter.smooth(one(std::nan("")), kStep); }), HasSubstr("not finite"));
  EXPECT_THAT(error_of([&] { filter.smooth(one(1), 0.0); }), HasSubstr("above 0"));
  EXPECT_THAT(error_of([&] { filter.smooth(one(1), std::nan("")); }), HasSubstr("above 0"));
  EXPECT_THAT(error_of([&] { filter.smooth(one(1), INFINITY); }), HasSubstr("a step of inf"));
  EXPECT_THAT(error_of([&] { filter.smooth(Eigen::VectorXd::Zero(2), kStep); }), HasSubstr("2 values"));
  EXPECT_THAT(error_of([] { OneEuroFilter({.rest_cutoff_hz = 0.0}); }), HasSubstr("rest_cutoff_hz"));
}

}  // namespace
}  // namespace knuckle
