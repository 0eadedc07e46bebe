// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/vote_aggregation.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "knuckle/core/likelihood.h"
#include "knuckle/net/dense_architecture.h"
#include "knuckle/patch/cube_patch.h"

namespace knuckle {
namespace {

/// A cell of the maps: where its nearest surface is, and its channels.
struct Cell {
  float u, v, d;
  const float* channels;
};

float nearest_depth(const Image<float>& patch, int row, int column) {
  float nearest = patch(column * kMapStride, row * kMapStride);
  for (int y = 0; y < kMapStride; ++y) {
    for (int x = 0; x < kMapStride; ++x) {
      nearest = std::min(nearest, patch(column * kMapStride + x, row * kMapStride + y));
    }
  }
  return nearest;
}

/// The cells that vote: those that are hand; all where none is.
std::vector<Cell> voting_cells(const FeatureMap& votes, const Image<float>& patch) {
  const double half = 0.5 * (patch.width() - 1);
  const auto centre = [&](int cell) {
    return static_cast<float>((cell * kMapStride + 0.5 * (kMapStride - 1) - half) / half);
  };
  std::vector<Cell> cells;
  for (int row = 0; row < votes.height(); ++row) {
    for (int column = 0; column < votes.width(); ++column) {
      cells.push_back(
          {centre(column), centre(row), nearest_depth(patch, row, column), votes.pixel(row, column)});
    }
  }
  const auto is_background = [](const Cell& cell) { return cell.d >= kCubeBackground; };
  if (!std::ranges::all_of(cells, is_background)) std::erase_if(cells, is_background);
  return cells;
}

double mean_of_map(const std::vector<Cell>& cells, int map) {
  double sum = 0.0;
  for (const Cell& cell : cells) sum += cell.channels[map];
  return sum / static_cast<double>(cells.size());
}

/// All numbers of all joints, so that one loop works on several joints at a time.
struct JointSums {
  explicit JointSums(int joints) : u(joints), v(joints), d(joints) {}
  std::vector<float> u, v, d;
};

class VoteAggregation {
 public:
  VoteAggregation(std::vector<Cell> cells, int joints, double kernel)
      : cells_(std::move(cells)), joints_(joints), kernel_(static_cast<float>(kernel)) {}

  NetworkPrediction aggregate() {
    weigh();
    const JointSums mean = means();
    const std::vector<float> squares = variances(mean);
    NetworkPrediction prediction;
    for (int j = 0; j < joints_; ++j) {
      prediction.joints.push_back({mean.u[j], mean.v[j], mean.d[j]});
      const double spread = std::sqrt(static_cast<double>(squares[j]));
      prediction.confidence.push_back(static_cast<float>(std::exp(-spread / kSpreadScale)));
    }
    return prediction;
  }

 private:
  /// The softmax over the cells.
  void weigh() {
    std::vector<float> largest(cells_[0].channels + 4 * joints_, cells_[0].channels + 5 * joints_);
    for (const Cell& cell : cells_) {
      for (int j = 0; j < joints_; ++j) largest[j] = std::max(largest[j], cell.channels[4 * joints_ + j]);
    }
    std::vector<float> sums(joints_);
    weights_.resize(cells_.size() * joints_);
    float* weight = weights_.data();
    for (const Cell& cell : cells_) {
      for (int j = 0; j < joints_; ++j) weight[j] = std::exp(cell.channels[4 * joints_ + j] - largest[j]);
      for (int j = 0; j < joints_; ++j) sums[j] += weight[j];
      weight += joints_;
    }
    for (float& sum : sums) sum = 1.0f / sum;
    for (weight = weights_.data(); weight != weights_.data() + weights_.size(); weight += joints_) {
      for (int j = 0; j < joints_; ++j) weight[j] *= sums[j];
    }
  }

  JointSums means() const {
    JointSums mean(joints_);
    const float* weight = weights_.data();
    for (const Cell& cell : cells_) {
      for (int j = 0; j < joints_; ++j) {
        const float* const channel = cell.channels + j;
        const float reach = (1.0f - channel[3 * joints_]) * kernel_;
        mean.u[j] += weight[j] * (cell.u + channel[0] * reach);
        mean.v[j] += weight[j] * (cell.v + channel[joints_] * reach);
        mean.d[j] += weight[j] * (cell.d + channel[2 * joints_] * reach);
      }
      weight += joints_;
    }
    return mean;
  }

  /// Mean squared distances of the votes from their mean.
  std::vector<float> variances(const JointSums& mean) const {
    std::vector<float> squares(joints_);
    const float* weight = weights_.data();
    for (const Cell& cell : cells_) {
      for (int j = 0; j < joints_; ++j) {
        const float* const channel = cell.channels + j;
        const float reach = (1.0f - channel[3 * joints_]) * kernel_;
        const float u = cell.u + channel[0] * reach - mean.u[j];
        const float v = cell.v + channel[joints_] * reach - mean.v[j];
        const float d = cell.d + channel[2 * joints_] * reach - mean.d[j];
        squares[j] += weight[j] * (u * u + v * v + d * d);
      }
      weight += joints_;
    }
    return squares;
  }

  std::vector<Cell> cells_;
  int joints_;
  float kernel_;
  std::vector<float> weights_;  // cells x joints
};

}  // namespace

NetworkPrediction aggregate_votes(const FeatureMap& votes, const Image<float>& patch, int joint_count,
                                  const DenseMaps& maps, double kernel) {
  std::vector<Cell> cells = voting_cells(votes, patch);
  std::optional<double> right_hand;
  std::optional<double> hand;
  if (maps.side) right_hand = logistic(mean_of_map(cells, *maps.side));
  if (maps.hand) hand = logistic(mean_of_map(cells, *maps.hand));
  NetworkPrediction prediction = VoteAggregation(std::move(cells), joint_count, kernel).aggregate();
  prediction.right_hand = right_hand;
  prediction.hand = hand;
  return prediction;
}

}  // namespace knuckle
