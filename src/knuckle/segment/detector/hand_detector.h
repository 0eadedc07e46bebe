// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "knuckle/net/layers/encoder_decoder.h"
#include "knuckle/net/layers/workspace_pool.h"
#include "knuckle/segment/camera_cache.h"
#include "knuckle/segment/detector/detection.h"
#include "knuckle/segment/detector/detector_file.h"

namespace knuckle {

/// A network that sees a whole depth frame, small, and says where hands are (docs/detector.md).
class HandDetector {
 public:
  explicit HandDetector(const DetectorWeights& weights);

  const DetectorOptions& options() const { return options_; }

  /// What the network says of a small picture of its size. Throws an Error where (with weights no training
  /// ends in) a number would not be finite. Safe to call from many threads.
  DetectorMaps maps_of(const DetectorInput& input) const;

  /// How the network sees the frames of a camera. Safe to call from many threads; what it computes it keeps.
  std::shared_ptr<const DetectorView> view_of(const Camera& camera) const { return views_.of(camera); }

  /// The hands of a frame, the surest first. The depth image has the camera's size and a pixel at least. Safe
  /// to call from many threads; what it computes for a camera it keeps.
  std::vector<DetectedHand> detect(const Frame& frame, const DetectionOptions& options) const;

 private:
  DetectorOptions options_;
  EncoderDecoder network_;
  WorkspacePool<EncoderDecoder::Maps> pool_;
  mutable CameraCache<DetectorView> views_;
};

}  // namespace knuckle
