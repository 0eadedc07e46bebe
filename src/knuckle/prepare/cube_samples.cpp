// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/cube_samples.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

std::uint8_t code_of_depth(float d) {
  if (d >= kCubeBackground) return CubeSamples::kBackgroundCode;
  return static_cast<std::uint8_t>(std::lround(127.0f + 127.0f * std::clamp(d, -1.0f, 1.0f)));
}

}  // namespace

CubeSamples::CubeSamples(std::int64_t count, int joint_count, const Cube& patch, int crop_px)
    : joint_count_(joint_count), patch_(patch), crop_px_(crop_px) {
  if (crop_px < patch.size_px) {
    fail("training samples: crops of {} px are smaller than the patches of {} px", crop_px, patch.size_px);
  }
  const auto places = static_cast<std::size_t>(count);
  codes_.resize(places * pixels());
  joints_.resize(places * numbers());
  centres_mm_.resize(places, Point3::Zero());
  is_set_.resize(places, 0);
}

std::int64_t CubeSamples::bytes(std::int64_t count, int joint_count, int crop_px) {
  const std::int64_t joints = std::int64_t{joint_count} * 3 * std::int64_t{sizeof(float)};
  return count * (std::int64_t{crop_px} * crop_px + joints + std::int64_t{sizeof(Point3)} + 9);
}

void CubeSamples::set(std::int64_t index, const HandPatch& crop, std::span<const PatchPoint> joints,
                      const Point3& centre_mm) {
  if (crop.pixels.width() != crop_px_ || crop.pixels.height() != crop_px_) {
    fail("training sample {}: a crop of {} x {}, expected {} x {}", index, crop.pixels.width(),
         crop.pixels.height(), crop_px_, crop_px_);
  }
  if (std::ssize(joints) != joint_count_) {
    fail("training sample {}: {} joints, expected {}", index, joints.size(), joint_count_);
  }
  const auto place = static_cast<std::size_t>(index);
  std::ranges::transform(crop.pixels.pixels(), codes_.data() + place * pixels(), code_of_depth);
  const double half_px = 0.5 * (crop_px_ - 1);
  float* to = joints_.data() + place * numbers();
  for (const PatchPoint& joint : joints) {
    *to++ = static_cast<float>(joint.u * half_px);
    *to++ = static_cast<float>(joint.v * half_px);
    *to++ = static_cast<float>(joint.d);
  }
  centres_mm_[place] = centre_mm;
  is_set_[place] = 1;
}

void CubeSamples::set(std::int64_t index, const CubeSample& sample) {
  if (sample.codes.size() != pixels() || sample.joints.size() != numbers()) {
    fail("training sample {}: {} pixels and {} numbers of joints, expected {} and {}", index,
         sample.codes.size(), sample.joints.size(), pixels(), numbers());
  }
  const auto place = static_cast<std::size_t>(index);
  std::ranges::copy(sample.codes, codes_.data() + place * pixels());
  std::ranges::copy(sample.joints, joints_.data() + place * numbers());
  centres_mm_[place] = sample.centre_mm;
  is_set_[place] = 1;
}

void CubeSamples::finish() {
  kept_.clear();
  for (std::int64_t i = 0; i < std::ssize(is_set_); ++i) {
    if (is_set_[static_cast<std::size_t>(i)] != 0) kept_.push_back(i);
  }
}

CubeSample CubeSamples::sample(std::int64_t index) const {
  const auto place = static_cast<std::size_t>(kept_[static_cast<std::size_t>(index)]);
  return {std::span(codes_).subspan(place * pixels(), pixels()),
          std::span(joints_).subspan(place * numbers(), numbers()), centres_mm_[place]};
}

std::vector<bool> known_joints(const CubeSamples& samples) {
  std::vector<bool> known(static_cast<std::size_t>(samples.joint_count()), false);
  for (std::int64_t i = 0; i < samples.size(); ++i) {
    const std::span<const float> joints = samples.sample(i).joints;
    for (std::size_t j = 0; j < known.size(); ++j) {
      if (std::isfinite(joints[3 * j] + joints[3 * j + 1] + joints[3 * j + 2])) known[j] = true;
    }
  }
  return known;
}

}  // namespace knuckle
