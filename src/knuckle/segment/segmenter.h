// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/core/box.h"
#include "knuckle/core/frame.h"
#include "knuckle/core/image.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// One hand found in a frame.
struct HandRegion {
  Box box;                         ///< smallest box around the hand's pixels
  Image<std::uint8_t> mask;        ///< of the box's size: 1 where pixel (box.x + column, box.y + row) is hand
  Point3 centre = Point3::Zero();  ///< in camera coordinates [mm]
  double score = 0.0;              ///< larger is surer; what it means is the method's matter
  std::optional<double> likelihood =
      std::nullopt;  ///< how likely it is a hand, (0, 1]; where the method tells, and no start was given
  std::optional<HandSide> side =
      std::nullopt;  ///< which hand it is, in the frame given; where the method tells
  std::optional<double> right_hand =
      std::nullopt;  ///< how likely it is a right one, (0, 1); where a `SideNetwork` was asked
};

/// The hands of a frame, best first. None found is an answer, not an error.
struct Segmentation {
  std::vector<HandRegion> hands;
  std::string
      reason;  ///< why there is no hand, for example "no measurement in the frame"; empty where there is one
};

/// Finds hands in a depth image.
class Segmenter {
 public:
  virtual ~Segmenter() = default;

  /// `start`, where given, is a point in camera coordinates [mm] to look for the hand at; otherwise the
  /// method chooses where to start (the nearest point). Returns at most `max_hands` hands, [1, 16]. Throws an
  /// Error where that is out of range, the start is not finite (a missing joint is the caller's to notice) or
  /// the image has not the size of its camera. Safe to call from many threads.
  virtual Segmentation segment(const Frame& frame, const std::optional<Point3>& start,
                               int max_hands) const = 0;
};

}  // namespace knuckle
