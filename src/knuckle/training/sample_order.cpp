// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/sample_order.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/random.h"

namespace knuckle {
namespace {

// Families of random numbers, beside the numbers of groups.
constexpr std::uint64_t kRunOrders = std::uint64_t{1} << 32;
constexpr std::uint64_t kWindowOrders = kRunOrders + 1;

/// Fisher and Yates.
void shuffle(std::span<std::int64_t> numbers, Random random) {
  for (std::size_t i = numbers.size(); i > 1; --i) {
    std::swap(numbers[i - 1], numbers[random.below(static_cast<std::uint32_t>(i))]);
  }
}

/// As many as it takes for none to be much larger than the asked size; each has a run at least.
std::size_t windows_of(const SampleGroup& group) {
  if (group.runs.empty() || group.window <= 0) return 1;
  const std::int64_t windows = (group.size + group.window - 1) / group.window;
  return static_cast<std::size_t>(std::clamp<std::int64_t>(windows, 1, std::ssize(group.runs)));
}

}  // namespace

SampleOrder::SampleOrder(SampleGroup group, std::uint64_t seed)
    : group_(std::move(group)), seed_(seed), windows_(windows_of(group_)) {
  if (group_.size == 0) fail("training: there is no sample to train on");
  if (group_.runs.empty()) group_.runs = {group_.size};
  std::int64_t first = 0;
  for (const std::int64_t run : group_.runs) {
    first_of_run_.push_back(first);
    first += run;
  }
}

std::int64_t SampleOrder::at(std::int64_t number) {
  const std::int64_t epoch = number / group_.size;
  const std::int64_t place = number % group_.size;
  if (epoch != epoch_) begin_epoch(epoch);
  const auto after = std::ranges::upper_bound(first_of_window_, place);
  const auto window = static_cast<std::size_t>(after - first_of_window_.begin()) - 1;
  if (order_.empty() || window != window_) begin_window(window);
  return order_[static_cast<std::size_t>(place - first_of_window_[window])];
}

void SampleOrder::begin_epoch(std::int64_t epoch) {
  epoch_ = epoch;
  order_.clear();
  runs_.resize(group_.runs.size());
  std::iota(runs_.begin(), runs_.end(), std::int64_t{0});
  shuffle(runs_, Random(derived_seed(seed_, kRunOrders), static_cast<std::uint64_t>(epoch)));
  first_of_window_ = {0};
  for (std::size_t window = 0; window < windows_; ++window) {
    std::int64_t end = first_of_window_.back();
    for (std::size_t i = window * runs_.size() / windows_; i < (window + 1) * runs_.size() / windows_; ++i)
      end += group_.runs[static_cast<std::size_t>(runs_[i])];
    first_of_window_.push_back(end);
  }
}

void SampleOrder::begin_window(std::size_t window) {
  window_ = window;
  const auto begin = runs_.begin() + static_cast<std::ptrdiff_t>(window * runs_.size() / windows_);
  const auto end = runs_.begin() + static_cast<std::ptrdiff_t>((window + 1) * runs_.size() / windows_);
  std::vector<std::int64_t> runs(begin, end);
  std::ranges::sort(runs);
  order_.clear();
  for (const std::int64_t run : runs) {
    const auto r = static_cast<std::size_t>(run);
    for (std::int64_t i = 0; i < group_.runs[r]; ++i) order_.push_back(first_of_run_[r] + i);
  }
  shuffle(order_, Random(seed_of_window(window), static_cast<std::uint64_t>(epoch_)));
}

std::uint64_t SampleOrder::seed_of_window(std::size_t window) const {
  if (windows_ == 1) return seed_;
  return derived_seed(derived_seed(seed_, kWindowOrders), window);
}

}  // namespace knuckle
