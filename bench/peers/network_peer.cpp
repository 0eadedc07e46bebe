// SPDX-License-Identifier: Apache-2.0
// network_peer ENGINE MODEL.pt MODEL.onnx LOOKS: milliseconds of each of so many looks at a patch, by one
// engine on one thread, a number a line. ENGINE: knuckle | opencv | libtorch. compare_networks.py runs it.
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>

#include <fmt/format.h>
#include <opencv2/core/utility.hpp>
#include <torch/utils.h>

#include "knuckle/core/error.h"
#include "knuckle/core/random.h"
#include "knuckle/net/network_file.h"
#include "knuckle/net/onnx/onnx_check.h"
#include "knuckle/net/onnx/onnx_engine.h"
#include "knuckle/net/onnx/onnx_file.h"
#include "knuckle/net/pose_network.h"
#include "knuckle/training/network_module.h"

namespace knuckle {
namespace {

using Look = std::function<void()>;

Image<float> patch_of(const NetworkOptions& options) {
  Image<float> patch(options.patch.size_px, options.patch.size_px);
  Random random(1);
  for (float& pixel : patch.pixels()) pixel = static_cast<float>(random.uniform(-1.0, 1.0));
  return patch;
}

Look knuckle_look(const std::string& model) {
  auto network = std::make_shared<const PoseNetwork>(std::filesystem::path(model));
  return [network, patch = patch_of(network->options())] { (void)network->predict(patch); };
}

Look opencv_look(const std::string& model, const std::string& onnx) {
  const NetworkOptions options = PoseNetwork(std::filesystem::path(model)).options();
  const std::shared_ptr<OnnxEngine> engine = create_onnx_engine(checked_onnx(load_onnx(onnx), onnx), onnx);
  return [engine, patch = patch_of(options)] { (void)engine->run(patch.pixels()); };
}

/// Weights say nothing of the time.
Look libtorch_look(const std::string& model) {
  const NetworkOptions options = PoseNetwork(std::filesystem::path(model)).options();
  const std::shared_ptr<NetworkModule> network = make_network(options, 1);
  network->eval();
  const Image<float> patch = patch_of(options);
  torch::Tensor input = torch::empty({1, 1, patch.height(), patch.width()});
  std::copy(patch.pixels().begin(), patch.pixels().end(), input.data_ptr<float>());
  return [network, input] {
    const torch::NoGradGuard no_gradient;
    (void)network->decode(network->forward(input), input);
  };
}

Look look_of(const std::string& engine, const std::string& model, const std::string& onnx) {
  if (engine == "knuckle") return knuckle_look(model);
  if (engine == "opencv") return opencv_look(model, onnx);
  if (engine == "libtorch") return libtorch_look(model);
  fail("network_peer: the engine is '{}', expected knuckle, opencv or libtorch", engine);
}

void measure(const Look& look, int looks) {
  constexpr int kToWarmUp = 10;
  for (int i = 0; i < kToWarmUp; ++i) look();
  for (int i = 0; i < looks; ++i) {
    const auto begun = std::chrono::steady_clock::now();
    look();
    fmt::print("{}\n",
               std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count());
  }
}

}  // namespace
}  // namespace knuckle

int main(int count, char** words) {
  if (count != 5) {
    fmt::print(stderr, "usage: network_peer knuckle|opencv|libtorch MODEL.pt MODEL.onnx LOOKS\n");
    return 2;
  }
  torch::set_num_threads(1);
  cv::setNumThreads(1);
  try {
    knuckle::measure(knuckle::look_of(words[1], words[2], words[3]), std::stoi(words[4]));
  } catch (const std::exception& error) {
    fmt::print(stderr, "network_peer: {}\n", error.what());
    return 1;
  }
  return 0;
}
