// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/sample_views.h"

#include <algorithm>
#include <utility>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

void reverse_rows(std::span<float> pixels, int row_length) {
  const auto row = static_cast<std::size_t>(row_length);
  for (std::size_t first = 0; first < pixels.size(); first += row)
    std::ranges::reverse(pixels.subspan(first, row));
}

bool are_of_same_sizes(const CubeSamples& a, const CubeSamples& b) {
  return a.crop_px() == b.crop_px() && a.joint_count() == b.joint_count() &&
         a.patch().size_px == b.patch().size_px && a.patch().side_mm == b.patch().side_mm;
}

std::int64_t things_of(const std::vector<TrainingCrops>& sets) {
  std::int64_t things = 0;
  for (const TrainingCrops& set : sets) things += set.size() - set.hands.size();
  return things;
}

}  // namespace

CropViews::CropViews(const AugmentationOptions& augmentation, const PatchQuestions& questions,
                     std::int64_t things)
    : augmentation_(augmentation), questions_(questions) {
  check_options(augmentation, "augmentation");
  if (questions.side != (augmentation.mirrored_share > 0.0)) {
    fail(
        "augmentation: mirrored_share is {}, and [network] tells_side is {}: sides are learned from views in "
        "a mirror, "
        "and only by a network that tells them",
        augmentation.mirrored_share, questions.side);
  }
  if (questions.hand != (things > 0)) {
    fail(
        "samples: there are {} things, and [network] tells_hand is {}: what is no hand is learned from "
        "things, "
        "and only by a network that tells it",
        things, questions.hand);
  }
}

std::vector<std::int64_t> CropViews::input_shape(const CubeSamples& sizes) const {
  return {1, sizes.patch().size_px, sizes.patch().size_px};
}

std::vector<std::int64_t> CropViews::target_shape(const CubeSamples& sizes) const {
  return {sizes.joint_count() + (questions_.side ? 1 : 0) + (questions_.hand ? 1 : 0), 3};
}

void CropViews::view(const CubeSample& sample, const CubeSamples& sizes, bool is_hand, Random& random,
                     std::span<float> input, std::span<float> target) const {
  const CubeViewer viewer(sizes);
  const RandomView seen = random_view(sample, sizes, augmentation_, random);
  viewer.view_pixels(sample, seen.view, seen.faults, random, input);
  const std::span<float> joints = target.first(static_cast<std::size_t>(3 * sizes.joint_count()));
  viewer.view_joints(sample, seen.view, joints);
  std::span<float> answers = target.subspan(joints.size());
  const bool is_mirrored = questions_.side && random.uniform() < augmentation_.mirrored_share;
  if (is_mirrored) {
    std::ranges::fill(joints, static_cast<float>(kNaN));
    reverse_rows(input, sizes.patch().size_px);
  }
  if (questions_.side) {
    const float is_right = is_mirrored ? 0.0f : 1.0f;
    std::ranges::fill(answers.first(3), is_hand ? is_right : static_cast<float>(kNaN));
    answers = answers.subspan(3);
  }
  if (questions_.hand) std::ranges::fill(answers.first(3), is_hand ? 1.0f : 0.0f);
}

CubeSampleViews::CubeSampleViews(std::vector<TrainingCrops> sets, const AugmentationOptions& augmentation,
                                 const PatchQuestions& questions)
    : sets_(std::move(sets)), views_(augmentation, questions, things_of(sets_)) {
  if (sets_.empty()) fail("training: there is no sample to train on");
  for (const TrainingCrops& set : sets_) {
    if (set.hands.size() == 0) fail("training: there is no sample to train on");
    for (const CubeSamples* const samples : {&set.hands, set.things}) {
      if (samples != nullptr && !are_of_same_sizes(*samples, sets_.front().hands))
        fail("samples: things and hands, or sets, are of different sizes");
    }
  }
}

std::int64_t CubeSampleViews::size() const {
  std::int64_t sum = 0;
  for (const TrainingCrops& set : sets_) sum += set.size();
  return sum;
}

std::vector<SampleGroup> CubeSampleViews::groups() const {
  std::vector<SampleGroup> groups;
  for (const TrainingCrops& set : sets_) groups.push_back({set.size(), set.weight});
  return groups;
}

std::vector<std::int64_t> CubeSampleViews::input_shape() const {
  return views_.input_shape(sets_.front().hands);
}

std::vector<std::int64_t> CubeSampleViews::target_shape() const {
  return views_.target_shape(sets_.front().hands);
}

void CubeSampleViews::view(std::int64_t index, Random& random, std::span<float> input,
                           std::span<float> target) const {
  std::size_t set = 0;
  while (index >= sets_[set].size()) index -= sets_[set++].size();
  const bool is_hand = index < sets_[set].hands.size();
  const CubeSamples& samples = is_hand ? sets_[set].hands : *sets_[set].things;
  views_.view(samples.sample(is_hand ? index : index - sets_[set].hands.size()), samples, is_hand, random,
              input, target);
}

}  // namespace knuckle
