// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "knuckle/net/network_inference.h"
#include "knuckle/net/network_options.h"

namespace knuckle {

/// A trained network, for inference on the calling thread.
class PoseNetwork {
 public:
  /// Throws an Error that names the file where it is missing, cut short, damaged, foreign, or of another
  /// version.
  explicit PoseNetwork(const std::filesystem::path& path);
  /// One that has learned nothing, with random weights: for measurements and tests. Throws an Error where an
  /// option is out of range.
  PoseNetwork(const NetworkOptions& options, std::uint64_t seed);
  explicit PoseNetwork(const NetworkWeights& weights);

  const NetworkOptions& options() const { return options_; }
  /// Throws an Error where the patch has another size, a pixel is not finite, or (with weights no training
  /// ends in) a joint would not be. Safe to call from many threads.
  NetworkPrediction predict(const Image<float>& patch) const;

 private:
  NetworkOptions options_;
  std::unique_ptr<const NetworkInference> inference_;
};

}  // namespace knuckle
