// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/ros2_messages.h"

#include "knuckle/core/error.h"
#include "knuckle/data/readers/cdr_cursor.h"

namespace knuckle {
namespace {

double take_stamp(CdrCursor& cursor) {
  const auto seconds = static_cast<std::int32_t>(cursor.u32());
  const std::uint32_t nanoseconds = cursor.u32();
  return seconds + 1e-9 * nanoseconds;
}

/// Its stamp; the name of the frame of reference is passed over.
double take_header(CdrCursor& cursor) {
  const double stamp_s = take_stamp(cursor);
  cursor.text();
  return stamp_s;
}

std::vector<double> take_doubles(CdrCursor& cursor, std::string_view where) {
  const std::uint32_t count = cursor.u32();
  if (count > cursor.left() / sizeof(double)) {
    fail("{}: is cut short: {} numbers in {} bytes", where, count, cursor.left());
  }
  std::vector<double> values(count);
  for (double& value : values) value = cursor.f64();
  return values;
}

}  // namespace

double parse_ros2_stamp(std::span<const std::uint8_t> message, std::string_view where) {
  CdrCursor cursor(message, where);
  return take_stamp(cursor);
}

RosImage parse_ros2_image(std::span<const std::uint8_t> message, std::string_view where) {
  CdrCursor cursor(message, where);
  RosImage image;
  image.stamp_s = take_header(cursor);
  image.height = cursor.u32();
  image.width = cursor.u32();
  image.encoding = cursor.text();
  image.is_big_endian = cursor.u8() != 0;
  image.step = cursor.u32();
  image.pixels = cursor.take(cursor.u32());
  return image;
}

RosCameraInfo parse_ros2_camera_info(std::span<const std::uint8_t> message, std::string_view where) {
  CdrCursor cursor(message, where);
  RosCameraInfo info;
  take_header(cursor);
  info.height = cursor.u32();
  info.width = cursor.u32();
  info.distortion_model = cursor.text();
  info.d = take_doubles(cursor, where);
  for (double& value : info.k) value = cursor.f64();
  for (int i = 0; i < 9; ++i) cursor.f64();  // the rotation that rectifies
  for (double& value : info.p) value = cursor.f64();
  return info;
}

}  // namespace knuckle
