// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/torch_device.h"

#include <optional>
#include <string_view>

#include <torch/cuda.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr std::string_view kGpu = "cuda";

/// The GPU's number in "cuda:1"; nothing in "cuda".
std::optional<long long> named_gpu(const std::string& name) {
  if (name == kGpu) return std::nullopt;
  return parse_integer(std::string_view(name).substr(kGpu.size() + 1), "device");
}

}  // namespace

torch::Device device_from_name(const std::string& name, int number_on_machine) {
  if (name == "cpu") return {torch::kCPU};
  if (name != kGpu && !name.starts_with("cuda:"))
    fail("device is \"{}\", expected cpu, cuda or cuda:N", name);
  const std::optional<long long> named = named_gpu(name);
  const auto count = static_cast<long long>(torch::cuda::device_count());
  if (count == 0) {
    fail(
        "device {}: this LibTorch was built without CUDA, or finds no GPU; train with --device cpu, or build "
        "Knuckle against a LibTorch with CUDA",
        name);
  }
  const long long number = named.value_or(number_on_machine % count);
  if (number < 0 || number >= count)
    fail("device {}: there are {} GPUs, expected cuda:0 to cuda:{}", name, count, count - 1);
  return {torch::kCUDA, static_cast<torch::DeviceIndex>(number)};
}

}  // namespace knuckle
