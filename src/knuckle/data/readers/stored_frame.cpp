// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/stored_frame.h"

#include <cassert>
#include <cstring>
#include <type_traits>

#include "knuckle/camera/projection.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/h5_format.h"
#include "knuckle/storage/deflate.h"

namespace knuckle {
namespace {

/// What all frames have; their images follow.
struct Head {
  Camera camera;
  std::int8_t side;
  double time_s;
  std::int32_t sequence;
  std::array<float, std::size_t{kSupersetSize} * 3> joints_mm;
  std::array<std::uint64_t, 3> sizes;  ///< of depth, infrared, mask [bytes]
};
static_assert(std::is_trivially_copyable_v<Head>);

std::array<float, std::size_t{kSupersetSize} * 3> joints_in_camera(const Frame& frame) {
  const HandPose missing = HandPose::missing(superset_convention());
  const HandPose pose = frame.truth ? converted(*frame.truth, superset_convention()) : missing;
  const Projection projection(frame.camera);
  std::array<float, std::size_t{kSupersetSize} * 3> joints_mm;
  auto* value = joints_mm.begin();
  for (const ImagePoint& joint : pose.joints) {
    const Point3 point = joint.is_missing() ? Point3::Constant(kNaN) : projection.to_camera(joint);
    for (const double coordinate : point) *value++ = static_cast<float>(coordinate);
  }
  return joints_mm;
}

/// Low and high bytes are coded apart.
std::vector<std::uint8_t> chunk_of(const Image<std::uint16_t>& image) {
  return deflated(shuffled(image.pixels()));
}

}  // namespace

StoredFrame stored_frame(const Frame& frame, double depth_unit_mm, std::string_view where) {
  StoredFrame stored{frame.camera,
                     code_of(frame.side),
                     frame.time_s.value_or(kNaN),
                     frame.sequence,
                     joints_in_camera(frame),
                     {},
                     {},
                     {}};
  stored.depth = chunk_of(counts_from_depth(frame.depth_mm, depth_unit_mm, where));
  if (!frame.infrared.empty()) stored.infrared = chunk_of(frame.infrared);
  if (!frame.mask.empty()) stored.mask = deflated(mask_from_pixels(frame.mask).pixels());
  return stored;
}

std::vector<std::uint8_t> to_bytes(const StoredFrame& frame) {
  const Head head{frame.camera,    frame.side,
                  frame.time_s,    frame.sequence,
                  frame.joints_mm, {frame.depth.size(), frame.infrared.size(), frame.mask.size()}};
  std::vector<std::uint8_t> bytes(sizeof(head));
  std::memcpy(bytes.data(), &head, sizeof(head));
  for (const auto* image : {&frame.depth, &frame.infrared, &frame.mask})
    bytes.insert(bytes.end(), image->begin(), image->end());
  return bytes;
}

StoredFrame stored_frame_from(std::span<const std::uint8_t> bytes) {
  Head head{};
  assert(bytes.size() >= sizeof(head));
  std::memcpy(&head, bytes.data(), sizeof(head));
  StoredFrame frame{head.camera, head.side, head.time_s, head.sequence, head.joints_mm, {}, {}, {}};
  const std::uint8_t* place = bytes.data() + sizeof(head);
  std::size_t image = 0;
  for (auto* pixels : {&frame.depth, &frame.infrared, &frame.mask}) {
    pixels->assign(place, place + head.sizes[image]);
    place += head.sizes[image++];
  }
  return frame;
}

}  // namespace knuckle
