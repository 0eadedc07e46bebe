// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/torch_device.h"

#include <torch/cuda.h>

#include "knuckle/core/error.h"

namespace knuckle {

torch::Device device_from_name(const std::string& name) {
  if (name == "cpu") return {torch::kCPU};
  if (name != "cuda") fail("device is \"{}\", expected cpu or cuda", name);
  if (!torch::cuda::is_available()) {
    fail(
        "device cuda: this LibTorch was built without CUDA, or finds no GPU; train with --device cpu, or "
        "build "
        "Knuckle against a LibTorch with CUDA");
  }
  return {torch::kCUDA};
}

}  // namespace knuckle
