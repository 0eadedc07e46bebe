// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/scoring_targets.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/symmetric_eigen.h"
#include "knuckle/core/worker_messages.h"

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

/// A sum of rows on its way: that of whole chunks, and of the rows of the chunk that is not whole.
struct RunningSum {
  Eigen::MatrixXd whole;
  Eigen::MatrixXd open;
  std::int64_t rows = 0;  // so far

  void add(const Eigen::MatrixXd& part, std::int64_t count) {
    rows += count;
    if (rows % kRowsPerChunk == 0) {
      whole += part;
      open.setZero();
    } else {
      open = part;
    }
  }
  Eigen::MatrixXd total() const { return rows % kRowsPerChunk == 0 ? whole : Eigen::MatrixXd(whole + open); }
};

/// Sums of the rows that one worker has: of those that fill up the chunk of the worker before, and of each
/// further chunk.
template <class Term>
class SumOfRows {
 public:
  SumOfRows(const SamplesInOrder& samples, const Eigen::MatrixXd& zero, const Term& term)
      : samples_(samples), term_(term) {
    const std::int64_t begin = samples.count.before;
    const std::int64_t end = begin + std::ssize(samples.order);
    head_ = begin % kRowsPerChunk == 0
                ? 0
                : std::min(kRowsPerChunk - begin % kRowsPerChunk, std::ssize(samples.order));
    const std::int64_t chunks = (end - begin - head_ + kRowsPerChunk - 1) / kRowsPerChunk;
    sums_.assign(static_cast<std::size_t>(chunks), zero);
    parallel_for(chunks, [&](std::int64_t chunk) {
      const std::int64_t first = head_ + chunk * kRowsPerChunk;
      add_rows(first, std::min(std::ssize(samples_.order), first + kRowsPerChunk),
               sums_[static_cast<std::size_t>(chunk)]);
    });
  }

  /// Goes on with the sum of the rows before.
  void add_to(RunningSum& sum) const {
    if (head_ > 0) {
      Eigen::MatrixXd part = sum.open;
      add_rows(0, head_, part);
      sum.add(part, head_);
    }
    std::int64_t first = head_;
    for (const Eigen::MatrixXd& chunk : sums_) {
      const std::int64_t rows = std::min(kRowsPerChunk, std::ssize(samples_.order) - first);
      sum.add(chunk, rows);
      first += rows;
    }
  }

 private:
  void add_rows(std::int64_t first, std::int64_t end, Eigen::MatrixXd& sum) const {
    for (std::int64_t i = first; i < end; ++i) term_(samples_.order[static_cast<std::size_t>(i)], sum);
  }

  const SamplesInOrder& samples_;
  const Term& term_;
  std::int64_t head_ = 0;  // rows that belong to the chunk of the worker before
  std::vector<Eigen::MatrixXd> sums_;
};

std::vector<std::byte> as_message(const RunningSum& sum) {
  std::vector<std::byte> message;
  append_values(message,
                std::span<const double>(sum.whole.data(), static_cast<std::size_t>(sum.whole.size())));
  append_values(message, std::span<const double>(sum.open.data(), static_cast<std::size_t>(sum.open.size())));
  append_value(message, sum.rows);
  return message;
}

void read_message(std::span<const std::byte> message, RunningSum& sum) {
  MessageReader reader(message);
  reader.read(std::span(sum.whole.data(), static_cast<std::size_t>(sum.whole.size())));
  reader.read(std::span(sum.open.data(), static_cast<std::size_t>(sum.open.size())));
  sum.rows = reader.value<std::int64_t>();
  if (sum.rows < 0 || !sum.whole.allFinite() || !sum.open.allFinite())
    fail("a worker's message: a sum of {} rows that is no number", sum.rows);
}

/// Sums `term(sample)` over the samples of all workers: chunks in parallel, then their sums in order. The
/// workers go on with the sum one after another.
template <class Term>
Eigen::MatrixXd ordered_sum(const SamplesInOrder& samples, const Eigen::MatrixXd& zero, const Term& term) {
  const SumOfRows<Term> own(samples, zero, term);
  RunningSum sum{.whole = zero, .open = zero};
  if (samples.workers == nullptr) {
    own.add_to(sum);
    return sum.total();
  }
  WorkerGroup& workers = *samples.workers;
  for (int turn = 0; turn < workers.size(); ++turn) {
    OwnMessages sent(static_cast<std::size_t>(workers.size()));
    if (turn == workers.rank()) {
      own.add_to(sum);
      std::ranges::fill(sent, as_message(sum));
    }
    read_message(exchanged(workers, std::move(sent)).parts[static_cast<std::size_t>(turn)], sum);
  }
  return sum.total();
}

std::int64_t count_of_all(const SamplesInOrder& samples) {
  return samples.workers == nullptr ? std::ssize(samples.order) : samples.count.total;
}

/// The linear map from centred, weighted targets to scoring dimensions, one row per dimension.
struct Projection {
  Eigen::VectorXd mean;
  Eigen::MatrixXd rows;
  double captured_variance = 1.0;
};

Projection principal_components(const TrainingSamples& samples, const SamplesInOrder& order,
                                const Weights& weights, int most_dimensions) {
  const Eigen::Index targets = samples.target_count();
  Projection projection;
  projection.mean = ordered_sum(order, Eigen::VectorXd::Zero(targets),
                                [&](std::uint32_t sample, Eigen::MatrixXd& sum) {
                                  sum += weighted_row(samples, sample, weights);
                                }) /
                    static_cast<double>(count_of_all(order));
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

ScoringTargets make_scoring_targets(const TrainingSamples& samples, const SamplesInOrder& rows,
                                    std::span<const double> weights, int most_dimensions) {
  const Weights factors = checked_weights(samples, weights);
  const Projection projection = principal_components(samples, rows, factors, most_dimensions);
  const Eigen::Index dimensions = projection.rows.rows();
  const std::span<const std::uint32_t> order = rows.order;
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
  double largest = projected.size() > 0 ? static_cast<double>(projected.cwiseAbs().maxCoeff()) : 0.0;
  if (rows.workers != nullptr) {
    largest = std::ranges::max(values_of_all(*rows.workers, largest));
    if (!std::isfinite(largest)) fail("a worker's message: a largest target of {}", largest);
  }
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
