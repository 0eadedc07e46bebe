// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <memory>

#include "knuckle/workers/c10d_workers.h"
#include "knuckle/workers/tensor_exchange.h"

namespace knuckle {

/// From GPU to GPU by c10d's NCCL; nullptr where this build has none, and for tensors that lie elsewhere. A
/// GPU belongs to one worker alone. `workers` has to live as long as this.
std::unique_ptr<TensorExchange> nccl_exchange(C10dWorkers& workers, const torch::Device& device);

}  // namespace knuckle
