// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detector_file.h"

#include <utility>

namespace knuckle {
namespace {

DetectorOptions options_from_toml(std::string_view toml, const std::string& origin) {
  const OptionTable document = OptionTable::parse(toml, origin);
  DetectorOptions options;
  document.table("network").read(options);
  document.finish();
  check(options, origin);
  return options;
}

}  // namespace

DetectorWeights::DetectorWeights(const DetectorOptions& options)
    : WeightArrays(encoder_decoder_arrays(options.shape())), options_(options) {}

DetectorWeights random_detector(const DetectorOptions& options, std::uint64_t seed) {
  check(options, "detector");
  DetectorWeights weights(options);
  weights.fill_randomly(seed);
  return weights;
}

std::string detector_options_as_toml(const DetectorOptions& options) {
  return "[network]\n" + options_as_toml(options);
}

void save_detector_weights(const std::filesystem::path& path, const DetectorWeights& weights) {
  save_weights(path, kDetectorFormat, detector_options_as_toml(weights.options()), weights);
}

DetectorWeights load_detector_weights(const std::filesystem::path& path) {
  return read_detector_weights(ModelFile::open(path));
}

DetectorWeights read_detector_weights(ModelFile model) {
  const WeightFile file(std::move(model), kDetectorFormat);
  const DetectorOptions options = options_from_toml(file.options_toml(), file.origin());
  file.require(encoder_decoder_arrays(options.shape()));
  DetectorWeights weights(options);
  file.read(weights);
  return weights;
}

}  // namespace knuckle
