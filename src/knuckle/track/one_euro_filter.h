// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "knuckle/core/options.h"

namespace knuckle {

/// Options of the One Euro filter (Casiez, Roussel and Vogel, "1 Euro filter: a simple speed-based low-pass
/// filter for noisy input in interactive systems", CHI 2012): the slower a value moves, the more it is
/// smoothed.
struct OneEuroOptions {
  double rest_cutoff_hz = 2.0;  ///< cutoff frequency of a value that rests, (0, 1000] [Hz]: lower is smoother
  double cutoff_per_speed =
      0.0;  ///< what is added to it per unit of speed, [0, 1000] [Hz s / unit]: higher lags less
  double speed_cutoff_hz = 1.0;  ///< of the speed itself, (0, 1000] [Hz]

  void visit(OptionVisitor& visitor);
};

/// Smooths a vector whose components share one speed, its length, so that a direction is kept. One caller.
class OneEuroFilter {
 public:
  /// Throws an Error where an option is out of range.
  explicit OneEuroFilter(const OneEuroOptions& options);

  /// The smoothed value. `seconds` since the one before, above 0: the cutoffs are true for any steps. The
  /// first value comes back as it is. Throws an Error where a number is not finite, the time not above 0, or
  /// the size another.
  Eigen::VectorXd smooth(const Eigen::VectorXd& value, double seconds);
  /// Forgets what came before.
  void reset();

 private:
  OneEuroOptions options_;
  std::optional<Eigen::VectorXd> value_;
  Eigen::VectorXd speed_;
};

/// The part that a new value has in a low-pass filter of first order after `seconds`: 1 - exp(-2 pi cutoff
/// seconds), which is exact for any step (Casiez et al. use its approximation for small ones).
double low_pass_share(double cutoff_hz, double seconds);

}  // namespace knuckle
