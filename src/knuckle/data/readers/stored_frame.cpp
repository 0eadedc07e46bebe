// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/stored_frame.h"

#include <cstring>
#include <type_traits>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/limits.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/frame_sums.h"
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
  std::array<std::uint64_t, 4> sizes;  ///< of depth, infrared, mask, labels [bytes]
  std::uint64_t images_sum;
  std::uint64_t hands;  ///< their number; they follow the images
};
static_assert(std::is_trivially_copyable_v<Head> && std::is_trivially_copyable_v<StoredHand>);

std::array<float, std::size_t{kSupersetSize} * 3> joints_in_camera(const HandPose& truth,
                                                                   const Projection& projection) {
  const HandPose pose = converted(truth, superset_convention());
  std::array<float, std::size_t{kSupersetSize} * 3> joints_mm;
  auto* value = joints_mm.begin();
  for (const ImagePoint& joint : pose.joints) {
    const Point3 point = joint.is_missing() ? Point3::Constant(kNaN) : projection.to_camera(joint);
    for (const double coordinate : point) *value++ = static_cast<float>(coordinate);
  }
  return joints_mm;
}

StoredHand stored_hand(const HandTruth& hand, const Projection& projection) {
  StoredHand stored;
  stored.side = code_of(hand.side);
  stored.joints_mm = joints_in_camera(hand.pose, projection);
  stored.visible_share = hand.visible_share;
  const std::vector<int> places = map_convention(hand.pose.convention, superset_convention()).source_index;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool is_known = places[i] >= 0 && places[i] < std::ssize(hand.occluders);
    if (is_known)
      stored.occluders[i] = static_cast<std::uint8_t>(hand.occluders[static_cast<std::size_t>(places[i])]);
  }
  return stored;
}

/// A log may come from elsewhere.
void check_head(const Head& head, std::string_view where) {
  const bool is_model =
      head.camera.model == CameraModel::projective || head.camera.model == CameraModel::orthographic;
  if (!is_model || head.hands > static_cast<std::uint64_t>(limits::kHands))
    fail("{}: the record of the frame is damaged", where);
  try {
    check(head.camera);
  } catch (const Error& error) {
    fail("{}: the record of the frame is damaged: {}", where, error.what());
  }
}

/// Counts with low and high bytes apart, deflated; nothing where there is no image.
std::vector<std::uint8_t> chunk_of(const Image<std::uint16_t>& counts) {
  if (counts.empty()) return {};
  return deflated(shuffled(counts.pixels()));
}

std::vector<std::uint8_t> chunk_of(const Image<std::uint8_t>& pixels) {
  if (pixels.empty()) return {};
  return deflated(pixels.pixels());
}

StoredImages stored_images(const Frame& frame, double depth_unit_mm, std::string_view where) {
  StoredImages images{.depth = counts_from_depth(frame.depth_mm, depth_unit_mm, where),
                      .infrared = frame.infrared,
                      .labels = frame.labels};
  if (!frame.mask.empty()) images.mask = mask_from_pixels(frame.mask);
  return images;
}

}  // namespace

void pack(const StoredImages& images, StoredFrame& frame) {
  frame.depth = chunk_of(images.depth);
  frame.infrared = chunk_of(images.infrared);
  frame.mask = chunk_of(images.mask);
  frame.labels = chunk_of(images.labels);
  frame.images_sum = sum_of_images(images);
}

StoredFrame stored_frame(const Frame& frame, double depth_unit_mm, std::string_view where) {
  const Projection projection(frame.camera);
  StoredFrame stored;
  stored.camera = frame.camera;
  stored.side = code_of(frame.side);
  stored.time_s = frame.time_s.value_or(kNaN);
  stored.sequence = frame.sequence;
  stored.joints_mm =
      joints_in_camera(frame.truth.value_or(HandPose::missing(superset_convention())), projection);
  pack(stored_images(frame, depth_unit_mm, where), stored);
  for (const HandTruth& hand : frame.hands) stored.hands.push_back(stored_hand(hand, projection));
  return stored;
}

std::vector<std::uint8_t> to_bytes(const StoredFrame& frame) {
  const Head head{
      frame.camera,     frame.side,
      frame.time_s,     frame.sequence,
      frame.joints_mm,  {frame.depth.size(), frame.infrared.size(), frame.mask.size(), frame.labels.size()},
      frame.images_sum, frame.hands.size()};
  std::vector<std::uint8_t> bytes(sizeof(head));
  std::memcpy(bytes.data(), &head, sizeof(head));
  for (const auto* image : {&frame.depth, &frame.infrared, &frame.mask, &frame.labels})
    bytes.insert(bytes.end(), image->begin(), image->end());
  const auto* const hands = reinterpret_cast<const std::uint8_t*>(frame.hands.data());
  bytes.insert(bytes.end(), hands, hands + frame.hands.size() * sizeof(StoredHand));
  return bytes;
}

StoredFrame stored_frame_from(std::span<const std::uint8_t> bytes, std::string_view where) {
  const auto take = [&](std::uint64_t count) {
    if (count > bytes.size()) fail("{}: the record of the frame is damaged: it ends too early", where);
    const auto taken = bytes.first(static_cast<std::size_t>(count));
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    return taken;
  };
  Head head{};
  std::memcpy(&head, take(sizeof(head)).data(), sizeof(head));
  check_head(head, where);
  StoredFrame frame{.camera = head.camera,
                    .side = head.side,
                    .time_s = head.time_s,
                    .sequence = head.sequence,
                    .joints_mm = head.joints_mm,
                    .images_sum = head.images_sum};
  std::size_t image = 0;
  for (auto* pixels : {&frame.depth, &frame.infrared, &frame.mask, &frame.labels}) {
    const auto taken = take(head.sizes[image++]);
    pixels->assign(taken.begin(), taken.end());
  }
  frame.hands.resize(head.hands);
  const auto hands = take(head.hands * sizeof(StoredHand));
  if (!hands.empty()) std::memcpy(frame.hands.data(), hands.data(), hands.size());
  if (!bytes.empty()) fail("{}: the record of the frame is damaged: something follows it", where);
  return frame;
}

}  // namespace knuckle
