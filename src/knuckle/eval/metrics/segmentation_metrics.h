// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knuckle/core/box.h"
#include "knuckle/core/image.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// An axis-aligned rectangle of the image plane [px]; the centre of pixel (i, j) is (i, j).
struct Rectangle {
  double left = 0.0;
  double top = 0.0;
  double right = 0.0;
  double bottom = 0.0;

  double area() const { return right > left && bottom > top ? (right - left) * (bottom - top) : 0.0; }
};

/// The area that the pixels of a box cover: half a pixel beyond the outer pixels' centres.
Rectangle rectangle_of(const Box& box);

/// The rectangle of least area that encloses the known 2D joints (Riegler et al. 2015, section 5.1: B_gt);
/// nothing where no joint is known.
std::optional<Rectangle> rectangle_around(const HandPose& pose);

/// r = area(a and b) / area(a or b), in [0, 1] (Riegler et al. 2015, eq. 4); 0 where both are empty.
double intersection_over_union(const Rectangle& a, const Rectangle& b);
double intersection_over_union(const Box& a, const Box& b);

/// The same counted in pixels: those that are not 0 in both masks over those in either. Both masks empty: 1,
/// they agree. Throws where the sizes differ.
double mask_intersection_over_union(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b);

/// How well a method finds the hand.
struct SegmentationScore {
  std::string name;
  std::int64_t frames = 0;   ///< frames in which the hand's place is known
  std::int64_t missing = 0;  ///< of them those in which no hand was found; their r is 0
  double mean_iou = 0.0;     ///< [0, 1], over all frames, missing ones included
  double median_iou = 0.0;
  std::vector<double> threshold;       ///< t = 0, 0.01, ..., 1
  std::vector<double> fraction_above;  ///< of frames with r > t
};

/// Scores one overlap r a frame, each in [0, 1]; in `missing` of them no hand was found at all.
SegmentationScore score_overlaps(const std::string& name, std::span<const double> overlaps,
                                 std::int64_t missing);

/// Scores estimated boxes (an empty one: no hand found) against the rectangles around true joints. Frames
/// whose truth knows no joint are left out. Throws where the numbers of frames differ or no frame is left.
SegmentationScore score_boxes(const std::string& name, std::span<const Box> boxes,
                              std::span<const HandPose> truth);

}  // namespace knuckle
