// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/rest_motion_filter.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

/// What a value says of rest, motion or manoeuvre counts for so much: errors of the parts of one pose are
/// alike.
constexpr double kEvidence = 0.05;
/// None is ever ruled out.
constexpr double kLeastLikely = 1e-6;
/// Deviations, all values together, beyond which it is no motion.
constexpr double kLeap = 4.0;
/// Deviation of the speed that is expected at first [noises/s].
constexpr double kFirstSpeed = 30.0;

constexpr std::size_t kRest = 0;
constexpr std::size_t kManoeuvre = 2;

template <class Shares>
double sum_of(const Shares& shares) {
  return std::accumulate(shares.begin(), shares.end(), 0.0);
}

template <class Shares>
Shares scaled_to_one(Shares shares) {
  const double sum = sum_of(shares);
  for (double& share : shares) share /= sum;
  return shares;
}

/// What is this likely, in logarithms that all lack the same number.
template <class Shares>
Shares likely_by(Shares evidence) {
  const double most = *std::ranges::max_element(evidence);
  for (double& value : evidence) value = std::max(std::exp(value - most), kLeastLikely);
  return scaled_to_one(evidence);
}

}  // namespace

void RestMotionOptions::visit(OptionVisitor& visitor) {
  visitor.real("drift", drift, open_closed(0, 1000));
  visitor.real("speed_change", speed_change, open_closed(0, 1e6));
  visitor.real("manoeuvre", manoeuvre, closed(1, 1000));
  visitor.real("stay_s", stay_s, closed(0.01, 1000));
}

RestMotionFilter::RestMotionFilter(const RestMotionOptions& options, const Eigen::VectorXd& noise)
    : options_(options), noise_(noise.array()) {
  check_options(options_, "rest and motion filter");
  if (!noise_.allFinite() || !(noise_ > 0.0).all()) fail("rest and motion filter: a noise is not above 0");
}

/// How likely it is that each mode was before and `mode` is now.
RestMotionFilter::Shares RestMotionFilter::origins_of(std::size_t mode, double seconds) const {
  constexpr double kOthers = kModes - 1;
  const double leave =
      (1.0 - std::exp(-seconds / options_.stay_s * kModes / kOthers)) / kModes;  // to each other
  Shares origins;
  for (std::size_t from = 0; from < kModes; ++from) {
    origins[from] = likely_[from] * (from == mode ? 1.0 - kOthers * leave : leave);
  }
  return origins;
}

/// One normal distribution in place of several: their common mean and covariance.
RestMotionFilter::Belief RestMotionFilter::mixed(const Beliefs& beliefs, const Shares& shares) {
  const Eigen::ArrayXd none = Eigen::ArrayXd::Zero(beliefs.front().value.size());
  Belief mean{none, none, none, none, none};
  for (std::size_t mode = 0; mode < kModes; ++mode) {
    mean.value += shares[mode] * beliefs[mode].value;
    mean.speed += shares[mode] * beliefs[mode].speed;
  }
  for (std::size_t mode = 0; mode < kModes; ++mode) {
    const Belief& belief = beliefs[mode];
    const Eigen::ArrayXd value_apart = belief.value - mean.value;
    const Eigen::ArrayXd speed_apart = belief.speed - mean.speed;
    mean.value_variance += shares[mode] * (belief.value_variance + value_apart.square());
    mean.covariance += shares[mode] * (belief.covariance + value_apart * speed_apart);
    mean.speed_variance += shares[mode] * (belief.speed_variance + speed_apart.square());
  }
  return mean;
}

void RestMotionFilter::predict(std::size_t mode, Belief& belief, double seconds) const {
  if (mode == kRest) return predict_rest(belief, seconds);
  const double change =
      mode == kManoeuvre ? options_.manoeuvre * options_.speed_change : options_.speed_change;
  predict_motion(belief, change, seconds);
}

void RestMotionFilter::predict_rest(Belief& belief, double seconds) const {
  belief.speed.setZero();
  belief.covariance.setZero();
  belief.speed_variance.setZero();
  belief.value_variance += options_.drift * options_.drift * seconds;
}

/// A speed whose changes are white noise.
void RestMotionFilter::predict_motion(Belief& belief, double speed_change, double seconds) {
  const double change = speed_change * speed_change * seconds;
  belief.value += seconds * belief.speed;
  belief.value_variance += seconds * (2.0 * belief.covariance + seconds * belief.speed_variance) +
                           change * seconds * seconds / 3.0;
  belief.covariance += seconds * belief.speed_variance + change * seconds / 2.0;
  belief.speed_variance += change;
}

/// Whether not even a manoeuvre brings the values here: they are other ones, of which nothing is known.
bool RestMotionFilter::is_leap(const Belief& manoeuvre, const Eigen::ArrayXd& value) {
  return ((value - manoeuvre.value).square() / (manoeuvre.value_variance + 1.0)).mean() > kLeap * kLeap;
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
    beliefs_ = {first, first, first};
    return value;
  }
  if (!(seconds > 0.0) || !std::isfinite(seconds))
    fail("rest and motion filter: a step of {} s, expected above 0", seconds);

  Beliefs next;
  Shares evidence;  // logarithms
  for (std::size_t mode = 0; mode < kModes; ++mode) {
    const Shares origins = origins_of(mode, seconds);
    next[mode] = mixed(*beliefs_, scaled_to_one(origins));
    predict(mode, next[mode], seconds);
    evidence[mode] = std::log(sum_of(origins));
  }
  if (is_leap(next[kManoeuvre], scaled)) {
    reset();
    return smooth(value, seconds);
  }
  for (std::size_t mode = 0; mode < kModes; ++mode) evidence[mode] += learn(next[mode], scaled);
  likely_ = likely_by(evidence);
  beliefs_ = std::move(next);
  Eigen::ArrayXd mean = Eigen::ArrayXd::Zero(value.size());
  for (std::size_t mode = 0; mode < kModes; ++mode) mean += likely_[mode] * (*beliefs_)[mode].value;
  return mean * noise_;
}

void RestMotionFilter::reset() {
  beliefs_.reset();
  likely_ = kFirstLikely;
}

}  // namespace knuckle
