// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/frame.h"

namespace knuckle {

/// What is known of a frame without its images.
struct FrameLabel {
  Camera camera;
  std::optional<HandPose> truth;
  std::optional<double> time_s = {};  ///< as in Frame
  int sequence = 0;                   ///< as in Frame
  std::string name = {};              ///< as in Frame
  std::optional<HandSide> side = {};  ///< as in Frame
};

/// Frames, one after another: a data set on disk, a generator, a camera. The paper's "data provider".
///
/// Opening lists the frames but loads none. `read` is safe to call from many threads at once.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Number of frames, at least 1: opening an empty source is an error.
  virtual std::int64_t size() const = 0;
  /// Frame `index` in [0, size). Throws an Error that names the file where it cannot be read.
  virtual Frame read(std::int64_t index) const = 0;
  /// Camera, truth, time, sequence, name and side as `read` gives them. Most sources need not open the images
  /// for that.
  virtual FrameLabel read_label(std::int64_t index) const {
    Frame frame = read(index);
    return {frame.camera,   std::move(frame.truth), frame.time_s,
            frame.sequence, std::move(frame.name),  frame.side};
  }
  /// What the truth is labelled in; nothing where the source has no truth.
  virtual std::optional<Convention> convention() const = 0;
  /// The pixel origin of the source's own files: results written for it use the same.
  virtual PixelOrigin pixel_origin() const { return PixelOrigin::centre; }
};

}  // namespace knuckle
