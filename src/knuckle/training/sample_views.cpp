// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/sample_views.h"

#include <algorithm>

#include "knuckle/core/error.h"

namespace knuckle {

CubeSampleViews::CubeSampleViews(const CubeSamples& samples, const AugmentationOptions& augmentation,
                                 bool tells_side)
    : samples_(samples), augmentation_(augmentation), tells_side_(tells_side) {
  check_options(augmentation, "augmentation");
  if (tells_side != (augmentation.mirrored_share > 0.0)) {
    fail(
        "augmentation: mirrored_share is {}, and [network] tells_side is {}: sides are learned from views in "
        "a mirror, "
        "and only by a network that tells them",
        augmentation.mirrored_share, tells_side);
  }
}

std::vector<std::int64_t> CubeSampleViews::input_shape() const {
  return {1, samples_.patch().size_px, samples_.patch().size_px};
}

std::vector<std::int64_t> CubeSampleViews::target_shape() const {
  return {samples_.joint_count() + (tells_side_ ? 1 : 0), 3};
}

void CubeSampleViews::view(std::int64_t index, Random& random, std::span<float> input,
                           std::span<float> target) const {
  const CubeViewer viewer(samples_);
  const CubeSample sample = samples_.sample(index);
  const RandomView seen = random_view(sample, samples_, augmentation_, random);
  viewer.view_pixels(sample, seen.view, seen.faults, random, input);
  const auto joint_numbers = static_cast<std::size_t>(3 * samples_.joint_count());
  viewer.view_joints(sample, seen.view, target.first(joint_numbers));
  if (!tells_side_) return;
  const bool is_mirrored = random.uniform() < augmentation_.mirrored_share;
  std::ranges::fill(target.subspan(joint_numbers), is_mirrored ? 0.0f : 1.0f);
  if (!is_mirrored) return;
  std::ranges::fill(target.first(joint_numbers), static_cast<float>(kNaN));
  const auto row = static_cast<std::size_t>(samples_.patch().size_px);
  for (std::size_t first = 0; first < input.size(); first += row)
    std::ranges::reverse(input.subspan(first, row));
}

}  // namespace knuckle
