// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/core/camera.h"
#include "knuckle/core/frame.h"
#include "knuckle/segment/segmenter.h"

namespace knuckle {

/// The region that consists of these pixels (row * width + column of an image `width` pixels wide; at least
/// one). Centre and score are left to the caller.
HandRegion region_of_pixels(const std::vector<std::int32_t>& pixels, int width);

/// The region seen in a mirror: of an image that is `width` pixels wide and mirrored too. x of the centre
/// changes sign, and a side becomes the other one.
HandRegion mirrored(HandRegion region, int width);

/// What is measured in the cube around `centre` whose edges are parallel to the camera's axes; an empty box
/// and mask where nothing is. The centre is `centre`; the score is left to the caller.
HandRegion region_in_cube(const Frame& frame, const Point3& centre, double side_mm);

/// Area that a pixel covers at this depth, on a plane parallel to the image [mm^2].
double pixel_area_mm2(const Camera& camera, double depth_mm);

/// Area that these pixels of a depth image cover, each on a plane parallel to the image [mm^2].
double area_mm2(const std::vector<std::int32_t>& pixels, const Camera& camera, const Image<float>& depth_mm);

/// The mean of the points that these pixels show, in camera coordinates [mm].
Point3 mean_point(const std::vector<std::int32_t>& pixels, const RayTable& rays,
                  const Image<float>& depth_mm);

/// Throws an Error unless a segmenter can be asked for so many hands: [1, 16].
void check_max_hands(int max_hands);

/// Throws an Error where the start of a segmentation is not finite.
void check_start(const Frame& frame, const std::optional<Point3>& start);

/// Throws an Error that names the frame where its depth image and its camera differ in size. An empty image
/// passes: it is a frame without measurements.
void check_size(const Frame& frame);

}  // namespace knuckle
