// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include "knuckle/core/options.h"

namespace knuckle {

/// Options of the RestMotionFilter, in units of the values' noise.
struct RestMotionOptions {
  double drift = 0.06;  ///< of a value that rests, within a second (deviation), (0, 1000] [1 / sqrt(s)]
  double speed_change = 45.0;  ///< of one that moves, within a second (deviation), (0, 1e6] [1 / s / sqrt(s)]
  double manoeuvre =
      8.0;              ///< how much more the speed changes where a motion begins, turns or ends, [1, 1000]
  double stay_s = 6.0;  ///< mean time until rest, motion and manoeuvre take turns, [0.01, 1000] [s]

  void visit(OptionVisitor& visitor);
};

/// Smooths a vector, all of which rests, moves, or begins to: three Kalman filters, one for a constant value,
/// one for a speed that is nearly constant, and one for a speed that changes (a manoeuvre), and how likely
/// each is (interacting multiple models; Blom and Bar-Shalom, "The interacting multiple model algorithm for
/// systems with Markovian switching coefficients", 1988). What rests is averaged over a long time; what moves
/// at a constant speed does not lag; what begins to move is seen within a frame; after a leap, all begins
/// anew. One caller.
class RestMotionFilter {
 public:
  /// `noise`: deviation of each value's error, above 0. Throws an Error where that or an option is out of
  /// range.
  RestMotionFilter(const RestMotionOptions& options, const Eigen::VectorXd& noise);

  /// The smoothed value. `seconds` since the one before, above 0. The first value comes back as it is. Throws
  /// an Error where a number is not finite, the time not above 0, or the size another than that of the noise.
  Eigen::VectorXd smooth(const Eigen::VectorXd& value, double seconds);
  /// Forgets what came before.
  void reset();
  /// How likely it is that the values rest, [0, 1].
  double rest() const { return likely_.front(); }

 private:
  /// What one filter believes of each value: the means of value and speed, and their covariance.
  struct Belief {
    Eigen::ArrayXd value, speed, value_variance, covariance, speed_variance;
  };
  static constexpr std::size_t kModes = 3;  // rest, motion, manoeuvre
  using Beliefs = std::array<Belief, kModes>;
  using Shares = std::array<double, kModes>;
  static constexpr Shares kFirstLikely{0.4, 0.4, 0.2};

  Shares origins_of(std::size_t mode, double seconds) const;
  static Belief mixed(const Beliefs& beliefs, const Shares& shares);
  void predict(std::size_t mode, Belief& belief, double seconds) const;
  void predict_rest(Belief& belief, double seconds) const;
  static void predict_motion(Belief& belief, double speed_change, double seconds);
  static bool is_leap(const Belief& manoeuvre, const Eigen::ArrayXd& value);
  static double learn(Belief& belief, const Eigen::ArrayXd& value);

  RestMotionOptions options_;
  Eigen::ArrayXd noise_;
  std::optional<Beliefs> beliefs_;
  Shares likely_ = kFirstLikely;
};

}  // namespace knuckle
