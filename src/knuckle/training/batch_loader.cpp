// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/batch_loader.h"

#include <functional>
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

/// A random order of [0, count) (Fisher and Yates).
std::vector<std::int64_t> random_order(std::int64_t count, Random random) {
  std::vector<std::int64_t> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), std::int64_t{0});
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
  }
  return order;
}

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
  std::int64_t first = 0;
  for (const SampleGroup& group : samples_->groups()) {
    if (group.size == 0) fail("training: there is no sample to train on");
    decks_.push_back({.first = first, .size = group.size, .epoch = -1, .order = {}});
    first += group.size;
  }
}

std::int64_t BatchPlan::sample_of(std::int64_t place) {
  const SampleDealer::Dealt dealt = dealer_.at(place);
  Deck& deck = decks_[dealt.group];
  const std::int64_t epoch = dealt.number / deck.size;
  if (epoch != deck.epoch) {
    const std::uint64_t orders = derived_seed(seed_, kOrders);
    const std::uint64_t of_group = dealt.group == 0 ? orders : derived_seed(orders, dealt.group);
    deck.order = random_order(deck.size, Random(of_group, static_cast<std::uint64_t>(epoch)));
    deck.epoch = epoch;
  }
  return deck.first + deck.order[static_cast<std::size_t>(dealt.number % deck.size)];
}

BatchPlan BatchPlan::part(int begin, int end) const {
  BatchPlan part = *this;
  part.begin_ = begin;
  part.end_ = end;
  return part;
}

TrainingBatch BatchPlan::batch(std::int64_t number) {
  TrainingBatch batch{{}, {}, samples_->input_shape(), samples_->target_shape()};
  const std::size_t pixels = count_of(batch.input_shape);
  const std::size_t numbers = count_of(batch.target_shape);
  const int count = end_ - begin_;
  batch.inputs.resize(pixels * count);
  batch.targets.resize(numbers * count);
  for (int i = 0; i < count; ++i) {
    const std::int64_t place = number * batch_size_ + begin_ + i;
    Random random(derived_seed(seed_, kViews), static_cast<std::uint64_t>(place));
    samples_->view(sample_of(place), random, std::span(batch.inputs).subspan(pixels * i, pixels),
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
    for (std::int64_t number = first; number < end; ++number) {
      TrainingBatch batch = plan_.batch(number);
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stop_ || ready_.size() < kBatchesAhead; });
      if (stop_) return;
      ready_.push_back(std::move(batch));
      changed_.notify_all();
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    fault_ = std::current_exception();
    changed_.notify_all();
  }
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
