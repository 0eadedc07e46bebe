// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/one_euro_filter.h"

#include <cmath>
#include <numbers>

#include "knuckle/core/error.h"

namespace knuckle {

void OneEuroOptions::visit(OptionVisitor& visitor) {
  visitor.real("rest_cutoff_hz", rest_cutoff_hz, open_closed(0, 1000));
  visitor.real("cutoff_per_speed", cutoff_per_speed, closed(0, 1000));
  visitor.real("speed_cutoff_hz", speed_cutoff_hz, open_closed(0, 1000));
}

double low_pass_share(double cutoff_hz, double seconds) {
  return -std::expm1(-2.0 * std::numbers::pi * cutoff_hz * seconds);
}

OneEuroFilter::OneEuroFilter(const OneEuroOptions& options) : options_(options) {
  check_options(options_, "one euro filter");
}

Eigen::VectorXd OneEuroFilter::smooth(const Eigen::VectorXd& value, double seconds) {
  if (!value.allFinite()) fail("one euro filter: a value is not finite");
  if (!value_) {
    value_ = value;
    speed_ = Eigen::VectorXd::Zero(value.size());
    return value;
  }
  if (value.size() != value_->size()) {
    fail("one euro filter: {} values, those before were {}", value.size(), value_->size());
  }
  if (!(seconds > 0.0) || !std::isfinite(seconds))
    fail("one euro filter: a step of {} s, expected above 0", seconds);
  const Eigen::VectorXd step = (value - *value_) / seconds;
  speed_ += low_pass_share(options_.speed_cutoff_hz, seconds) * (step - speed_);
  const double cutoff_hz = options_.rest_cutoff_hz + options_.cutoff_per_speed * speed_.norm();
  *value_ += low_pass_share(cutoff_hz, seconds) * (value - *value_);
  return *value_;
}

void OneEuroFilter::reset() {
  value_.reset();
}

}  // namespace knuckle
