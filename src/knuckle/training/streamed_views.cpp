// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/streamed_views.h"

#include <algorithm>
#include <array>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/training/fetched_numbers.h"

namespace knuckle {
namespace {

/// Where no set lies in several runs, as those that are cut out anew, nothing is gained by more.
constexpr std::int64_t kMostWithoutRuns = 1024;

std::int64_t things_of(const std::vector<StreamedCrops>& sets) {
  std::int64_t things = 0;
  for (const StreamedCrops& set : sets) things += set.size() - set.hands->size();
  return things;
}

/// Room for no sample, of the sizes of all.
CubeSamples sizes_of(const std::vector<StreamedCrops>& sets) {
  if (sets.empty()) fail("training: there is no sample to train on");
  return sets.front().hands->room_for(0);
}

bool are_of_same_sizes(const SampleStream& stream, const CubeSamples& sizes) {
  const CubeSamples own = stream.room_for(0);
  return own.crop_px() == sizes.crop_px() && own.joint_count() == sizes.joint_count() &&
         own.patch().size_px == sizes.patch().size_px && own.patch().side_mm == sizes.patch().side_mm;
}

}  // namespace

/// Some samples in memory.
class StreamedViews::Fetched final : public SampleViews {
 public:
  Fetched(const StreamedViews& all, std::span<const std::int64_t> indices)
      : views_(all.views_), numbers_(indices), samples_(all.sizes_), count_(all.count_) {
    count_->add(size());
    try {
      fetch(all);
    } catch (...) {
      count_->add(-size());
      throw;
    }
  }
  ~Fetched() override { count_->add(-size()); }
  Fetched(const Fetched&) = delete;
  Fetched& operator=(const Fetched&) = delete;

  std::int64_t size() const override { return numbers_.size(); }
  std::vector<std::int64_t> input_shape() const override { return views_.input_shape(samples_); }
  std::vector<std::int64_t> target_shape() const override { return views_.target_shape(samples_); }
  void view(std::int64_t index, Random& random, std::span<float> input,
            std::span<float> target) const override {
    const std::int64_t place = numbers_.place_of(index);
    views_.view(samples_.sample(place), samples_, is_hand_[static_cast<std::size_t>(place)], random, input,
                target);
  }

 private:
  void fetch(const StreamedViews& all) {
    samples_ = all.sets_.front().hands->room_for(size());
    std::vector<std::int64_t> in_part;
    for (const Part& part : all.parts_) {
      const std::int64_t place = std::ssize(is_hand_);
      in_part.clear();
      for (std::int64_t i = place; i < size() && numbers_[i] < part.first + part.stream->size(); ++i)
        in_part.push_back(numbers_[i] - part.first);
      part.stream->fetch(in_part, samples_, place);
      is_hand_.resize(is_hand_.size() + in_part.size(), part.is_hands);
    }
    samples_.finish();
    if (samples_.size() != size())
      fail("training: {} samples were fetched, expected {}", samples_.size(), size());
  }

  CropViews views_;
  FetchedNumbers numbers_;
  CubeSamples samples_;
  std::vector<bool> is_hand_;
  std::shared_ptr<Count> count_;
};

void StreamedViews::Count::add(std::int64_t samples) {
  const std::int64_t held = now += samples;
  std::int64_t before = most;
  while (before < held && !most.compare_exchange_weak(before, held)) continue;
}

StreamedViews::StreamedViews(std::vector<StreamedCrops> sets, const AugmentationOptions& augmentation,
                             const PatchQuestions& questions, const StreamingOptions& options)
    : sets_(std::move(sets)),
      views_(augmentation, questions, things_of(sets_)),
      options_(options),
      sizes_(sizes_of(sets_)) {
  std::int64_t first = 0;
  for (const StreamedCrops& set : sets_) {
    if (set.hands->size() == 0) fail("training: there is no sample to train on");
    for (const SampleStream* const stream : std::array{set.hands.get(), set.things.get()}) {
      if (stream == nullptr) continue;
      if (!are_of_same_sizes(*stream, sizes_))
        fail("samples: things and hands, or sets, are of different sizes");
      parts_.push_back({stream, first, stream == set.hands.get()});
      first += stream->size();
    }
  }
  const bool has_runs =
      std::ranges::any_of(parts_, [](const Part& part) { return part.stream->runs().size() > 1; });
  if (!has_runs) options_.most_at_once = std::min(options_.most_at_once, kMostWithoutRuns);
}

std::int64_t StreamedViews::size() const {
  std::int64_t sum = 0;
  for (const StreamedCrops& set : sets_) sum += set.size();
  return sum;
}

std::vector<SampleGroup> StreamedViews::groups() const {
  std::vector<SampleGroup> groups;
  for (const StreamedCrops& set : sets_) {
    SampleGroup group{set.size(), set.weight, set.hands->runs(), options_.window};
    if (set.things != nullptr)
      group.runs.insert(group.runs.end(), set.things->runs().begin(), set.things->runs().end());
    groups.push_back(std::move(group));
  }
  return groups;
}

void StreamedViews::view(std::int64_t index, Random& random, std::span<float> input,
                         std::span<float> target) const {
  fetched(std::span(&index, 1))->view(index, random, input, target);
}

std::shared_ptr<const SampleViews> StreamedViews::fetched(std::span<const std::int64_t> indices) const {
  return std::make_shared<const Fetched>(*this, indices);
}

}  // namespace knuckle
