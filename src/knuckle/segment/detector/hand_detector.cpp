// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/hand_detector.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/segment/detector/detector_relief.h"

namespace knuckle {
namespace {

/// Writes one number of each pixel.
void write_plane(std::span<const float> plane, int channel, FeatureMap& map) {
  const int inputs = map.channels();
  for (int row = 0; row < map.height(); ++row) {
    const float* const from = plane.data() + static_cast<std::size_t>(row) * map.width();
    float* const to = map.pixel(row, 0) + channel;
    for (int column = 0; column < map.width(); ++column) to[inputs * column] = from[column];
  }
}

void write_input(const DetectorOptions& options, const DetectorInput& input, FeatureMap& map) {
  const std::span<const float> inverse_depth = input.inverse_depth.pixels();
  write_plane(inverse_depth, 0, map);
  write_plane(input.measured_share.pixels(), 1, map);
  if (!options.relief) return;
  std::vector<float> reliefs(inverse_depth.size() * kReliefInputs);
  write_reliefs(options, inverse_depth, reliefs);
  for (int i = 0; i < kReliefInputs; ++i) {
    write_plane(std::span(reliefs).subspan(i * inverse_depth.size(), inverse_depth.size()),
                kMeasuredInputs + i, map);
  }
}

DetectorMaps maps_in(const FeatureMap& map) {
  DetectorMaps maps{map.width(), map.height(), {}};
  maps.values.reserve(static_cast<std::size_t>(map.width()) * map.height() * kDetectorMaps);
  for (int row = 0; row < map.height(); ++row) {
    for (int column = 0; column < map.width(); ++column) {
      const float* const from = map.pixel(row, column);
      maps.values.insert(maps.values.end(), from, from + kDetectorMaps);
    }
  }
  return maps;
}

}  // namespace

HandDetector::HandDetector(const DetectorWeights& weights)
    : options_(weights.options()),
      network_(options_.shape(), weights),
      pool_([options = options_] {
        return EncoderDecoder::Maps(options.shape(), {options.height, options.width});
      }),
      views_([options = options_](const Camera& camera) {
        return std::make_shared<const DetectorView>(options, camera);
      }) {}

DetectorMaps HandDetector::maps_of(const DetectorInput& input) const {
  DetectorMaps maps = pool_.with_workspace([&](EncoderDecoder::Maps& work) {
    write_input(options_, input, work.input);
    network_.apply(work);
    return maps_in(work.maps);
  });
  if (!std::ranges::all_of(maps.values, [](float value) { return std::isfinite(value); })) {
    fail("detector: a number that its network gives is not finite");
  }
  return maps;
}

std::vector<DetectedHand> HandDetector::detect(const Frame& frame, const DetectionOptions& options) const {
  const std::shared_ptr<const DetectorView> view = view_of(frame.camera);
  return hands_in(maps_of(view->shrink(frame.depth_mm)), *view, options);
}

}  // namespace knuckle
