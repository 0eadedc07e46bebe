// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "knuckle/net/layers/weight_arrays.h"
#include "knuckle/net/layers/weight_file.h"
#include "knuckle/segment/detector/detector_options.h"

namespace knuckle {

/// What a detector's file says it is.
inline constexpr WeightFormat kDetectorFormat{"knuckle-detector", 1};

/// A detector's network and all its numbers.
class DetectorWeights : public WeightArrays {
 public:
  /// All zero.
  explicit DetectorWeights(const DetectorOptions& options);
  const DetectorOptions& options() const { return options_; }

 private:
  DetectorOptions options_;
};

/// A network that has learned nothing (`WeightArrays::fill_randomly`). Throws an Error where an option is out
/// of range.
DetectorWeights random_detector(const DetectorOptions& options, std::uint64_t seed);

/// The options as TOML: what a network must have in common with another to take its weights.
std::string detector_options_as_toml(const DetectorOptions& options);

/// Writes a detector, atomically. Throws an Error that names the file where it cannot be written.
void save_detector_weights(const std::filesystem::path& path, const DetectorWeights& weights);

/// Reads a detector. Throws an Error that names the file where it is missing, cut short, damaged, of another
/// kind or version, does not fit its own options, or holds a number that is not finite.
DetectorWeights load_detector_weights(const std::filesystem::path& path);
/// The same of a file that is open.
DetectorWeights read_detector_weights(ModelFile model);

}  // namespace knuckle
