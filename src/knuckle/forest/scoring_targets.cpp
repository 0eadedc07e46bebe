// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/scoring_targets.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/symmetric_eigen.h"

namespace knuckle {

namespace {

constexpr double kLargest = 16383.0;
/// Rows summed in one go; fixed, so that sums do not depend on the number of threads.
constexpr std::int64_t kRowsPerChunk = 4096;

using Weights = Eigen::VectorXd;

Eigen::VectorXd weighted_row(const TrainingSamples& samples, std::uint32_t sample, const Weights& weights) {
  const std::span<const float> targets = samples.targets(sample);
  return Eigen::Map<const Eigen::VectorXf>(targets.data(), std::ssize(targets))
      .cast<double>()
      .cwiseProduct(weights);
}

/// Sums `term(sample)` over the samples: chunks in parallel, then their sums in order.
template <class Term>
Eigen::MatrixXd ordered_sum(std::span<const std::uint32_t> order, const Eigen::MatrixXd& zero, Term term) {
  const std::int64_t chunks = (std::ssize(order) + kRowsPerChunk - 1) / kRowsPerChunk;
  std::vector<Eigen::MatrixXd> sums(static_cast<std::size_t>(chunks), zero);
  parallel_for(chunks, [&](std::int64_t chunk) {
    const std::int64_t end = std::min(std::ssize(order), (chunk + 1) * kRowsPerChunk);
    for (std::int64_t i = chunk * kRowsPerChunk; i < end; ++i) {
      term(order[static_cast<std::size_t>(i)], sums[static_cast<std::size_t>(chunk)]);
    }
  });
  Eigen::MatrixXd total = zero;
  for (const Eigen::MatrixXd& sum : sums) total += sum;
  return total;
}

/// The linear map from centred, weighted targets to scoring dimensions, one row per dimension.
struct Projection {
  Eigen::VectorXd mean;
  Eigen::MatrixXd rows;
  double captured_variance = 1.0;
};

Projection principal_components(const TrainingSamples& samples, std::span<const std::uint32_t> order,
                                const Weights& weights, int most_dimensions) {
  const Eigen::Index targets = samples.target_count();
  Projection projection;
  projection.mean = ordered_sum(order, Eigen::VectorXd::Zero(targets),
                                [&](std::uint32_t sample, Eigen::MatrixXd& sum) {
                                  sum += weighted_row(samples, sample, weights);
                                }) /
                    static_cast<double>(order.size());
  projection.rows = Eigen::MatrixXd::Identity(targets, targets);
  if (targets <= most_dimensions) return projection;
  const Eigen::MatrixXd scatter = ordered_sum(
      order, Eigen::MatrixXd::Zero(targets, targets), [&](std::uint32_t sample, Eigen::MatrixXd& sum) {
        const Eigen::VectorXd row = weighted_row(samples, sample, weights) - projection.mean;
        sum.selfadjointView<Eigen::Lower>().rankUpdate(row);
      });
  const SymmetricEigen eigen = symmetric_eigen(scatter);
  projection.rows = eigen.vectors.rightCols(most_dimensions).transpose();
  const double total = eigen.values.cwiseMax(0.0).sum();
  if (total > 0.0) {
    projection.captured_variance = eigen.values.tail(most_dimensions).cwiseMax(0.0).sum() / total;
  }
  return projection;
}

Weights checked_weights(const TrainingSamples& samples, std::span<const double> weights) {
  if (weights.empty()) return Weights::Ones(samples.target_count());
  if (std::ssize(weights) != samples.target_count()) {
    fail("forest training: {} target weights, expected one for each of {} targets", weights.size(),
         samples.target_count());
  }
  for (const double weight : weights) {
    if (!(weight >= 0.0 && std::isfinite(weight)))
      fail("forest training: target weight {} is not in [0, inf)", weight);
  }
  return Eigen::Map<const Weights>(weights.data(), std::ssize(weights));
}

}  // namespace

ScoringTargets make_scoring_targets(const TrainingSamples& samples, std::span<const std::uint32_t> order,
                                    std::span<const double> weights, int most_dimensions) {
  const Weights factors = checked_weights(samples, weights);
  const Projection projection = principal_components(samples, order, factors, most_dimensions);
  const Eigen::Index dimensions = projection.rows.rows();
  Eigen::MatrixXf projected(dimensions, std::ssize(order));
  parallel_for(std::ssize(order), [&](std::int64_t i) {
    const Eigen::VectorXd row =
        weighted_row(samples, order[static_cast<std::size_t>(i)], factors) - projection.mean;
    projected.col(i) = (projection.rows * row).cast<float>();
  });

  ScoringTargets scoring;
  scoring.dimensions = static_cast<int>(dimensions);
  scoring.captured_variance = projection.captured_variance;
  scoring.values.resize(static_cast<std::size_t>(samples.capacity() * dimensions));
  const double largest = projected.size() > 0 ? static_cast<double>(projected.cwiseAbs().maxCoeff()) : 0.0;
  if (largest > 0.0) scoring.step = static_cast<float>(largest / kLargest);
  for (Eigen::Index i = 0; i < projected.cols(); ++i) {
    std::int16_t* row = scoring.values.data() + order[static_cast<std::size_t>(i)] * dimensions;
    for (Eigen::Index d = 0; d < dimensions; ++d) {
      row[d] = static_cast<std::int16_t>(
          std::lround(std::clamp(projected(d, i) / static_cast<double>(scoring.step), -kLargest, kLargest)));
    }
  }
  return scoring;
}

}  // namespace knuckle
