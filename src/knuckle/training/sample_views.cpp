// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/sample_views.h"

namespace knuckle {

CubeSampleViews::CubeSampleViews(const CubeSamples& samples, const AugmentationOptions& augmentation)
    : samples_(samples), augmentation_(augmentation) {
  check_options(augmentation, "augmentation");
}

std::vector<std::int64_t> CubeSampleViews::input_shape() const {
  return {1, samples_.patch().size_px, samples_.patch().size_px};
}

std::vector<std::int64_t> CubeSampleViews::target_shape() const {
  return {samples_.joint_count(), 3};
}

void CubeSampleViews::view(std::int64_t index, Random& random, std::span<float> input,
                           std::span<float> target) const {
  const CubeViewer viewer(samples_);
  const CubeSample sample = samples_.sample(index);
  const RandomView seen = random_view(sample, samples_, augmentation_, random);
  viewer.view_pixels(sample, seen.view, seen.faults, random, input);
  viewer.view_joints(sample, seen.view, target);
}

}  // namespace knuckle
