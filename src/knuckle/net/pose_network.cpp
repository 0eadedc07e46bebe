// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/pose_network.h"

#include <cmath>

#include <torch/utils.h>

#include "knuckle/core/error.h"
#include "knuckle/net/network_file.h"
#include "knuckle/net/torch_errors.h"
#include "knuckle/net/torch_threads.h"

namespace knuckle {

namespace {

/// The answer on a batch of one patch.
NetworkPrediction as_prediction(const NetworkAnswer& answer) {
  const torch::Tensor joints = answer.joints.contiguous();
  NetworkPrediction prediction;
  for (int64_t i = 0; i < joints.size(1); ++i) {
    const float* const joint = joints.data_ptr<float>() + 3 * i;
    prediction.joints.push_back({joint[0], joint[1], joint[2]});
  }
  if (!answer.confidence.defined()) return prediction;
  const torch::Tensor confidence = answer.confidence.contiguous();
  const float* const values = confidence.data_ptr<float>();
  prediction.confidence.assign(values, values + confidence.numel());
  return prediction;
}

}  // namespace

struct PoseNetwork::State {
  NetworkOptions options;
  std::shared_ptr<NetworkModule> network;
};

PoseNetwork::PoseNetwork(const std::filesystem::path& path) {
  use_calling_thread_alone();
  LoadedNetwork loaded = load_network(path);
  state_ = std::make_unique<State>(State{std::move(loaded.options), std::move(loaded.network)});
  make_ready();
}

PoseNetwork::PoseNetwork(const NetworkOptions& options, std::uint64_t seed)
    : state_(std::make_unique<State>(State{options, make_network(options, seed)})) {
  make_ready();
}

void PoseNetwork::make_ready() {
  NetworkModule& network = *state_->network;
  network.eval();
  network.fold_norms();
  for (const torch::Tensor& parameter : network.parameters()) parameter.set_requires_grad(false);
}

PoseNetwork::PoseNetwork(PoseNetwork&&) noexcept = default;
PoseNetwork& PoseNetwork::operator=(PoseNetwork&&) noexcept = default;
PoseNetwork::~PoseNetwork() = default;

const NetworkOptions& PoseNetwork::options() const {
  return state_->options;
}

NetworkPrediction PoseNetwork::predict(const Image<float>& patch) const {
  const int size = state_->options.patch.size_px;
  if (patch.width() != size || patch.height() != size) {
    fail("network: a patch of {} x {}, expected {} x {}", patch.width(), patch.height(), size, size);
  }
  for (const float pixel : patch.pixels()) {
    if (!std::isfinite(pixel)) fail("network: a pixel of the patch is not finite");
  }
  use_calling_thread_alone();
  const c10::InferenceMode inference;
  const torch::Tensor input =
      torch::from_blob(const_cast<float*>(patch.data()), {1, 1, size, size});  // read only
  return with_clear_errors("network", [&] {
    NetworkModule& network = *state_->network;
    return as_prediction(network.decode(network.forward(input), input));
  });
}

}  // namespace knuckle
