// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/batch_loader.h"

#include <algorithm>
#include <functional>
#include <future>
#include <numeric>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/pipeline/stopwatch.h"

namespace knuckle {
namespace {

constexpr std::size_t kBatchesAhead = 8;
// Streams of random numbers: one family for orders, one for views.
constexpr std::uint64_t kOrders = 1;
constexpr std::uint64_t kViews = 2;

/// Numbers in an array of that shape.
std::size_t count_of(const std::vector<std::int64_t>& shape) {
  return static_cast<std::size_t>(
      std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, std::multiplies<>()));
}

std::vector<double> weights_of(const std::vector<SampleGroup>& groups) {
  std::vector<double> weights;
  for (const SampleGroup& group : groups) weights.push_back(group.weight);
  return weights;
}

}  // namespace

BatchPlan::BatchPlan(std::shared_ptr<const SampleViews> samples, int batch_size, std::uint64_t seed)
    : samples_(std::move(samples)),
      batch_size_(batch_size),
      end_(batch_size),
      seed_(seed),
      dealer_(weights_of(samples_->groups())) {
  const std::uint64_t orders = derived_seed(seed, kOrders);
  std::int64_t first = 0;
  for (SampleGroup& group : samples_->groups()) {
    const std::size_t number = orders_.size();
    first_of_group_.push_back(first);
    first += group.size;
    orders_.emplace_back(std::move(group), number == 0 ? orders : derived_seed(orders, number));
  }
}

std::int64_t BatchPlan::sample_of(std::int64_t place) {
  const SampleDealer::Dealt dealt = dealer_.at(place);
  return first_of_group_[dealt.group] + orders_[dealt.group].at(dealt.number);
}

BatchPlan BatchPlan::part(int begin, int end) const {
  BatchPlan part = *this;
  part.begin_ = begin;
  part.end_ = end;
  return part;
}

std::int64_t BatchPlan::most_at_once() const {
  return std::max<std::int64_t>(1, samples_->most_at_once() / (end_ - begin_));
}

BatchSamples BatchPlan::fetched(std::int64_t first, std::int64_t end) {
  BatchSamples samples{first, end, {}, nullptr};
  for (std::int64_t number = first; number < end; ++number) {
    for (int i = begin_; i < end_; ++i) samples.numbers.push_back(sample_of(number * batch_size_ + i));
  }
  samples.views = samples_->fetched(samples.numbers);
  if (samples.views == nullptr) samples.views = samples_;
  return samples;
}

TrainingBatch BatchPlan::batch(std::int64_t number, const BatchSamples& samples) const {
  TrainingBatch batch{{}, {}, samples_->input_shape(), samples_->target_shape()};
  const std::size_t pixels = count_of(batch.input_shape);
  const std::size_t numbers = count_of(batch.target_shape);
  const int count = end_ - begin_;
  batch.inputs.resize(pixels * count);
  batch.targets.resize(numbers * count);
  for (int i = 0; i < count; ++i) {
    const auto place = static_cast<std::uint64_t>(number * batch_size_ + begin_ + i);
    Random random(derived_seed(seed_, kViews), place);
    const std::int64_t sample =
        samples.numbers[static_cast<std::size_t>((number - samples.first) * count + i)];
    samples.views->view(sample, random, std::span(batch.inputs).subspan(pixels * i, pixels),
                        std::span(batch.targets).subspan(numbers * i, numbers));
  }
  return batch;
}

BatchLoader::BatchLoader(BatchPlan plan, std::int64_t first, std::int64_t end)
    : plan_(std::move(plan)), left_(end - first), thread_([this, first, end] { work(first, end); }) {}

BatchLoader::~BatchLoader() {
  const std::lock_guard lock(mutex_);
  stop_ = true;
  changed_.notify_all();
}

void BatchLoader::work(std::int64_t first, std::int64_t end) {
  try {
    fetch_and_make(first, end);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    fault_ = std::current_exception();
    changed_.notify_all();
  }
}

void BatchLoader::fetch_and_make(std::int64_t first, std::int64_t end) {
  const std::int64_t at_once = plan_.most_at_once();
  BatchPlan fetching = plan_;  // of the thread that fetches, one at a time
  const auto fetch = [&fetching, at_once, end](std::int64_t from) {
    return std::async(std::launch::async, [&fetching, from, to = std::min(end, from + at_once)] {
      return fetching.fetched(from, to);
    });
  };
  std::future<BatchSamples> next = fetch(first);
  for (std::int64_t number = first; number < end;) {
    const BatchSamples samples = next.get();
    if (samples.end < end) next = fetch(samples.end);
    for (; number < samples.end; ++number) {
      if (!hand_over(plan_.batch(number, samples))) return;
    }
  }
}

bool BatchLoader::hand_over(TrainingBatch batch) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return stop_ || ready_.size() < kBatchesAhead; });
  if (stop_) return false;
  ready_.push_back(std::move(batch));
  changed_.notify_all();
  return true;
}

TrainingBatch BatchLoader::next() {
  if (left_ <= 0) fail("training: there is no batch left");
  const Stopwatch watch;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !ready_.empty() || fault_; });
  waited_seconds_ += watch.seconds();
  if (ready_.empty()) std::rethrow_exception(fault_);
  TrainingBatch batch = std::move(ready_.front());
  ready_.pop_front();
  --left_;
  changed_.notify_all();
  return batch;
}

}  // namespace knuckle
