// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/network_writer.h"

#include <algorithm>
#include <string>

#include <torch/utils.h>

#include "knuckle/core/error.h"
#include "knuckle/net/network_file.h"

namespace knuckle {
namespace {

/// Copies a tensor's values; its shape has to be the array's.
template <class Number>
void copy_values(const torch::Tensor& tensor, torch::ScalarType type, const NetworkArray& array,
                 std::span<Number> to) {
  const std::vector<int64_t> shape(array.shape.begin(), array.shape.end());
  if (tensor.sizes() != torch::IntArrayRef(shape)) {
    fail("network: {} has another shape than its options ask for", array.name);
  }
  const torch::Tensor values = tensor.detach().to(torch::kCPU, type).contiguous();
  std::copy_n(static_cast<const Number*>(values.data_ptr()), to.size(), to.begin());
}

/// A tensor with a copy of these numbers.
template <class Number>
torch::Tensor as_tensor(std::span<const Number> numbers, torch::ScalarType type) {
  const torch::Tensor tensor = torch::empty({static_cast<int64_t>(numbers.size())}, type);
  std::ranges::copy(numbers, static_cast<Number*>(tensor.data_ptr()));
  return tensor;
}

}  // namespace

void copy_weights(const TrainableModule& network, WeightArrays& weights) {
  const auto parameters = network.named_parameters();
  const auto buffers = network.named_buffers();
  for (const NetworkArray& array : weights.arrays()) {
    const bool is_half = array.precision == NetworkArray::Precision::half;
    const torch::Tensor* const tensor = is_half ? parameters.find(array.name) : buffers.find(array.name);
    if (tensor == nullptr) fail("network: it has no {}, which its options ask for", array.name);
    if (is_half) {
      copy_values(*tensor, torch::kHalf, array, weights.halves(array.name));
    } else {
      copy_values(*tensor, torch::kFloat, array, weights.singles(array.name));
    }
  }
}

NetworkWeights weights_of(const NetworkOptions& options, const NetworkModule& network) {
  NetworkWeights weights(options);
  copy_weights(network, weights);
  return weights;
}

void set_weights(TrainableModule& network, const WeightArrays& weights) {
  const torch::NoGradGuard no_gradient;
  const auto parameters = network.named_parameters();
  const auto buffers = network.named_buffers();
  for (const NetworkArray& array : weights.arrays()) {
    const bool is_half = array.precision == NetworkArray::Precision::half;
    const torch::Tensor& target = is_half ? parameters[array.name] : buffers[array.name];
    const torch::Tensor values = is_half ? as_tensor(weights.halves(array.name), torch::kHalf)
                                         : as_tensor(weights.singles(array.name), torch::kFloat);
    const std::vector<int64_t> shape(array.shape.begin(), array.shape.end());
    target.narrow(0, 0, shape.front()).copy_(values.view(shape));
  }
}

void save_network(const std::filesystem::path& path, const NetworkOptions& options,
                  const NetworkModule& network) {
  save_network_weights(path, weights_of(options, network));
}

}  // namespace knuckle
