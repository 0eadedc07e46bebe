// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/frame_sums.h"

#include <span>
#include <type_traits>

#include "knuckle/storage/content_hash.h"

namespace knuckle {
namespace {

/// The sum of a value that follows others, whose sum is `before`.
template <class T>
requires std::is_arithmetic_v<T> std::uint64_t sum_after(std::uint64_t before, T value) {
  return content_sum(std::as_bytes(std::span(&value, 1)), before);
}

/// The same of many values, which lie side by side.
template <class Values>
std::uint64_t sum_after_all(std::uint64_t before, const Values& values) {
  return content_sum(std::as_bytes(std::span(values)), before);
}

std::uint64_t sum_after(std::uint64_t before, const IndexRange& range) {
  return sum_after(sum_after(before, range.first), range.count);
}

std::uint64_t sum_after(std::uint64_t before, const StoredHand& hand) {
  std::uint64_t sum = sum_after(before, hand.side);
  sum = sum_after_all(sum, hand.occluders);
  sum = sum_after_all(sum, hand.joints_mm);
  return sum_after(sum, hand.visible_share);
}

}  // namespace

std::uint64_t sum_of_facts(const H5Facts& facts) {
  const Camera& camera = facts.camera;
  std::uint64_t sum = sum_after(0, facts.depth_unit_mm);
  sum = sum_after(sum, static_cast<std::int32_t>(camera.model));
  sum = sum_after(sum, std::int32_t{camera.width});
  sum = sum_after(sum, std::int32_t{camera.height});
  sum = sum_after_all(sum, camera.distortion);
  sum = sum_after_all(sum, facts.manifest);
  sum = sum_after_all(sum, facts.generator);
  return facts.part_of ? sum_after(sum, *facts.part_of) : sum;
}

std::uint64_t sum_of_numbers(const StoredFrame& frame, std::int64_t number, std::uint64_t facts) {
  std::uint64_t sum = sum_after(facts, number);
  for (const double intrinsic : {frame.camera.fx, frame.camera.fy, frame.camera.cx, frame.camera.cy})
    sum = sum_after(sum, intrinsic);
  sum = sum_after(sum, frame.side);
  sum = sum_after(sum, frame.time_s);
  sum = sum_after(sum, frame.sequence);
  sum = sum_after_all(sum, frame.joints_mm);
  for (const StoredHand& hand : frame.hands) sum = sum_after(sum, hand);
  return sum;
}

std::uint64_t sum_of_images(const StoredImages& images) {
  std::uint64_t sum = sum_after_all(0, images.depth.pixels());
  sum = sum_after_all(sum, images.infrared.pixels());
  sum = sum_after_all(sum, images.mask.pixels());
  return sum_after_all(sum, images.labels.pixels());
}

}  // namespace knuckle
