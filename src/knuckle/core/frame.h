// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// True where a pixel of a depth image holds a measurement: a finite depth above 0 (so not 0, NaN or
/// infinity).
inline bool is_measured(float depth_mm) {
  return depth_mm > 0.0f && depth_mm <= std::numeric_limits<float>::max();
}

/// Which hand of a person.
enum class HandSide : std::uint8_t { right, left };

/// What a pixel of an exact picture shows.
enum class PixelLabel : std::uint8_t {
  nothing,
  hand,        ///< the hand that `Frame::truth` and `Frame::mask` tell of
  other_hand,  ///< a second hand
  person,      ///< arms, trunk, face and what they wear
  object,      ///< everything else
};

/// What lies between the camera and the skin over a landmark.
enum class Occluder : std::uint8_t {
  none,        ///< the landmark is visible
  own_hand,    ///< another part of the same hand
  other_hand,  ///< another hand
  person,      ///< an arm, the trunk, or what they wear
  object,
  border,  ///< it lies outside the image
};

/// The truth about one of the hands in a frame.
struct HandTruth {
  HandSide side = HandSide::right;
  HandPose pose;                    ///< joints in pixel-centre coordinates
  std::vector<Occluder> occluders;  ///< one per joint
  double visible_share = 1.0;       ///< part of its pixels that nothing else hides, [0, 1]
};

/// The same in a mirrored image that is `width` pixels wide: the other side.
HandTruth mirrored(const HandTruth& hand, int width);

/// One depth image with all that is known about it.
struct Frame {
  std::string name;               ///< unique in its source, for messages and pictures; no extension
  Camera camera;                  ///< has the size of the depth image
  Image<float> depth_mm;          ///< distance along z [mm]; 0 = no measurement
  Image<std::uint16_t> infrared;  ///< amplitude in the sensor's own unit; empty where the source has none
  Image<std::uint8_t> mask;       ///< truth: 1 where a pixel is hand, else 0; empty where the source has none
  std::optional<HandPose> truth;  ///< joints in pixel-centre coordinates; joints may be missing
  std::optional<HandSide> side;   ///< truth: which hand it is; nothing where the source does not know
  Image<std::uint8_t> labels;  ///< truth: a PixelLabel per pixel; empty where the source does not know them
  std::vector<HandTruth>
      hands;  ///< truth: all hands in view, that of `truth` first; empty: not known, or none
  std::optional<double> time_s;  ///< when it was taken [s], any zero; never goes back within a sequence
  int sequence = 0;              ///< which of the source's sequences it belongs to, >= 0
};

/// The frame in a mirror: images, camera and truth. A left hand becomes a right one,
/// and says so.
Frame mirrored(const Frame& frame);

}  // namespace knuckle
