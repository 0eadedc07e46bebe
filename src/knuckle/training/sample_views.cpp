// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/sample_views.h"

#include <algorithm>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

void reverse_rows(std::span<float> pixels, int row_length) {
  const auto row = static_cast<std::size_t>(row_length);
  for (std::size_t first = 0; first < pixels.size(); first += row)
    std::ranges::reverse(pixels.subspan(first, row));
}

}  // namespace

CubeSampleViews::CubeSampleViews(const TrainingCrops& crops, const AugmentationOptions& augmentation,
                                 const PatchQuestions& questions)
    : crops_(crops), augmentation_(augmentation), questions_(questions) {
  check_options(augmentation, "augmentation");
  if (questions.side != (augmentation.mirrored_share > 0.0)) {
    fail(
        "augmentation: mirrored_share is {}, and [network] tells_side is {}: sides are learned from views in "
        "a mirror, "
        "and only by a network that tells them",
        augmentation.mirrored_share, questions.side);
  }
  const std::int64_t things = crops.things == nullptr ? 0 : crops.things->size();
  if (questions.hand != (things > 0)) {
    fail(
        "samples: there are {} things, and [network] tells_hand is {}: what is no hand is learned from "
        "things, "
        "and only by a network that tells it",
        things, questions.hand);
  }
  if (things > 0 && (crops.things->crop_px() != crops.hands.crop_px() ||
                     crops.things->joint_count() != crops.hands.joint_count())) {
    fail("samples: things and hands are of different sizes");
  }
}

std::int64_t CubeSampleViews::size() const {
  return crops_.hands.size() + (crops_.things == nullptr ? 0 : crops_.things->size());
}

std::vector<std::int64_t> CubeSampleViews::input_shape() const {
  return {1, crops_.hands.patch().size_px, crops_.hands.patch().size_px};
}

std::vector<std::int64_t> CubeSampleViews::target_shape() const {
  return {crops_.hands.joint_count() + (questions_.side ? 1 : 0) + (questions_.hand ? 1 : 0), 3};
}

void CubeSampleViews::view(std::int64_t index, Random& random, std::span<float> input,
                           std::span<float> target) const {
  const bool is_hand = index < crops_.hands.size();
  const CubeSamples& samples = is_hand ? crops_.hands : *crops_.things;
  const CubeViewer viewer(samples);
  const CubeSample sample = samples.sample(is_hand ? index : index - crops_.hands.size());
  const RandomView seen = random_view(sample, samples, augmentation_, random);
  viewer.view_pixels(sample, seen.view, seen.faults, random, input);
  const std::span<float> joints = target.first(static_cast<std::size_t>(3 * samples.joint_count()));
  viewer.view_joints(sample, seen.view, joints);
  std::span<float> answers = target.subspan(joints.size());
  const bool is_mirrored = questions_.side && random.uniform() < augmentation_.mirrored_share;
  if (is_mirrored) {
    std::ranges::fill(joints, static_cast<float>(kNaN));
    reverse_rows(input, samples.patch().size_px);
  }
  if (questions_.side) {
    const float is_right = is_mirrored ? 0.0f : 1.0f;
    std::ranges::fill(answers.first(3), is_hand ? is_right : static_cast<float>(kNaN));
    answers = answers.subspan(3);
  }
  if (questions_.hand) std::ranges::fill(answers.first(3), is_hand ? 1.0f : 0.0f);
}

}  // namespace knuckle
