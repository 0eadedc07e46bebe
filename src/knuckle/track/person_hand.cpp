// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/person_hand.h"

#include <cmath>

namespace knuckle {

void PersonHand::learn(const SkeletonPose& pose) {
  size_.add(std::log(pose.size));
  for (std::size_t i = 0; i < lengths_.size(); ++i) lengths_[i].add(std::log(pose.lengths[i / 3][i % 3]));
}

void PersonHand::tell(SkeletonFitOptions& options) const {
  if (size_.count == 0) return;
  options.size_spread = options.length_spread = 0.0;
  options.size = std::exp(size_.value());
  for (std::size_t i = 0; i < lengths_.size(); ++i)
    options.lengths[i / 3][i % 3] = std::exp(lengths_[i].value());
}

}  // namespace knuckle
