// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/ros1_messages.h"

#include "knuckle/core/error.h"
#include "knuckle/data/readers/byte_cursor.h"

namespace knuckle {
namespace {

double take_stamp(ByteCursor& cursor) {
  cursor.skip(4);  // the message's number
  const std::uint32_t seconds = cursor.u32();
  const std::uint32_t nanoseconds = cursor.u32();
  return seconds + 1e-9 * nanoseconds;
}

/// Its stamp; the name of the frame of reference is passed over.
double take_header(ByteCursor& cursor) {
  const double stamp_s = take_stamp(cursor);
  cursor.skip(cursor.u32());
  return stamp_s;
}

std::vector<double> take_doubles(ByteCursor& cursor) {
  const std::uint32_t count = cursor.u32();
  ByteCursor numbers(cursor.take(std::uint64_t{8} * count), cursor.where());
  std::vector<double> values(count);
  for (double& value : values) value = numbers.f64();
  return values;
}

}  // namespace

double parse_ros1_stamp(std::span<const std::uint8_t> message, std::string_view where) {
  ByteCursor cursor(message, where);
  return take_stamp(cursor);
}

RosImage parse_ros1_image(std::span<const std::uint8_t> message, std::string_view where) {
  ByteCursor cursor(message, where);
  RosImage image;
  image.stamp_s = take_header(cursor);
  image.height = cursor.u32();
  image.width = cursor.u32();
  image.encoding = cursor.text(cursor.u32());
  image.is_big_endian = cursor.u8() != 0;
  image.step = cursor.u32();
  image.pixels = cursor.take(cursor.u32());
  return image;
}

RosCameraInfo parse_ros1_camera_info(std::span<const std::uint8_t> message, std::string_view where) {
  constexpr std::uint64_t kRotationBytes = 9 * 8;
  ByteCursor cursor(message, where);
  RosCameraInfo info;
  take_header(cursor);
  info.height = cursor.u32();
  info.width = cursor.u32();
  info.distortion_model = cursor.text(cursor.u32());
  info.d = take_doubles(cursor);
  for (double& value : info.k) value = cursor.f64();
  cursor.skip(kRotationBytes);
  for (double& value : info.p) value = cursor.f64();
  return info;
}

float parse_ros1_float(std::span<const std::uint8_t> message, std::string_view where) {
  return ByteCursor(message, where).f32();
}

}  // namespace knuckle
