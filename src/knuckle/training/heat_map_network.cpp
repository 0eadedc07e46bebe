// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/heat_map_network.h"

#include <algorithm>

#include <torch/utils.h>

#include "knuckle/net/heat_map_decoding.h"

namespace knuckle {
namespace {

/// exp(-(i - centre)^2 / (2 deviation^2)) for i = 0, ..., count - 1: the shape of `centres` and one dimension
/// more.
torch::Tensor gaussians(const torch::Tensor& centres, int64_t count, double deviation) {
  const torch::Tensor distance = torch::arange(count, centres.options()) - centres.unsqueeze(-1);
  return torch::exp(distance.square() * (-0.5 / (deviation * deviation)));
}

}  // namespace

HeatMapNetwork::HeatMapNetwork(const NetworkOptions& options)
    : PaperNetwork(options),
      options_(options),
      joint_count_(options.joint_count()),
      bins_(depth_bins_per_joint(options)),
      grid_{options.paper.map_cells, options.patch.size_px} {}

torch::Tensor HeatMapNetwork::targets(const torch::Tensor& joints) const {
  // cell_of is linear.
  const double first = grid_.cell_of(0.0);
  const torch::Tensor cells = joints.narrow(-1, 0, 2) * (grid_.cell_of(1.0) - first) + first;
  const torch::Tensor along =
      gaussians(cells, grid_.cells, options_.paper.peak_deviation);  // N x J x 2 x cells
  const torch::Tensor maps = along.select(2, 1).unsqueeze(-1) * along.select(2, 0).unsqueeze(-2);
  if (bins_ == 0) return maps.flatten(1);
  const torch::Tensor depth = 0.5 * (joints.select(-1, 2).clamp(-1.0, 1.0) + 1.0) * bins_ - 0.5;
  return torch::cat({maps.flatten(1), gaussians(depth, bins_, options_.paper.peak_deviation).flatten(1)}, 1);
}

torch::Tensor HeatMapNetwork::loss(const torch::Tensor& output, const torch::Tensor& /*patches*/,
                                   const torch::Tensor& joints) {
  const torch::Tensor is_known = torch::isfinite(joints).all(-1).to(output.scalar_type());
  const torch::Tensor squares = (output - targets(torch::nan_to_num(joints, 0.0, 0.0, 0.0))).square();
  const int64_t count = output.size(0);
  const int64_t cells = joint_count_ * grid_.cells * grid_.cells;
  torch::Tensor a_joint = squares.narrow(1, 0, cells).view({count, joint_count_, -1}).sum(-1);
  if (bins_ > 0) {
    a_joint =
        a_joint + squares.narrow(1, cells, joint_count_ * bins_).view({count, joint_count_, -1}).sum(-1);
  }
  return (a_joint * is_known).sum() / is_known.sum().clamp_min(1.0);
}

NetworkAnswer HeatMapNetwork::decode(const torch::Tensor& output, const torch::Tensor& patches) {
  const torch::Tensor values = output.detach().to(torch::kCPU, torch::kFloat).contiguous();
  const torch::Tensor pixels = patches.detach().to(torch::kCPU, torch::kFloat).contiguous();
  const auto width = static_cast<std::size_t>(values.size(1));
  const auto patch_pixels = static_cast<std::size_t>(grid_.size_px) * grid_.size_px;
  torch::Tensor joints = torch::empty({output.size(0), joint_count_, 3});
  torch::Tensor confidence = torch::empty({output.size(0), joint_count_});
  for (int64_t n = 0; n < output.size(0); ++n) {
    const auto place = static_cast<std::size_t>(n);
    const NetworkPrediction found =
        decode_heat_maps(options_, {values.data_ptr<float>() + place * width, width},
                         {pixels.data_ptr<float>() + place * patch_pixels, patch_pixels});
    float* joint = joints.data_ptr<float>() + n * joint_count_ * 3;
    for (const PatchPoint& point : found.joints) {
      for (const double coordinate : {point.u, point.v, point.d}) *joint++ = static_cast<float>(coordinate);
    }
    std::ranges::copy(found.confidence, confidence.data_ptr<float>() + n * joint_count_);
  }
  return {joints.to(output.device()), confidence.to(output.device())};
}

}  // namespace knuckle
