// SPDX-License-Identifier: Apache-2.0
// Private to training and to this module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <torch/types.h>

namespace knuckle {

/// Numbers that workers tell each other, as tensors. All workers make the same calls in the same order.
class TensorExchange {
 public:
  virtual ~TensorExchange() = default;

  /// `sent`: a row of 32-bit numbers, `sent_counts[k]` of them for worker k, one worker after another.
  /// Returns what all have sent to this one, in the order of the workers, on the same device;
  /// `received_counts` says how many numbers that is of each. Throws as `WorkerGroup::exchange` does.
  virtual torch::Tensor exchange(const torch::Tensor& sent, std::vector<std::int64_t> sent_counts,
                                 std::vector<std::int64_t> received_counts) = 0;
};

/// Workers that have a way of their own between the places where tensors lie, as GPUs have.
class DeviceWorkers {
 public:
  virtual ~DeviceWorkers() = default;

  /// nullptr where there is no such way for tensors of this device: then they go as bytes, by
  /// `WorkerGroup::exchange`. Called by all workers, once.
  virtual std::unique_ptr<TensorExchange> exchange_on(const torch::Device& device) = 0;
};

}  // namespace knuckle
