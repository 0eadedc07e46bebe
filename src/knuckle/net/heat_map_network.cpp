// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/heat_map_network.h"

#include <algorithm>

#include <torch/utils.h>

namespace knuckle {
namespace {

using Activation = FullyConnected::Activation;

/// exp(-(i - centre)^2 / (2 deviation^2)) for i = 0, ..., count - 1: the shape of `centres` and one dimension
/// more.
torch::Tensor gaussians(const torch::Tensor& centres, int64_t count, double deviation) {
  const torch::Tensor distance = torch::arange(count, centres.options()) - centres.unsqueeze(-1);
  return torch::exp(distance.square() * (-0.5 / (deviation * deviation)));
}

}  // namespace

HeatMapNetwork::HeatMapNetwork(const NetworkOptions& options)
    : NetworkModule(options.patch.size_px),
      joint_count_(options.joint_count()),
      has_depth_(options.architecture == "heatmap25d"),
      options_(options.paper),
      grid_{options.paper.map_cells, options.patch.size_px},
      banks_(register_module("banks", std::make_shared<ConvolutionBanks>(grid_.size_px, options_.first_maps,
                                                                         options_.second_maps))) {
  const int64_t outputs = joint_count_ * (int64_t{grid_.cells} * grid_.cells + bins());
  const std::vector<FullyConnected::Layer> layers = {{options_.hidden_units, Activation::hidden},
                                                     {outputs, Activation::linear}};
  layers_ = register_module(
      "layers", std::make_shared<FullyConnected>(banks_->feature_count(), layers, options_.dropout));
}

torch::Tensor HeatMapNetwork::forward(const torch::Tensor& patches) {
  return layers_->forward(banks_->forward(patches));
}

torch::Tensor HeatMapNetwork::targets(const torch::Tensor& joints) const {
  // cell_of is linear.
  const double first = grid_.cell_of(0.0);
  const torch::Tensor cells = joints.narrow(-1, 0, 2) * (grid_.cell_of(1.0) - first) + first;
  const torch::Tensor along = gaussians(cells, grid_.cells, options_.peak_deviation);  // N x J x 2 x cells
  const torch::Tensor maps = along.select(2, 1).unsqueeze(-1) * along.select(2, 0).unsqueeze(-2);
  if (!has_depth_) return maps.flatten(1);
  const torch::Tensor depth = 0.5 * (joints.select(-1, 2).clamp(-1.0, 1.0) + 1.0) * bins() - 0.5;
  return torch::cat({maps.flatten(1), gaussians(depth, bins(), options_.peak_deviation).flatten(1)}, 1);
}

torch::Tensor HeatMapNetwork::loss(const torch::Tensor& output, const torch::Tensor& /*patches*/,
                                   const torch::Tensor& joints) {
  const torch::Tensor is_known = torch::isfinite(joints).all(-1).to(output.scalar_type());
  const torch::Tensor squares = (output - targets(torch::nan_to_num(joints, 0.0, 0.0, 0.0))).square();
  const int64_t count = output.size(0);
  const int64_t cells = joint_count_ * grid_.cells * grid_.cells;
  torch::Tensor a_joint = squares.narrow(1, 0, cells).view({count, joint_count_, -1}).sum(-1);
  if (has_depth_) {
    a_joint =
        a_joint + squares.narrow(1, cells, joint_count_ * bins()).view({count, joint_count_, -1}).sum(-1);
  }
  return (a_joint * is_known).sum() / is_known.sum().clamp_min(1.0);
}

HeatMapPeak HeatMapNetwork::peak_of(std::span<const float> map) const {
  return options_.peak == "gaussian" ? gaussian_peak(map, grid_.cells)
                                     : mean_shift_peak(map, grid_.cells, options_.peak_deviation);
}

NetworkAnswer HeatMapNetwork::decode(const torch::Tensor& output, const torch::Tensor& patches) {
  const torch::Tensor values = output.detach().to(torch::kCPU, torch::kFloat).contiguous();
  const torch::Tensor pixels = patches.detach().to(torch::kCPU, torch::kFloat).contiguous();
  const auto cells = static_cast<std::size_t>(grid_.cells) * grid_.cells;
  const auto patch_pixels = static_cast<std::size_t>(grid_.size_px) * grid_.size_px;
  torch::Tensor joints = torch::empty({output.size(0), joint_count_, 3});
  torch::Tensor confidence = torch::empty({output.size(0), joint_count_});
  for (int64_t n = 0; n < output.size(0); ++n) {
    const float* const maps = values.data_ptr<float>() + n * values.size(1);
    const float* const depths = maps + joint_count_ * static_cast<int64_t>(cells);
    const std::span<const float> patch(pixels.data_ptr<float>() + n * static_cast<int64_t>(patch_pixels),
                                       patch_pixels);
    for (int64_t j = 0; j < joint_count_; ++j) {
      const HeatMapPeak peak = peak_of({maps + j * static_cast<int64_t>(cells), cells});
      float* const joint = joints.data_ptr<float>() + (n * joint_count_ + j) * 3;
      joint[0] = static_cast<float>(grid_.coordinate_of(peak.column));
      joint[1] = static_cast<float>(grid_.coordinate_of(peak.row));
      if (has_depth_) {
        const double bin = soft_arg_max({depths + j * bins(), static_cast<std::size_t>(bins())});
        joint[2] = static_cast<float>(2.0 * (bin + 0.5) / static_cast<double>(bins()) - 1.0);
      } else {
        joint[2] = surface_depth(patch, grid_.size_px, joint[0], joint[1]);
      }
      confidence.data_ptr<float>()[n * joint_count_ + j] = std::clamp(peak.value, 0.0f, 1.0f);
    }
  }
  return {joints.to(output.device()), confidence.to(output.device())};
}

}  // namespace knuckle
