// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/dense_network.h"

#include <torch/nn/functional/loss.h>
#include <torch/utils.h>

#include "knuckle/net/dense_architecture.h"
#include "knuckle/patch/cube_patch.h"
#include "knuckle/training/vote_loss.h"

namespace knuckle {
namespace {

constexpr int kStride = kMapStride;
constexpr double kNoVote = 1e4;  // taken from the weights of pixels that are not hand
constexpr double kSmallestDistance = 1e-6;

/// u (or v) of the centres of the cells of one line of the maps.
torch::Tensor cell_centres(int64_t cells, const torch::TensorOptions& options) {
  const double half = 0.5 * static_cast<double>(kStride * cells - 1);
  const double first = 0.5 * (kStride - 1);
  return (torch::arange(cells, options) * kStride + (first - half)) / half;
}

/// Of each cell of the maps u, v and the depth of the nearest surface in it: N x 3 x h x h.
torch::Tensor cell_points(const torch::Tensor& patches) {
  const torch::Tensor depth = -torch::max_pool2d(-patches, {kStride, kStride});
  const int64_t cells = depth.size(2);
  const torch::Tensor centres = cell_centres(cells, depth.options());
  const torch::Tensor u = centres.view({1, 1, 1, cells}).expand_as(depth);
  const torch::Tensor v = centres.view({1, 1, cells, 1}).expand_as(depth);
  return torch::cat({u, v, depth}, 1);
}

/// The mean smooth L1 distance over the entries where `counts` is 1; 0 where there is none.
torch::Tensor masked_distance(const torch::Tensor& value, const torch::Tensor& target,
                              const torch::Tensor& counts) {
  const torch::Tensor distance =
      torch::smooth_l1_loss(value * counts, target * counts, at::Reduction::Sum, kVoteLossSmoothness);
  return distance / counts.expand_as(target).sum().clamp_min(1.0);
}

}  // namespace

/// All N x J x ... x P, with P the cells of a map.
struct DenseNetwork::Votes {
  torch::Tensor offset;     ///< N x J x 3 x P
  torch::Tensor closeness;  ///< N x J x 1 x P
  torch::Tensor weight;     ///< N x J x 1 x P, sums to 1 over P
  torch::Tensor points;     ///< N x 1 x 3 x P: where each cell is
  torch::Tensor is_hand;    ///< N x 1 x 1 x P

  torch::Tensor joints(double kernel) const {
    return ((points + offset * ((1.0 - closeness) * kernel)) * weight).sum(-1);
  }
};

DenseNetwork::DenseNetwork(const NetworkOptions& options)
    : NetworkModule(options.patch.size_px),
      joint_count_(options.joint_count()),
      options_(options.dense),
      maps_(options),
      network_(*this, dense_shape(options)) {}

torch::Tensor DenseNetwork::forward(const torch::Tensor& patches) {
  return network_.forward(to_compute(patches)).to(patches.scalar_type());
}

DenseNetwork::Votes DenseNetwork::votes_of(const torch::Tensor& output, const torch::Tensor& patches) const {
  const int64_t count = output.size(0);
  const torch::Tensor of_joints = output.narrow(1, 0, kMapsPerJoint * joint_count_);
  const torch::Tensor maps = of_joints.contiguous().view({count, kMapsPerJoint, joint_count_, -1});
  const torch::Tensor points = cell_points(patches).view({count, 1, 3, -1});
  Votes votes;
  votes.points = points;
  votes.is_hand = (points.narrow(2, 2, 1) < kCubeBackground).to(maps.scalar_type());
  votes.offset = maps.narrow(1, 0, 3).transpose(1, 2);
  votes.closeness = maps.select(1, 3).unsqueeze(2);
  const torch::Tensor weight = maps.select(1, 4).unsqueeze(2);
  votes.weight = torch::softmax(weight + (votes.is_hand - 1.0) * kNoVote, -1);
  return votes;
}

torch::Tensor DenseNetwork::logits(const torch::Tensor& output, const torch::Tensor& patches, int map) const {
  const torch::Tensor is_hand =
      (cell_points(patches).select(1, 2) < kCubeBackground).to(output.scalar_type());
  // As in use: all cells where none is hand.
  const torch::Tensor counts =
      torch::where(is_hand.sum({1, 2}, true) > 0, is_hand, torch::ones_like(is_hand));
  return (output.select(1, map) * counts).sum({1, 2}) / counts.sum({1, 2});
}

torch::Tensor DenseNetwork::question_loss(const torch::Tensor& logits, const torch::Tensor& answers) const {
  const torch::Tensor is_known = torch::isfinite(answers).to(logits.scalar_type());
  const torch::Tensor truth = torch::nan_to_num(answers, 0.0).to(logits.scalar_type());
  const torch::Tensor sum =
      torch::binary_cross_entropy_with_logits(logits, truth, is_known, {}, at::Reduction::Sum);
  return sum / is_known.sum().clamp_min(1.0);
}

torch::Tensor DenseNetwork::loss(const torch::Tensor& output, const torch::Tensor& patches,
                                 const torch::Tensor& targets) {
  if (!maps_.side && !maps_.hand) return joint_loss(output, patches, targets);
  torch::Tensor sum = joint_loss(output, patches, targets.narrow(1, 0, joint_count_).contiguous());
  int row = joint_count_;
  for (const std::optional<int>& map : {maps_.side, maps_.hand}) {
    if (!map) continue;
    const torch::Tensor answers = targets.select(1, row++).select(1, 0);
    sum = sum + options_.question_weight * question_loss(logits(output, patches, *map), answers);
  }
  return sum;
}

torch::Tensor DenseNetwork::joint_loss(const torch::Tensor& output, const torch::Tensor& patches,
                                       const torch::Tensor& joints) const {
  if (output.device().is_cpu() && output.scalar_type() == torch::kFloat) {
    return vote_loss(output, cell_points(patches), joints, {options_.kernel, options_.dense_weight});
  }
  return loss_by_operations(output, patches, joints);
}

torch::Tensor DenseNetwork::loss_by_operations(const torch::Tensor& output, const torch::Tensor& patches,
                                               const torch::Tensor& joints) const {
  const Votes votes = votes_of(output, patches);
  const torch::Tensor is_known = torch::isfinite(joints).all(-1, true).to(output.scalar_type());
  const torch::Tensor truth = torch::nan_to_num(joints, 0.0, 0.0, 0.0);
  torch::Tensor total = masked_distance(votes.joints(options_.kernel), truth, is_known);
  if (options_.dense_weight == 0.0) return total;

  const torch::Tensor difference = truth.unsqueeze(-1) - votes.points;
  const torch::Tensor distance = difference.norm(2, {2}, true).clamp_min(kSmallestDistance);
  const torch::Tensor counts =
      votes.is_hand * (distance < options_.kernel).to(output.scalar_type()) * is_known.unsqueeze(-1);
  total = total + options_.dense_weight * masked_distance(votes.offset, difference / distance, counts);
  return total +
         options_.dense_weight * masked_distance(votes.closeness, 1.0 - distance / options_.kernel, counts);
}

NetworkAnswer DenseNetwork::decode(const torch::Tensor& output, const torch::Tensor& patches) {
  const Votes votes = votes_of(output, patches);
  const torch::Tensor each = votes.points + votes.offset * ((1.0 - votes.closeness) * options_.kernel);
  const torch::Tensor joints = (each * votes.weight).sum(-1);
  const torch::Tensor squares = (each - joints.unsqueeze(-1)).square().sum(2, true);
  const torch::Tensor spread = (squares * votes.weight).sum(-1).sqrt().squeeze(-1);
  NetworkAnswer answer{joints, torch::exp(-spread / kSpreadScale), {}};
  if (maps_.side) answer.right_hand = torch::sigmoid(logits(output, patches, *maps_.side));
  if (maps_.hand) answer.hand = torch::sigmoid(logits(output, patches, *maps_.hand));
  return answer;
}

}  // namespace knuckle
