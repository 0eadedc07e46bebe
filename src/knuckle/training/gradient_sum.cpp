// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/gradient_sum.h"

#include <future>
#include <utility>

#include <torch/csrc/autograd/function.h>
#include <torch/csrc/autograd/utils/lambda_post_hook.h>
#include <torch/csrc/autograd/variable.h>

#include "knuckle/training/torch_threads.h"

namespace knuckle {

GradientSum::GradientSum(WorkerGroup& workers, int shards, const torch::Device& device,
                         std::vector<std::vector<torch::Tensor>> parameters, std::int64_t part_bytes)
    : device_(device),
      sum_(workers, shards, device),
      beside_(device),
      summed_(device),
      parameters_(std::move(parameters)) {
  const std::vector<torch::Tensor>& first = parameters_.front();
  std::int64_t bytes = 0;
  for (std::size_t p = first.size(); p-- > 0;) {
    first_layers_.push_back(p);
    bytes += static_cast<std::int64_t>(first[p].nbytes());
    if (bytes < part_bytes || p == 0) continue;
    parts_.push_back({.parameters = std::exchange(first_layers_, {}), .known = DeviceMark(device_)});
    bytes = 0;
  }
  for (std::size_t part = 0; part < parts_.size(); ++part) watch_gradients(part);
}

GradientSum::~GradientSum() {
  for (const auto& [node, hook] : hooks_) node->del_post_hook(hook);
}

/// Has each gradient of a part counted as it is there.
void GradientSum::watch_gradients(std::size_t part) {
  using torch::autograd::variable_list;
  for (const std::size_t parameter : parts_[part].parameters) {
    for (const std::vector<torch::Tensor>& shard : parameters_) {
      std::shared_ptr<torch::autograd::Node> accumulator =
          torch::autograd::impl::grad_accumulator(shard[parameter]);
      auto counted = [this, part](const variable_list& outputs, const variable_list& /*inputs*/) {
        count_gradient(part);
        return outputs;
      };
      const std::uintptr_t hook = accumulator->add_post_hook(
          std::make_unique<torch::autograd::utils::LambdaPostHook>(std::move(counted)));
      hooks_.emplace_back(std::move(accumulator), hook);
    }
  }
}

std::vector<double> GradientSum::sum(const std::function<std::vector<double>()>& backward,
                                     std::vector<std::vector<torch::Tensor>> others) {
  expect_all();
  std::vector<double> losses;
  if (parts_.empty()) {
    losses = backward();
  } else {
    std::future<void> parts = std::async(std::launch::async, [this] { sum_parts(); });
    try {
      losses = backward();
    } catch (...) {
      end_early();
      throw;
    }
    parts.get();
    summed_.wait();
  }
  const std::vector<std::vector<torch::Tensor>> gradients = gradients_of(first_layers_);
  for (std::size_t shard = 0; shard < others.size(); ++shard) {
    others[shard].insert(others[shard].end(), gradients[shard].begin(), gradients[shard].end());
  }
  return sum_.sum(others, losses);
}

void GradientSum::expect_all() {
  for (Part& part : parts_) part.missing = part.parameters.size() * parameters_.size();
  is_over_ = false;
}

void GradientSum::count_gradient(std::size_t part) {
  {
    const std::lock_guard lock(mutex_);
    if (--parts_[part].missing > 0) return;
    parts_[part].known.set();
  }
  changed_.notify_one();
}

/// All workers sum the parts in this order, whichever is there first.
void GradientSum::sum_parts() {
  use_calling_thread_alone();
  const auto used = beside_.used();
  for (Part& part : parts_) {
    if (!wait_for(part)) return;
    part.known.wait();
    sum_.sum(gradients_of(part.parameters), {});
  }
  summed_.set();
}

/// Whether it is there; no longer where `backward` has failed.
bool GradientSum::wait_for(const Part& part) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return part.missing == 0 || is_over_; });
  return part.missing == 0;
}

void GradientSum::end_early() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  changed_.notify_one();
}

std::vector<std::vector<torch::Tensor>> GradientSum::gradients_of(
    const std::vector<std::size_t>& which) const {
  std::vector<std::vector<torch::Tensor>> gradients;
  for (const std::vector<torch::Tensor>& shard : parameters_) {
    std::vector<torch::Tensor>& own = gradients.emplace_back();
    for (const std::size_t parameter : which) own.push_back(shard[parameter].grad());
  }
  return gradients;
}

}  // namespace knuckle
