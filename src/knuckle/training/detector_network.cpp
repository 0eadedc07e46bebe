// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/detector_network.h"

#include <cmath>

#include <torch/nn/init.h>
#include <torch/utils.h>

#include "knuckle/prepare/detector_samples.h"

namespace knuckle {
namespace {

// Weights of the parts of the loss.
constexpr double kOffsetWeight = 0.3;
constexpr double kInverseDepthWeight = 4.0;
constexpr double kExtentWeight = 1.0;

constexpr double kPeakShare = 0.3;       // deviation of a heat map's peak over the hand's extent
constexpr double kLeastDeviation = 0.6;  // [cells of the maps]
constexpr double kMostDeviation = 4.0;   // [cells of the maps]
constexpr double kNearCentre = 0.6;      // where the target's heat is above, a cell speaks for the hand
constexpr double kNearExcused = 0.1;     // where that of one that does not count is above, no heat is wrong
constexpr double kFirstHeat = -2.2;      // bias of the heat: a tenth, so that the first steps are small

/// What the maps should be: all N x height x width.
struct MapTargets {
  torch::Tensor heat;
  torch::Tensor is_centre;  // 1 in the cell that holds a centre
  torch::Tensor is_judged;  // 0 around hands that do not count
  torch::Tensor is_near;    // 1 where the cell speaks for a hand
  torch::Tensor hand_count;
  torch::Tensor hands;  // N x height x width x kHandNumbers: of the hand that each cell speaks for
  torch::Tensor offset_u, offset_v;
};

torch::Tensor number(const torch::Tensor& hands, std::size_t which) {
  return hands.select(-1, static_cast<int64_t>(which));
}

MapTargets map_targets(const torch::Tensor& targets, const torch::Tensor& output, double focal_cells) {
  const int64_t height = output.size(2);
  const int64_t width = output.size(3);
  const torch::Tensor hands = targets.to(output.scalar_type());
  const torch::Tensor is_there = torch::isfinite(number(hands, kHandCounts));
  const torch::Tensor counts =
      (is_there & (torch::nan_to_num(number(hands, kHandCounts)) > 0.5)).to(output.scalar_type());
  const torch::Tensor known = torch::nan_to_num(hands, 0.0, 0.0, 0.0);
  const auto in_maps = [](const torch::Tensor& cells) {
    return (cells - 0.5 * (kMapStride - 1)) / kMapStride;
  };
  const torch::Tensor u = in_maps(number(known, kHandU));  // N x M
  const torch::Tensor v = in_maps(number(known, kHandV));
  const torch::Tensor radius = torch::exp(number(known, kHandInverseDepth) + number(known, kHandExtent)) *
                               (focal_cells * kExtentUnitMm / (1000.0 * kMapStride));
  const torch::Tensor deviation = (radius * kPeakShare).clamp(kLeastDeviation, kMostDeviation);
  const auto wide = [](const torch::Tensor& values) { return values.unsqueeze(-1).unsqueeze(-1); };
  const torch::Tensor columns = torch::arange(width, output.options()).view({1, 1, 1, width});
  const torch::Tensor rows = torch::arange(height, output.options()).view({1, 1, height, 1});
  const torch::Tensor du = columns - wide(torch::round(u));  // N x M x height x width, with rows
  const torch::Tensor dv = rows - wide(torch::round(v));
  const torch::Tensor peaks = torch::exp(-(du.square() + dv.square()) / (2.0 * wide(deviation.square())));
  const torch::Tensor heat_of_each = peaks * wide(counts);
  const torch::Tensor excused = peaks * wide((is_there.to(output.scalar_type()) - counts));

  MapTargets maps;
  const auto [heat, speaker] = heat_of_each.max(1);
  maps.heat = heat;
  maps.is_centre = (((du == 0.0) & (dv == 0.0)).to(output.scalar_type()) * wide(counts)).amax({1});
  const torch::Tensor is_excused = (excused.amax({1}) > kNearExcused).to(output.scalar_type());
  maps.is_judged = torch::maximum(1.0 - is_excused, maps.is_centre);
  maps.is_near = (heat > kNearCentre).to(output.scalar_type());
  maps.hand_count = counts.sum().clamp_min(1.0);
  const int64_t samples = hands.size(0);
  const torch::Tensor index =
      speaker.view({samples, height * width, 1}).expand({samples, height * width, hands.size(2)});
  maps.hands = hands.gather(1, index).view({samples, height, width, hands.size(2)});
  const torch::Tensor flat = speaker.view({samples, -1});
  maps.offset_u = u.gather(1, flat).view({samples, height, width}) - columns.view({1, 1, width});
  maps.offset_v = v.gather(1, flat).view({samples, height, width}) - rows.view({1, height, 1});
  return maps;
}

torch::Tensor heat_loss(const torch::Tensor& logits, const MapTargets& maps) {
  const torch::Tensor p = torch::sigmoid(logits);
  const torch::Tensor found = -torch::log_sigmoid(logits) * (1.0 - p).square() * maps.is_centre;
  const torch::Tensor invented = -torch::log_sigmoid(-logits) * p.square() * (1.0 - maps.heat).pow(4) *
                                 (1.0 - maps.is_centre) * maps.is_judged;
  return (found + invented).sum() / maps.hand_count;
}

/// The mean over the cells that speak for a hand; those where the truth is not known do not count.
torch::Tensor mean_near(const torch::Tensor& errors, const torch::Tensor& truth, const MapTargets& maps) {
  const torch::Tensor weight = maps.is_near * torch::isfinite(truth).to(errors.scalar_type());
  return (errors * weight).sum() / weight.sum().clamp_min(1.0);
}

torch::Tensor distance_loss(const torch::Tensor& said, const torch::Tensor& truth, const MapTargets& maps) {
  return mean_near((said - torch::nan_to_num(truth)).abs(), truth, maps);
}

torch::Tensor side_loss(const torch::Tensor& logits, const MapTargets& maps) {
  const torch::Tensor truth = number(maps.hands, kHandSide);
  const torch::Tensor is_right = torch::nan_to_num(truth);
  const torch::Tensor entropy =
      -is_right * torch::log_sigmoid(logits) - (1.0 - is_right) * torch::log_sigmoid(-logits);
  return mean_near(entropy, truth, maps);
}

}  // namespace

DetectorNetwork::DetectorNetwork(const DetectorOptions& options)
    : options_(options), network_(*this, options.shape()) {
  const torch::NoGradGuard no_gradient;
  network_.head_bias()[kHeatMap] = kFirstHeat;
}

torch::Tensor DetectorNetwork::forward(const torch::Tensor& inputs) {
  return network_.forward(to_compute(inputs)).to(inputs.scalar_type());
}

torch::Tensor DetectorNetwork::loss(const torch::Tensor& output, const torch::Tensor& /*inputs*/,
                                    const torch::Tensor& targets) {
  const MapTargets maps = map_targets(targets, output, options_.focal_cells);
  const auto said = [&](int map) { return output.select(1, map); };
  const auto inverse_depth = number(maps.hands, kHandInverseDepth);
  const auto extent = number(maps.hands, kHandExtent);
  return heat_loss(said(kHeatMap), maps) +
         kOffsetWeight * (distance_loss(said(kOffsetUMap), maps.offset_u, maps) +
                          distance_loss(said(kOffsetVMap), maps.offset_v, maps)) +
         kInverseDepthWeight * distance_loss(said(kInverseDepthMap), inverse_depth, maps) +
         kExtentWeight * distance_loss(said(kExtentMap), extent, maps) +
         options_.side_weight * side_loss(said(kSideMap), maps);
}

std::shared_ptr<DetectorNetwork> make_detector_network(const DetectorOptions& options, std::uint64_t seed) {
  check(options, "detector");
  torch::manual_seed(seed);  // weights are drawn from LibTorch's own generator
  auto network = std::make_shared<DetectorNetwork>(options);
  lay_out_for_channels_last(*network);
  return network;
}

}  // namespace knuckle
