// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "knuckle/net/network_options.h"
#include "knuckle/patch/hand_patch.h"

namespace knuckle {

/// What a network says about one patch.
struct NetworkPrediction {
  std::vector<PatchPoint> joints;  ///< one a landmark of the convention
  std::vector<float> confidence;   ///< one a joint, in [0, 1]; or empty where the network gives none
};

/// A trained network, for inference on the calling thread.
class PoseNetwork {
 public:
  /// Throws an Error that names the file where it is missing, cut short, foreign, or of another version.
  explicit PoseNetwork(const std::filesystem::path& path);
  /// One that has learned nothing, with random weights: for measurements and tests. Throws an Error where an
  /// option is out of range.
  PoseNetwork(const NetworkOptions& options, std::uint64_t seed);
  PoseNetwork(PoseNetwork&&) noexcept;
  PoseNetwork& operator=(PoseNetwork&&) noexcept;
  ~PoseNetwork();

  const NetworkOptions& options() const;
  /// Throws an Error where the patch has another size or a pixel is not finite. Safe to call from many
  /// threads.
  NetworkPrediction predict(const Image<float>& patch) const;

 private:
  void make_ready();

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace knuckle
