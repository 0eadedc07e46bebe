// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/rest_motion_filter.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

/// What a value says of rest or motion counts for so much: errors of the parts of one pose are alike.
constexpr double kEvidence = 0.3;
/// Neither rest nor motion is ever ruled out.
constexpr double kLeastLikely = 1e-6;
/// Deviations, all values together, beyond which it is no motion.
constexpr double kLeap = 4.0;
/// Deviation of the speed that is expected at first [noises/s].
constexpr double kFirstSpeed = 30.0;

}  // namespace

void RestMotionOptions::visit(OptionVisitor& visitor) {
  visitor.real("drift", drift, open_closed(0, 1000));
  visitor.real("speed_change", speed_change, open_closed(0, 1e6));
  visitor.real("stay_s", stay_s, closed(0.01, 1000));
}

RestMotionFilter::RestMotionFilter(const RestMotionOptions& options, const Eigen::VectorXd& noise)
    : options_(options), noise_(noise.array()) {
  check_options(options_, "rest and motion filter");
  if (!noise_.allFinite() || !(noise_ > 0.0).all()) fail("rest and motion filter: a noise is not above 0");
}

/// One normal distribution in place of two: their common mean and covariance.
RestMotionFilter::Belief RestMotionFilter::mixed(const Beliefs& beliefs, double share_at_rest) {
  const auto& [rest, motion] = beliefs;
  const double a = share_at_rest;
  const double b = 1.0 - a;
  const Eigen::ArrayXd value_apart = rest.value - motion.value;
  const Eigen::ArrayXd speed_apart = rest.speed - motion.speed;
  return {a * rest.value + b * motion.value, a * rest.speed + b * motion.speed,
          a * rest.value_variance + b * motion.value_variance + a * b * value_apart.square(),
          a * rest.covariance + b * motion.covariance + a * b * value_apart * speed_apart,
          a * rest.speed_variance + b * motion.speed_variance + a * b * speed_apart.square()};
}

void RestMotionFilter::predict_rest(Belief& belief, double seconds) const {
  belief.speed.setZero();
  belief.covariance.setZero();
  belief.speed_variance.setZero();
  belief.value_variance += options_.drift * options_.drift * seconds;
}

/// A speed whose changes are white noise.
void RestMotionFilter::predict_motion(Belief& belief, double seconds) const {
  const double change = options_.speed_change * options_.speed_change * seconds;
  belief.value += seconds * belief.speed;
  belief.value_variance += seconds * (2.0 * belief.covariance + seconds * belief.speed_variance) +
                           change * seconds * seconds / 3.0;
  belief.covariance += seconds * belief.speed_variance + change * seconds / 2.0;
  belief.speed_variance += change;
}

/// Whether not even a motion brings the values here: they are other ones, of which nothing is known.
bool RestMotionFilter::is_leap(const Belief& motion, const Eigen::ArrayXd& value) {
  return ((value - motion.value).square() / (motion.value_variance + 1.0)).mean() > kLeap * kLeap;
}

/// Takes in a value, whose noise has a variance of 1; answers the logarithm of its likelihood.
double RestMotionFilter::learn(Belief& belief, const Eigen::ArrayXd& value) {
  const Eigen::ArrayXd variance = belief.value_variance + 1.0;
  const Eigen::ArrayXd surprise = value - belief.value;
  const Eigen::ArrayXd gain = belief.value_variance / variance;
  const Eigen::ArrayXd speed_gain = belief.covariance / variance;
  belief.value += gain * surprise;
  belief.speed += speed_gain * surprise;
  belief.speed_variance -= speed_gain * belief.covariance;
  belief.covariance *= 1.0 - gain;
  belief.value_variance *= 1.0 - gain;
  return -0.5 * kEvidence * (surprise.square() / variance + variance.log()).sum();
}

Eigen::VectorXd RestMotionFilter::smooth(const Eigen::VectorXd& value, double seconds) {
  if (value.size() != noise_.size()) {
    fail("rest and motion filter: {} values, expected {}", value.size(), noise_.size());
  }
  if (!value.allFinite()) fail("rest and motion filter: a value is not finite");
  const Eigen::ArrayXd scaled = value.array() / noise_;
  if (!beliefs_) {
    const Eigen::ArrayXd none = Eigen::ArrayXd::Zero(value.size());
    const Belief first{scaled, none, none + 1.0, none, none + kFirstSpeed * kFirstSpeed};
    beliefs_ = {first, first};
    return value;
  }
  if (!(seconds > 0.0) || !std::isfinite(seconds))
    fail("rest and motion filter: a step of {} s, expected above 0", seconds);

  const double stay = 0.5 + 0.5 * std::exp(-2.0 * seconds / options_.stay_s);
  const double rest_before = stay * likely_[0] + (1.0 - stay) * likely_[1];
  const double motion_before = 1.0 - rest_before;
  Beliefs next{mixed(*beliefs_, stay * likely_[0] / rest_before),
               mixed(*beliefs_, (1.0 - stay) * likely_[0] / motion_before)};
  predict_rest(next[0], seconds);
  predict_motion(next[1], seconds);
  if (is_leap(next[1], scaled)) {
    reset();
    return smooth(value, seconds);
  }
  const double for_rest = learn(next[0], scaled) - learn(next[1], scaled);
  // The logistic function of the logarithm of the odds.
  const double rest = 1.0 / (1.0 + motion_before / rest_before * std::exp(-for_rest));
  likely_[0] = std::clamp(rest, kLeastLikely, 1.0 - kLeastLikely);
  likely_[1] = 1.0 - likely_[0];
  beliefs_ = std::move(next);
  return (likely_[0] * (*beliefs_)[0].value + likely_[1] * (*beliefs_)[1].value) * noise_;
}

void RestMotionFilter::reset() {
  beliefs_.reset();
  likely_ = {0.5, 0.5};
}

}  // namespace knuckle
