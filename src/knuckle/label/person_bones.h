// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "knuckle/hand/skeleton_fit.h"
#include "knuckle/label/label_book.h"

namespace knuckle {

/// The bones of one person's hands, learned from the hands that were verified: size and proportions against
/// an adult's. Each verified hand is one more measurement of them, so that the fit of every other frame of
/// the sequence becomes surer. A value.
class PersonBones {
 public:
  /// What the fit to a verified hand says; one that was verified before is measured anew.
  void learn(HandKey hand, const SkeletonPose& fitted);
  /// A hand that is verified no longer.
  void forget(HandKey hand);
  /// Hands that were learned from.
  std::size_t size() const { return hands_.size(); }

  /// Puts means and deviations of size and lengths into a fit's options, in place of what it knows of all
  /// people: the posterior of normal distributions of logarithms.
  void tell(SkeletonFitOptions& options) const;

 private:
  std::map<HandKey, SkeletonPose> hands_;
};

}  // namespace knuckle
