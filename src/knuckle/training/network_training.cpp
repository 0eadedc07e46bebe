// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/network_training.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <torch/cuda.h>
#include <torch/types.h>
#include <torch/utils.h>

#include "knuckle/core/error.h"
#include "knuckle/core/progress.h"
#include "knuckle/net/network_file.h"
#include "knuckle/training/archive.h"
#include "knuckle/training/network_validation.h"
#include "knuckle/training/network_writer.h"
#include "knuckle/training/norm_statistics.h"
#include "knuckle/training/optimiser.h"
#include "knuckle/training/sharded_network.h"
#include "knuckle/training/torch_threads.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 2> kOptimisers = {"adamw", "sgd"};
constexpr std::string_view kCheckpointFormat = "knuckle-network-checkpoint";
constexpr int kCheckpointVersion = 2;
constexpr int64_t kMetricsColumns = 8;
/// A young average forgets sooner: its decay is at most (1 + step) / (10 + step).
constexpr double kAverageDelay = 10.0;
/// Batches that the averaged network's norms are measured over.
constexpr int kNormBatches = 40;

torch::Device device_of(const std::string& name) {
  if (name == "cpu") return {torch::kCPU};
  if (name != "cuda") fail("device is \"{}\", expected cpu or cuda", name);
  if (!torch::cuda::is_available()) fail("device cuda: this LibTorch has none");
  return {torch::kCUDA};
}

torch::Tensor as_tensor(const std::vector<TrainingMetrics>& metrics) {
  std::vector<double> values;
  for (const TrainingMetrics& m : metrics) {
    values.insert(values.end(), {static_cast<double>(m.step), static_cast<double>(m.samples), m.learning_rate,
                                 m.training_loss, m.validation.first_mm, m.validation.second_mm,
                                 m.samples_per_second, m.waiting_share});
  }
  return torch::tensor(values, torch::kDouble).view({-1, kMetricsColumns});
}

std::vector<TrainingMetrics> metrics_of(const torch::Tensor& tensor) {
  std::vector<TrainingMetrics> metrics;
  const torch::Tensor values = tensor.contiguous();
  for (int64_t i = 0; i < values.size(0); ++i) {
    const double* const v = values.data_ptr<double>() + i * kMetricsColumns;
    metrics.push_back({static_cast<std::int64_t>(v[0]),
                       static_cast<std::int64_t>(v[1]),
                       v[2],
                       v[3],
                       {v[4], v[5]},
                       v[6],
                       v[7]});
  }
  return metrics;
}

/// Seconds since it was made, without those in which it was stopped.
class Clock {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  void restart() { start_ = std::chrono::steady_clock::now(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Keeps what is freed for the next allocation. The paper's networks take and free gradients of 200 MB in
/// each step; glibc would give these back to the system, and faulting their pages in again would take a third
/// of the time.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

class Trainer {
 public:
  Trainer(const NetworkOptions& network, const NetworkTrainingOptions& options,
          const AugmentationOptions& augmentation, const CubeSamples& training, const CubeSamples& validation,
          const NetworkTrainingRun& run)
      : network_options_(network),
        options_(options),
        augmentation_(augmentation),
        training_(training),
        validation_(validation),
        run_(run),
        device_(device_of(run.device)),
        step_count_(steps_of(training.size(), options)),
        network_(network, options.seed, options.shards, device_),
        averaged_(make_network(network, options.seed)),
        optimiser_(network_.parameters(), on_device(*averaged_, device_).parameters(), options) {
    averaged_->eval();
  }

  std::vector<TrainingMetrics> train() {
    if (run_.begin == NetworkTrainingRun::Begin::from_checkpoint) {
      load_checkpoint();
    } else if (!run_.initial.empty()) {
      load_initial();
    }
    const std::int64_t end =
        run_.stop_after_steps > 0 ? std::min(run_.stop_after_steps, step_count_) : step_count_;
    if (step_ >= end || has_run_out_of_patience()) return metrics_;
    BatchPlan plan(training_, augmentation_, options_.batch_size, options_.seed);
    BatchLoader loader(std::move(plan), step_, end);
    Progress shown("train", "samples", (end - step_) * options_.batch_size);
    bool is_done = false;
    while (!is_done) {
      step(loader);
      shown.advance(options_.batch_size);
      is_done = step_ == end || time_share() >= 1.0;
      if (step_ % options_.validate_every == 0 || is_done) validate(loader);
      is_done = is_done || has_run_out_of_patience();
    }
    return metrics_;
  }

 private:
  static NetworkModule& on_device(NetworkModule& network, const torch::Device& device) {
    network.to(device);
    return network;
  }

  static std::int64_t steps_of(std::int64_t samples, const NetworkTrainingOptions& options) {
    return static_cast<std::int64_t>(
        std::ceil(options.epochs * static_cast<double>(samples) / options.batch_size));
  }

  double time_share() const {
    return run_.minutes > 0.0 ? whole_time_.seconds() / (60.0 * run_.minutes) : 0.0;
  }

  /// How much of the training will be done behind the next step.
  double progress() const {
    const double steps = static_cast<double>(step_ + 1) / static_cast<double>(step_count_);
    return std::min(1.0, std::max(steps, time_share()));
  }

  void step(BatchLoader& loader) {
    TrainingBatch batch = loader.next();
    const double rate = learning_rate_at(options_.learning_rate, progress());
    const double loss =
        network_.backward(batch, derived_seed(options_.seed, static_cast<std::uint64_t>(step_)));
    const double norm = optimiser_.gradient_norm();
    if (!std::isfinite(loss) || !std::isfinite(norm)) {
      const std::string kept = metrics_.empty() ? std::string("nothing was written yet")
                                                : fmt::format("{} keeps the state of step {}",
                                                              run_.checkpoint.string(), metrics_.back().step);
      fail("training: the loss is {} and the gradient's norm {} at step {}, try a smaller learning_rate; {}",
           loss, norm, step_, kept);
    }
    ++step_;
    optimiser_.step({rate, scale_for(norm), decay_of_average()});
    loss_sum_ += loss;
    ++loss_count_;
  }

  /// Shortens a gradient that is longer than `gradient_clip`.
  double scale_for(double norm) const {
    const double limit = options_.gradient_clip;
    return limit > 0.0 && norm > limit ? limit / norm : 1.0;
  }

  double decay_of_average() const {
    const auto steps = static_cast<double>(step_);
    return std::min(options_.average_decay, (1.0 + steps) / (kAverageDelay + steps));
  }

  void validate(const BatchLoader& loader) {
    const torch::NoGradGuard no_gradient;
    const BatchPlan plan(training_, augmentation_, options_.batch_size, options_.seed);
    measure_norm_statistics(*averaged_, plan, kNormBatches, device_);

    TrainingMetrics metrics;
    const double seconds = clock_.seconds();
    metrics.step = step_;
    metrics.samples = step_ * options_.batch_size;
    metrics.learning_rate = learning_rate_at(options_.learning_rate, progress());
    metrics.training_loss = loss_sum_ / static_cast<double>(loss_count_);
    metrics.samples_per_second = static_cast<double>(loss_count_ * options_.batch_size) / seconds;
    metrics.waiting_share = (loader.waited_seconds() - waited_before_) / seconds;
    metrics.validation = validation_errors(*averaged_, validation_, device_);
    if (is_best(metrics)) save_network(run_.model, network_options_, *averaged_);
    metrics_.push_back(metrics);
    save_checkpoint();
    if (run_.report) run_.report(metrics_);
    loss_sum_ = 0.0;
    loss_count_ = 0;
    waited_before_ = loader.waited_seconds();
    clock_.restart();
  }

  bool is_best(const TrainingMetrics& metrics) const {
    if (!std::isfinite(metrics.validation.second_mm)) return false;
    return std::ranges::all_of(metrics_, [&](const TrainingMetrics& before) {
      return !(before.validation.second_mm <= metrics.validation.second_mm);
    });
  }

  bool has_run_out_of_patience() const {
    if (options_.patience == 0 || metrics_.empty()) return false;
    const auto error = [](const TrainingMetrics& m) { return m.validation.second_mm; };
    const auto best = std::ranges::min_element(metrics_, {}, error);
    return metrics_.end() - best > options_.patience;
  }

  /// What must be the same for a training to go on.
  std::string identity() const {
    return network_options_as_toml(network_options_) + "[training]\n" + options_as_toml(options_) +
           "[augmentation]\n" + options_as_toml(augmentation_) +
           fmt::format("[data]\nsamples = {}\ninitial = \"{}\"\n", training_.size(),
                       run_.initial.filename().string());
  }

  /// Begins with another training's weights: for more samples, or the user's own.
  void load_initial() {
    const torch::NoGradGuard no_gradient;
    const NetworkWeights initial = load_network_weights(run_.initial);
    if (network_options_as_toml(initial.options()) != network_options_as_toml(network_options_)) {
      fail("{}: training cannot begin with it: its [network] or [patch] differs from the configuration's",
           run_.initial.string());
    }
    set_weights(*averaged_, initial);
    const auto copy = [](const std::vector<torch::Tensor>& from, const std::vector<torch::Tensor>& to) {
      for (std::size_t i = 0; i < to.size(); ++i) to[i].copy_(from[i]);
    };
    copy(averaged_->parameters(), network_.parameters());
    copy(averaged_->buffers(), network_.buffers());
    network_.share_buffers();
  }

  void save_checkpoint() {
    ArchiveWriter archive(kCheckpointFormat, kCheckpointVersion);
    archive.write("identity", identity());
    archive.write("step", static_cast<double>(step_));
    archive.write("parameters", network_.parameters());
    archive.write("buffers", network_.buffers());
    archive.write("averages", averaged_->parameters());
    archive.write("metrics", std::vector<torch::Tensor>{as_tensor(metrics_)});
    archive.write("moments", optimiser_.moments());
    archive.save(run_.checkpoint);
  }

  void load_checkpoint() {
    ArchiveReader archive(run_.checkpoint, kCheckpointFormat, kCheckpointVersion);
    if (archive.text("identity") != identity()) {
      fail("{}: the checkpoint is of a training with other options or another number of samples",
           run_.checkpoint.string());
    }
    archive.copy_into("parameters", network_.parameters());
    archive.copy_into("buffers", network_.buffers());
    network_.share_buffers();
    archive.copy_into("averages", averaged_->parameters());
    const std::vector<torch::Tensor> metrics = archive.tensors("metrics");
    if (metrics.size() != 1) fail("{}: the metrics are missing", run_.checkpoint.string());
    metrics_ = metrics_of(metrics.front());
    archive.copy_into("moments", optimiser_.moments());
    step_ = static_cast<std::int64_t>(archive.number("step"));
    optimiser_.set_steps(step_);
  }

  NetworkOptions network_options_;
  NetworkTrainingOptions options_;
  AugmentationOptions augmentation_;
  const CubeSamples& training_;
  const CubeSamples& validation_;
  NetworkTrainingRun run_;
  torch::Device device_;
  std::int64_t step_count_;
  ShardedNetwork network_;
  std::shared_ptr<NetworkModule> averaged_;
  Optimiser optimiser_;
  std::int64_t step_ = 0;
  std::vector<TrainingMetrics> metrics_;
  double loss_sum_ = 0.0;
  std::int64_t loss_count_ = 0;
  double waited_before_ = 0.0;
  Clock clock_;
  Clock whole_time_;
};

}  // namespace

void NetworkTrainingOptions::visit(OptionVisitor& visitor) {
  visitor.real("epochs", epochs, open_closed(0, 1e6));
  visitor.integer("batch_size", batch_size, closed(1, 65536));
  visitor.integer("shards", shards, closed(1, 256));
  visitor.choice("optimiser", optimiser, kOptimisers);
  visitor.real("momentum", momentum, closed_open(0, 1));
  visitor.real("weight_decay", weight_decay, closed(0, 1));
  visitor.real("gradient_clip", gradient_clip, closed(0, 1e6));
  visitor.real("average_decay", average_decay, closed_open(0, 1));
  learning_rate.visit(visitor);
  visitor.integer("validate_every", validate_every, closed(1, 1e9));
  visitor.integer("patience", patience, closed(0, 1e6));
  visitor.seed("seed", seed);
}

std::string metrics_csv(const std::vector<TrainingMetrics>& metrics) {
  std::string csv =
      "step,samples,learning_rate,training_loss,validation_first_mm,validation_second_mm,samples_per_second,"
      "waiting_share\n";
  for (const TrainingMetrics& m : metrics) {
    csv += fmt::format("{},{},{:.6g},{:.6g},{:.3f},{:.3f},{:.1f},{:.4f}\n", m.step, m.samples,
                       m.learning_rate, m.training_loss, m.validation.first_mm, m.validation.second_mm,
                       m.samples_per_second, m.waiting_share);
  }
  return csv;
}

std::vector<TrainingMetrics> train_network(const NetworkOptions& network,
                                           const NetworkTrainingOptions& options,
                                           const AugmentationOptions& augmentation,
                                           const CubeSamples& training, const CubeSamples& validation,
                                           const NetworkTrainingRun& run) {
  check(network, "training");
  check_options(options, "training");
  if (options.batch_size % options.shards != 0) {
    fail("training: batch_size is {}, expected a multiple of shards, {}", options.batch_size, options.shards);
  }
  if (options.batch_size == options.shards && network.architecture != "dense") {
    fail("training: batch_size is {} in {} shards, expected at least 2 samples a shard: the norms need them",
         options.batch_size, options.shards);
  }
  if (training.size() == 0) fail("training: there is no sample to train on");
  if (validation.size() == 0) fail("training: there is no sample to validate on");
  use_calling_thread_alone();
  keep_freed_memory();
  return with_clear_errors(
      "training", [&] { return Trainer(network, options, augmentation, training, validation, run).train(); });
}

}  // namespace knuckle
