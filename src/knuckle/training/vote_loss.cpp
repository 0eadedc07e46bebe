// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/vote_loss.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <torch/autograd.h>
#include <torch/utils.h>

#include "knuckle/net/dense_architecture.h"
#include "knuckle/patch/cube_patch.h"

namespace knuckle {
namespace {

constexpr auto kBeta = static_cast<float>(kVoteLossSmoothness);
constexpr float kSmallestDistance = 1e-6f;

using Vector = std::array<float, 3>;

float length_of(const Vector& v) {
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

float smooth_l1(float x) {
  const float size = std::abs(x);
  return size < kBeta ? 0.5f * x * x / kBeta : size - 0.5f * kBeta;
}

float smooth_l1_slope(float x) {
  return std::clamp(x / kBeta, -1.0f, 1.0f);
}

/// What the sums of the loss are divided by: how many numbers count.
struct Divisors {
  double joints = 0.0;
  double votes = 0.0;
};

/// One sample of a batch: pointers to its numbers, pixel by pixel.
class Sample {
 public:
  Sample(const float* points, const float* channels, int64_t channel_count, const float* joints,
         int64_t cells, int64_t joint_count, const VoteLossOptions& options)
      : channels_(channels),
        channel_count_(channel_count),
        joints_(joints),
        joint_count_(joint_count),
        kernel_(static_cast<float>(options.kernel)),
        dense_weight_(static_cast<float>(options.dense_weight)) {
    for (int64_t i = 0; i < cells; ++i) {
      const Cell cell{{points[i], points[cells + i], points[2 * cells + i]}, i};
      if (cell.point[2] < kCubeBackground) cells_.push_back(cell);
    }
    has_hand_ = !cells_.empty();
    for (int64_t i = 0; !has_hand_ && i < cells; ++i) {
      cells_.push_back({{points[i], points[cells + i], points[2 * cells + i]}, i});
    }
    weights_.resize(cells_.size());
  }

  void count(Divisors& divisors) const {
    for (int64_t j = 0; j < joint_count_; ++j) {
      if (!is_known(j)) continue;
      divisors.joints += 3.0;
      for (const Cell& cell : cells_) divisors.votes += is_within_kernel(cell, j) ? 1.0 : 0.0;
    }
  }

  /// The sample's part of the loss; `gradients` (0 before) becomes that in `channels`.
  double add_gradients(const Divisors& divisors, float* gradients) {
    double loss = 0.0;
    for (int64_t j = 0; j < joint_count_; ++j) {
      if (!is_known(j)) continue;
      weigh(j);
      const Vector joint = mean_vote(j);
      Vector slope;
      for (std::size_t k = 0; k < 3; ++k) {
        const float error = joint[k] - truth(j)[k];
        loss += smooth_l1(error) / divisors.joints;
        slope[k] = static_cast<float>(smooth_l1_slope(error) / divisors.joints);
      }
      for (std::size_t i = 0; i < cells_.size(); ++i) add_joint_gradient(i, j, joint, slope, gradients);
      if (dense_weight_ > 0.0f) loss += dense_weight_ * add_vote_gradients(j, divisors, gradients);
    }
    return loss;
  }

 private:
  struct Cell {
    Vector point;
    int64_t place;
  };

  const float* truth(int64_t j) const { return joints_ + 3 * j; }
  bool is_known(int64_t j) const {
    return std::isfinite(truth(j)[0]) && std::isfinite(truth(j)[1]) && std::isfinite(truth(j)[2]);
  }
  /// Channel 0 to 2: the offset, 3: the closeness, 4: the weight.
  int64_t place(const Cell& cell, int64_t j, int64_t channel) const {
    return cell.place * channel_count_ + channel * joint_count_ + j;
  }
  float value(const Cell& cell, int64_t j, int64_t channel) const {
    return channels_[place(cell, j, channel)];
  }
  Vector to_truth(const Cell& cell, int64_t j) const {
    return {truth(j)[0] - cell.point[0], truth(j)[1] - cell.point[1], truth(j)[2] - cell.point[2]};
  }
  bool is_within_kernel(const Cell& cell, int64_t j) const {
    return has_hand_ && std::max(length_of(to_truth(cell, j)), kSmallestDistance) < kernel_;
  }
  Vector vote(const Cell& cell, int64_t j) const {
    const float reach = (1.0f - value(cell, j, 3)) * kernel_;
    return {cell.point[0] + value(cell, j, 0) * reach, cell.point[1] + value(cell, j, 1) * reach,
            cell.point[2] + value(cell, j, 2) * reach};
  }

  /// The softmax of a joint's weights.
  void weigh(int64_t j) {
    float largest = value(cells_[0], j, 4);
    for (const Cell& cell : cells_) largest = std::max(largest, value(cell, j, 4));
    float sum = 0.0f;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      weights_[i] = std::exp(value(cells_[i], j, 4) - largest);
      sum += weights_[i];
    }
    for (float& weight : weights_) weight /= sum;
  }

  Vector mean_vote(int64_t j) const {
    Vector mean{};
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const Vector each = vote(cells_[i], j);
      for (std::size_t k = 0; k < 3; ++k) mean[k] += weights_[i] * each[k];
    }
    return mean;
  }

  /// Of the joint's distance.
  void add_joint_gradient(std::size_t i, int64_t j, const Vector& joint, const Vector& slope,
                          float* gradients) const {
    const Cell& cell = cells_[i];
    const float reach = (1.0f - value(cell, j, 3)) * kernel_;
    const Vector each = vote(cell, j);
    float along_offset = 0.0f;
    float along_vote = 0.0f;
    for (int64_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<std::size_t>(k);
      gradients[place(cell, j, k)] += weights_[i] * reach * slope[axis];
      along_offset += value(cell, j, k) * slope[axis];
      along_vote += (each[axis] - joint[axis]) * slope[axis];
    }
    gradients[place(cell, j, 3)] -= weights_[i] * kernel_ * along_offset;
    gradients[place(cell, j, 4)] += weights_[i] * along_vote;
  }

  /// Of offsets and closenesses; the loss of both.
  double add_vote_gradients(int64_t j, const Divisors& divisors, float* gradients) const {
    const double votes = std::max(divisors.votes, 1.0);
    const double numbers = std::max(3.0 * divisors.votes, 1.0);
    double loss = 0.0;
    for (const Cell& cell : cells_) {
      if (!is_within_kernel(cell, j)) continue;
      const Vector difference = to_truth(cell, j);
      const float distance = std::max(length_of(difference), kSmallestDistance);
      for (int64_t k = 0; k < 3; ++k) {
        const float error = value(cell, j, k) - difference[static_cast<std::size_t>(k)] / distance;
        loss += smooth_l1(error) / numbers;
        gradients[place(cell, j, k)] += dense_weight_ * static_cast<float>(smooth_l1_slope(error) / numbers);
      }
      const float error = value(cell, j, 3) - (1.0f - distance / kernel_);
      loss += smooth_l1(error) / votes;
      gradients[place(cell, j, 3)] += dense_weight_ * static_cast<float>(smooth_l1_slope(error) / votes);
    }
    return loss;
  }

  const float* channels_;
  int64_t channel_count_;
  const float* joints_;
  int64_t joint_count_;
  float kernel_;
  float dense_weight_;
  std::vector<Cell> cells_;  // those that vote: hand, or all where none is
  bool has_hand_ = false;
  std::vector<float> weights_;
};

class VoteLoss final : public torch::autograd::Function<VoteLoss> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& any_output,
                               const torch::Tensor& any_points, const torch::Tensor& any_joints,
                               const VoteLossOptions& options) {
    const torch::Tensor output = any_output.contiguous(torch::MemoryFormat::ChannelsLast);
    const torch::Tensor points = any_points.contiguous();
    const torch::Tensor joints = any_joints.contiguous();
    const int64_t joint_count = joints.size(1);
    const int64_t cells = output.size(2) * output.size(3);
    std::vector<Sample> samples;
    Divisors divisors;
    for (int64_t n = 0; n < output.size(0); ++n) {
      samples.emplace_back(points.data_ptr<float>() + n * 3 * cells,
                           output.data_ptr<float>() + n * output.size(1) * cells, output.size(1),
                           joints.data_ptr<float>() + n * 3 * joint_count, cells, joint_count, options);
      samples.back().count(divisors);
    }
    torch::Tensor gradient = torch::zeros_like(output);
    double loss = 0.0;
    for (int64_t n = 0; n < output.size(0); ++n) {
      loss += samples[static_cast<std::size_t>(n)].add_gradients(
          divisors, gradient.data_ptr<float>() + n * output.size(1) * cells);
    }
    context->save_for_backward({gradient});
    return torch::tensor(static_cast<float>(loss));
  }

  static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                               const torch::autograd::tensor_list& loss_gradients) {
    const torch::Tensor gradient = context->get_saved_variables()[0];
    return {gradient * loss_gradients[0], torch::Tensor(), torch::Tensor(), torch::Tensor()};
  }
};

}  // namespace

torch::Tensor vote_loss(const torch::Tensor& output, const torch::Tensor& points, const torch::Tensor& joints,
                        const VoteLossOptions& options) {
  return VoteLoss::apply(output, points, joints, options);
}

}  // namespace knuckle
