// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"

namespace knuckle {

/// What the numbers of a first Kinect's depth image count.
enum class KinectDepthUnit {
  raw,         ///< 11 bits of disparity, 0 to 2047; 2047 = no measurement
  millimetre,  ///< 0 to 10000; 0 = no measurement
};

/// How a file holds them.
struct KinectDepthFormat {
  KinectDepthUnit unit = KinectDepthUnit::raw;
  bool is_big_endian = false;
  bool operator==(const KinectDepthFormat&) const = default;
};

/// The first Kinect's depth camera, 640x480, without distortion: focal lengths and centre that N. Burrus
/// published ("Kinect Calibration", 2011) for the device he measured. Others differ by some per cent.
Camera kinect_camera();

/// The depth [mm] of a raw value, 0 where it is no measurement or beyond the sensor's 10 m. The formula is
/// S. Magnenat's, from OpenKinect's page "Imaging Information": 123.6 tan(raw / 2842.5 + 1.1863).
float depth_of_kinect_raw(std::uint16_t raw);

/// Whether an image says in what format it is: one without any measurement in millimetres does not.
bool shows_kinect_format(const Image<std::uint16_t>& stored);

/// The format of an image whose pairs of bytes were read as little-endian numbers. The order is that in which
/// all numbers are in range, little-endian where both are. `unit` is "raw", "mm" or empty: then it is
/// millimetres where a number is above 2047, or where there are more zeros than 2047s, the two marks of no
/// measurement. Throws an Error that starts with `where` where neither order fits.
KinectDepthFormat kinect_format_of(const Image<std::uint16_t>& stored, std::string_view unit,
                                   std::string_view where);

/// Depth [mm] of such an image. Throws an Error that starts with `where` where a raw value is above 2047.
Image<float> kinect_depth_mm(const Image<std::uint16_t>& stored, const KinectDepthFormat& format,
                             std::string_view where);

}  // namespace knuckle
