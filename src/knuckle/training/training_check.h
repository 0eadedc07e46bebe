// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "knuckle/core/image.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/training/network_training_config.h"

namespace knuckle {

/// What a training will see.
struct TrainingCheck {
  std::string text;  ///< lines for a person: each set with its frames, share and known landmarks
  /// The first samples in the views in which they will be trained on, labels drawn over them, each with the
  /// number of its set.
  Image<Rgb> sheet;
};

/// Looks at some frames of each source of a configuration, without training. Throws what making the samples
/// throws.
TrainingCheck check_network_training(const NetworkTrainingConfig& config);

}  // namespace knuckle
