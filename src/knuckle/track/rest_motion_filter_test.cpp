// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/rest_motion_filter.h"

#include <array>
#include <cmath>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using Eigen::VectorXd;
using testing::error_of;
using ::testing::HasSubstr;

constexpr double kSecondsPerFrame = 1.0 / 30.0;
constexpr int kValues = 20;

VectorXd noise_of(double deviation) {
  return VectorXd::Constant(kValues, deviation);
}

VectorXd random_vector(Random& random) {
  VectorXd vector(kValues);
  for (double& value : vector) value = random.normal();
  return vector;
}

TEST(RestMotionFilter, KeepsTheFirstValueAndWhatRests) {
  RestMotionFilter filter({}, noise_of(2.0));
  const VectorXd value = VectorXd::LinSpaced(kValues, -3.0, 5.0);
  EXPECT_EQ(filter.smooth(value, kSecondsPerFrame), value);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(filter.smooth(value, kSecondsPerFrame).isApprox(value, 1e-12));
  filter.reset();
  EXPECT_EQ(filter.smooth(2.0 * value, kSecondsPerFrame), 2.0 * value) << "nothing of before";
}

TEST(RestMotionFilter, AveragesWhatRests) {
  Random random(3);
  RestMotionFilter filter({}, noise_of(1.0));
  double squares = 0.0;
  for (int i = 0; i < 330; ++i) {
    const VectorXd smoothed = filter.smooth(random_vector(random), kSecondsPerFrame);
    if (i >= 30) squares += smoothed.squaredNorm() / kValues / 300;
  }
  // The mean of 30 values has 0.18; a mean of all frames so far 0.1 and less.
  EXPECT_LT(std::sqrt(squares), 0.16);
  EXPECT_GT(filter.rest(), 0.95);
}

TEST(RestMotionFilter, DoesNotLagBehindAConstantSpeed) {
  Random random(4);
  RestMotionFilter filter({}, noise_of(1.0));
  VectorXd behind = VectorXd::Zero(kValues);
  const VectorXd speed = VectorXd::LinSpaced(kValues, 20.0, 60.0);
  for (int i = 0; i < 200; ++i) {
    const VectorXd truth = i * kSecondsPerFrame * speed;
    const VectorXd smoothed = filter.smooth(truth + 0.3 * random_vector(random), kSecondsPerFrame);
    if (i >= 50) behind += (truth - smoothed) / 150;
  }
  EXPECT_LT(filter.rest(), 0.01);
  EXPECT_LT(behind.cwiseQuotient(speed).cwiseAbs().maxCoeff(), 0.1 * kSecondsPerFrame) << "in seconds";
}

TEST(RestMotionFilter, SeesWithinAFewFramesThatWhatRestedMoves) {
  Random random(5);
  RestMotionFilter filter({}, noise_of(1.0));
  double place = 0.0;
  for (int i = 0; i < 120; ++i) filter.smooth(0.5 * random_vector(random), kSecondsPerFrame);
  ASSERT_GT(filter.rest(), 0.95);
  VectorXd smoothed;
  for (int i = 0; i < 8; ++i) {
    place += 60.0 * kSecondsPerFrame;
    smoothed =
        filter.smooth(VectorXd::Constant(kValues, place) + 0.5 * random_vector(random), kSecondsPerFrame);
  }
  EXPECT_LT(filter.rest(), 0.1);
  EXPECT_NEAR(smoothed.mean(), place, 0.1 * place);
}

/// How far behind the smoothed values are when a quarter of what rested has moved for two frames, fast.
double behind_after_a_start(const RestMotionOptions& options) {
  Random random(8);
  RestMotionFilter filter(options, noise_of(1.0));
  for (int i = 0; i < 90; ++i) filter.smooth(0.5 * random_vector(random), kSecondsPerFrame);
  VectorXd smoothed;
  for (const double place : {3.0, 9.0}) {
    VectorXd values = 0.5 * random_vector(random);
    values.head(kValues / 4).array() += place;
    smoothed = filter.smooth(values, kSecondsPerFrame);
  }
  return 9.0 - smoothed.head(kValues / 4).mean();
}

TEST(RestMotionFilter, AManoeuvreIsFollowedAtOnce) {
  const double motion_alone = behind_after_a_start({.manoeuvre = 1.0});
  EXPECT_GT(motion_alone, 1.2);
  EXPECT_LT(std::abs(behind_after_a_start({})), 0.75 * motion_alone);
}

TEST(RestMotionFilter, IsTheKalmanFilterOfEachWhereOneIsCertain) {
  // With rest alone possible, values of a constant are their running mean: gains 1/2, 1/3, ...
  RestMotionFilter filter({.drift = 1e-9, .speed_change = 1e6, .stay_s = 1000.0}, noise_of(1.0));
  Random random(6);
  VectorXd sum = VectorXd::Zero(kValues);
  for (int i = 1; i <= 200; ++i) {
    const VectorXd value = 0.7 * random_vector(random);
    sum += value;
    const VectorXd smoothed = filter.smooth(value, kSecondsPerFrame);
    if (i > 100) {
      EXPECT_LT((smoothed - sum / i).cwiseAbs().maxCoeff(), 0.02) << i;
    }
  }
}

/// The filter as the paper of Blom and Bar-Shalom has it, for one value in units of its noise: matrices
/// instead of formulas.
class InteractingModels {
 public:
  explicit InteractingModels(double first) : states_{}, likely_{0.4, 0.4, 0.2} {
    for (State& state : states_) {
      state.mean = {first, 0.0};
      state.covariance = Eigen::Vector2d(1.0, 900.0).asDiagonal();
    }
  }
  double smooth(double value, double seconds) {
    const double leave = (1.0 - std::exp(-seconds / options_.stay_s * 1.5)) / 3.0;
    std::array<State, 3> next{};
    std::array<double, 3> weight{};
    for (int to = 0; to < 3; ++to) {
      State mixed{};
      std::array<double, 3> share{};
      double sum = 0.0;
      for (int from = 0; from < 3; ++from)
        sum += share[from] = likely_[from] * (from == to ? 1.0 - 2.0 * leave : leave);
      for (int from = 0; from < 3; ++from) mixed.mean += share[from] / sum * states_[from].mean;
      for (int from = 0; from < 3; ++from) {
        const Eigen::Vector2d apart = states_[from].mean - mixed.mean;
        mixed.covariance += share[from] / sum * (states_[from].covariance + apart * apart.transpose());
      }
      next[to] = predicted(mixed, to, seconds);
      const double variance = next[to].covariance(0, 0) + 1.0;
      const double surprise = value - next[to].mean.x();
      const Eigen::Vector2d gain = next[to].covariance.col(0) / variance;
      next[to].mean += gain * surprise;
      next[to].covariance -= (gain * next[to].covariance.row(0)).eval();
      constexpr double kEvidence = 0.05;  // errors of one pose are alike
      weight[to] =
          sum * std::pow(std::exp(-0.5 * surprise * surprise / variance) / std::sqrt(variance), kEvidence);
    }
    states_ = next;
    double mean = 0.0;
    for (int i = 0; i < 3; ++i) likely_[i] = weight[i] / (weight[0] + weight[1] + weight[2]);
    for (int i = 0; i < 3; ++i) mean += likely_[i] * states_[i].mean.x();
    return mean;
  }

 private:
  struct State {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  };
  State predicted(const State& state, int mode, double seconds) const {
    State next{};
    Eigen::Matrix2d step = Eigen::Matrix2d::Identity();
    Eigen::Matrix2d noise = Eigen::Matrix2d::Zero();
    if (mode == 0) {
      step(1, 1) = 0.0;
      noise(0, 0) = options_.drift * options_.drift * seconds;
    } else {
      step(0, 1) = seconds;
      const double change = options_.speed_change * (mode == 2 ? options_.manoeuvre : 1.0);
      noise << seconds * seconds * seconds / 3.0, seconds * seconds / 2.0, seconds * seconds / 2.0, seconds;
      noise *= change * change;
    }
    next.mean = step * state.mean;
    next.covariance = step * state.covariance * step.transpose() + noise;
    return next;
  }

  RestMotionOptions options_;
  std::array<State, 3> states_;
  std::array<double, 3> likely_;
};

TEST(RestMotionFilter, IsThatOfTheInteractingModels) {
  Random random(9);
  RestMotionFilter filter({}, VectorXd::Constant(1, 2.0));
  InteractingModels reference(0.3);
  ASSERT_EQ(filter.smooth(VectorXd::Constant(1, 0.6), kSecondsPerFrame)[0], 0.6);
  double place = 0.3;
  for (int i = 0; i < 150; ++i) {
    const double seconds = i % 4 == 0 ? 2.0 * kSecondsPerFrame : kSecondsPerFrame;
    if (i / 25 % 2 == 1) place += (i / 50 % 2 == 1 ? -40.0 : 60.0) * seconds;  // rests, goes, rests, returns
    const double value = place + 0.5 * random.normal();
    const double expected = 2.0 * reference.smooth(value, seconds);
    EXPECT_NEAR(filter.smooth(VectorXd::Constant(1, 2.0 * value), seconds)[0], expected, 1e-9) << i;
  }
}

TEST(RestMotionFilter, BeginsAnewAfterALeapAndNotAfterAStep) {
  for (const double away : {3.0, 60.0}) {
    Random random(10);
    RestMotionFilter filter({}, noise_of(1.0));
    for (int i = 0; i < 60; ++i) filter.smooth(0.5 * random_vector(random), kSecondsPerFrame);
    const VectorXd there = VectorXd::Constant(kValues, away);
    const VectorXd smoothed = filter.smooth(there, kSecondsPerFrame);
    EXPECT_EQ(smoothed == there, away > 10.0) << away << ": " << smoothed.transpose();
  }
}

TEST(RestMotionFilter, HeedsUnitsAndSteps) {
  // The same motion in other units, and times halved with speeds doubled, are the same in noises.
  Random random(7);
  RestMotionFilter millimetres({}, noise_of(1.0));
  RestMotionFilter metres({}, noise_of(1e-3));
  for (int i = 0; i < 60; ++i) {
    const VectorXd value = VectorXd::Constant(kValues, 1.5 * i) + random_vector(random);
    const double seconds = i % 3 == 0 ? 2.0 * kSecondsPerFrame : kSecondsPerFrame;
    const VectorXd a = millimetres.smooth(value, seconds);
    const VectorXd b = metres.smooth(1e-3 * value, seconds);
    EXPECT_LT((a - 1e3 * b).cwiseAbs().maxCoeff(), 1e-9) << i;
  }
}

TEST(RestMotionFilter, StaysFiniteAfterLeapsAndLongSteps) {
  RestMotionFilter filter({}, noise_of(1e-3));
  VectorXd value = VectorXd::Zero(kValues);
  for (const double seconds : {1e-6, 1.0, 1e-3, 1000.0, 0.03}) {
    value += VectorXd::Constant(kValues, 1e6);
    EXPECT_TRUE(filter.smooth(value, seconds).allFinite()) << seconds;
  }
  for (int i = 0; i < 400; ++i) EXPECT_TRUE(filter.smooth(value, kSecondsPerFrame).allFinite());
  EXPECT_TRUE(filter.smooth(value, kSecondsPerFrame).isApprox(value, 1e-6));
}

TEST(RestMotionFilter, RefusesWhatIsNotFiniteAndTimeThatStandsStill) {
  RestMotionFilter filter({}, noise_of(1.0));
  filter.smooth(VectorXd::Zero(kValues), kSecondsPerFrame);
  EXPECT_THAT(error_of([&] { filter.smooth(VectorXd::Constant(kValues, std::nan("")), kSecondsPerFrame); }),
              HasSubstr("not finite"));
  EXPECT_THAT(error_of([&] { filter.smooth(VectorXd::Zero(kValues), 0.0); }), HasSubstr("above 0"));
  EXPECT_THAT(error_of([&] { filter.smooth(VectorXd::Zero(kValues), std::nan("")); }), HasSubstr("above 0"));
  EXPECT_THAT(error_of([&] { filter.smooth(VectorXd::Zero(2), kSecondsPerFrame); }), HasSubstr("2 values"));
  EXPECT_THAT(error_of([&] { filter.smooth(VectorXd::Zero(kValues), INFINITY); }),
              HasSubstr("a step of inf"));
  EXPECT_THAT(error_of([] { RestMotionFilter({}, noise_of(0.0)); }), HasSubstr("above 0"));
  EXPECT_THAT(error_of([] { RestMotionFilter({}, noise_of(INFINITY)); }), HasSubstr("above 0"));
  EXPECT_THAT(error_of([] { RestMotionFilter({.drift = 0.0}, noise_of(1.0)); }), HasSubstr("drift"));
  EXPECT_THAT(error_of([] { RestMotionFilter({.manoeuvre = 0.5}, noise_of(1.0)); }), HasSubstr("manoeuvre"));
}

}  // namespace
}  // namespace knuckle
