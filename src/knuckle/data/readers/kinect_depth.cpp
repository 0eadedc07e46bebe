// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/kinect_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "knuckle/core/error.h"
#include "knuckle/core/portable_math.h"
#include "knuckle/data/readers/depth_image.h"

namespace knuckle {
namespace {

constexpr int kRawValues = 2048;
constexpr std::uint16_t kNoRawMeasurement = kRawValues - 1;
constexpr std::uint16_t kFarthestMm = 10000;

std::uint16_t swapped(std::uint16_t value) {
  return static_cast<std::uint16_t>(value << 8 | value >> 8);
}

std::array<float, kRawValues> depths_of_raw() {
  std::array<float, kRawValues> depths{};
  for (int raw = 0; raw < kNoRawMeasurement; ++raw) {
    const double angle = raw / 2842.5 + 1.1863;
    if (angle >= std::numbers::pi / 2) break;  // farther than infinity
    const double depth = 123.6 * portable_sin(angle) / portable_cos(angle);
    if (depth <= kFarthestMm) depths[static_cast<std::size_t>(raw)] = static_cast<float>(depth);
  }
  return depths;
}

const std::array<float, kRawValues>& raw_table() {
  static const std::array<float, kRawValues> table = depths_of_raw();
  return table;
}

/// The numbers of an image in one order of bytes.
struct KinectValues {
  std::uint16_t highest = 0;
  std::int64_t zeros = 0;
  std::int64_t marks = 0;  ///< values 2047
};

KinectValues values_of(const Image<std::uint16_t>& stored, bool is_big_endian) {
  KinectValues values;
  for (const std::uint16_t pixel : stored.pixels()) {
    const std::uint16_t value = is_big_endian ? swapped(pixel) : pixel;
    values.highest = std::max(values.highest, value);
    values.zeros += value == 0 ? 1 : 0;
    values.marks += value == kNoRawMeasurement ? 1 : 0;
  }
  return values;
}

KinectDepthUnit unit_of(const KinectValues& values, std::string_view unit) {
  if (unit == "mm") return KinectDepthUnit::millimetre;
  if (unit == "raw") return KinectDepthUnit::raw;
  const bool is_mm = values.highest > kNoRawMeasurement || values.zeros > values.marks;
  return is_mm ? KinectDepthUnit::millimetre : KinectDepthUnit::raw;
}

}  // namespace

Camera kinect_camera() {
  return {CameraModel::projective, 640, 480, 594.214342, 591.040537, 339.307810, 242.739138, {}};
}

float depth_of_kinect_raw(std::uint16_t raw) {
  return raw < kRawValues ? raw_table()[raw] : 0.0f;
}

bool shows_kinect_format(const Image<std::uint16_t>& stored) {
  return std::ranges::any_of(stored.pixels(), [](std::uint16_t value) { return value != 0; });
}

KinectDepthFormat kinect_format_of(const Image<std::uint16_t>& stored, std::string_view unit,
                                   std::string_view where) {
  const std::uint16_t highest = unit == "raw" ? kNoRawMeasurement : kFarthestMm;
  for (const bool is_big_endian : {false, true}) {
    const KinectValues values = values_of(stored, is_big_endian);
    if (values.highest <= highest) return {unit_of(values, unit), is_big_endian};
  }
  fail("{}: not a Kinect's depth image: has values above {} in either order of bytes", where, highest);
}

Image<float> kinect_depth_mm(const Image<std::uint16_t>& stored, const KinectDepthFormat& format,
                             std::string_view where) {
  Image<std::uint16_t> counts = stored;
  if (format.is_big_endian) std::ranges::transform(counts.pixels(), counts.pixels().begin(), swapped);
  if (format.unit == KinectDepthUnit::millimetre) return depth_from_counts(counts, 1.0);
  Image<float> depth_mm(counts.width(), counts.height());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::uint16_t raw = counts.data()[i];
    if (raw >= kRawValues) fail("{}: has the raw depth {}, expected at most 2047", where, raw);
    depth_mm.data()[i] = raw_table()[raw];
  }
  return depth_mm;
}

}  // namespace knuckle
