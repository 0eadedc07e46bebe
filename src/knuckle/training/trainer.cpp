// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/trainer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include <torch/utils.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/progress.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/training/archive.h"
#include "knuckle/training/norm_statistics.h"
#include "knuckle/training/torch_device.h"

namespace knuckle {
namespace {

constexpr std::string_view kCheckpointFormat = "knuckle-network-checkpoint";
constexpr int kCheckpointVersion = 2;
constexpr std::size_t kFixedColumns = 6;  // of metrics, beside the numbers of the validation
/// A young average forgets sooner: its decay is at most (1 + step) / (10 + step).
constexpr double kAverageDelay = 10.0;
/// Batches that the averaged network's norms are measured over.
constexpr int kNormBatches = 40;

torch::Tensor as_tensor(const std::vector<TrainingMetrics>& metrics) {
  std::vector<double> values;
  for (const TrainingMetrics& m : metrics) {
    values.insert(values.end(), {static_cast<double>(m.step), static_cast<double>(m.samples), m.learning_rate,
                                 m.training_loss});
    values.insert(values.end(), m.validation.begin(), m.validation.end());
    values.insert(values.end(), {m.samples_per_second, m.waiting_share});
  }
  return torch::tensor(values, torch::kDouble).view({std::ssize(metrics), -1});
}

std::vector<TrainingMetrics> metrics_of(const torch::Tensor& tensor) {
  std::vector<TrainingMetrics> metrics;
  const torch::Tensor values = tensor.contiguous();
  const auto columns = static_cast<std::size_t>(values.size(1));
  for (int64_t i = 0; i < values.size(0); ++i) {
    const std::span<const double> v(values.data_ptr<double>() + i * values.size(1), columns);
    const auto scores = v.subspan(4, columns - kFixedColumns);
    metrics.push_back({static_cast<std::int64_t>(v[0]), static_cast<std::int64_t>(v[1]), v[2], v[3],
                       std::vector<double>(scores.begin(), scores.end()), v[columns - 2], v[columns - 1]});
  }
  return metrics;
}

TrainableModule& on_device(TrainableModule& network, const torch::Device& device) {
  network.to(device);
  return network;
}

std::string hash_of(const std::vector<float>& values) {
  return text_hash(
      std::string_view(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)));
}

std::string hash_of(const std::vector<torch::Tensor>& tensors) {
  std::string hashes;
  for (const torch::Tensor& tensor : tensors) {
    const torch::Tensor values = tensor.detach().cpu().contiguous();
    hashes += text_hash(std::string_view(static_cast<const char*>(values.data_ptr()), values.nbytes()));
  }
  return text_hash(hashes);
}

std::int64_t steps_of(std::int64_t samples, const NetworkTrainingOptions& options) {
  return static_cast<std::int64_t>(
      std::ceil(options.epochs * static_cast<double>(samples) / options.batch_size));
}

}  // namespace

Trainer::Trainer(const TrainingTask& task, const NetworkTrainingOptions& options,
                 const NetworkTrainingRun& run)
    : task_(task),
      options_(options),
      run_(run),
      device_(device_from_name(run.device, run.workers == nullptr ? 0 : run.workers->number_on_machine())),
      step_count_(steps_of(task.views()->size(), options)),
      network_(task, options.seed, options.shards, device_, run.workers),
      averaged_(task.make_module(options.seed)),
      optimiser_(network_.parameters(), on_device(*averaged_, device_).parameters(), options),
      end_(run.stop_after_steps > 0 ? std::min(run.stop_after_steps, step_count_) : step_count_) {
  averaged_->eval();
  if (options.precision == "bfloat16") network_.compute_in(torch::kBFloat16);
}

std::vector<TrainingMetrics> Trainer::train() {
  if (run_.begin == NetworkTrainingRun::Begin::from_checkpoint) {
    load_checkpoint();
  } else if (!run_.initial.empty()) {
    load_initial();
  }
  if (run_.workers != nullptr) agree();
  if (step_ >= end_ || has_run_out_of_patience(metrics_, options_)) {
    report_again();
    return metrics_;
  }
  BatchLoader loader(own_plan(), step_, end_);
  Progress shown("train", "samples", end_ * options_.batch_size, step_ * options_.batch_size);
  first_step_ = step_;
  whole_time_ = Stopwatch();
  since_validation_ = Stopwatch();
  bool is_done = false;
  while (!is_done) {
    look_at_time();
    step_unless_interrupted(loader);
    shown.advance(options_.batch_size);
    look_at_time();
    is_done = step_ == end_ || time_share_ >= 1.0;
    if (step_ % options_.validate_every == 0 || is_done) validate(loader);
    is_done = is_done || has_run_out_of_patience(metrics_, options_);
  }
  return metrics_;
}

/// A training may have ended after its last checkpoint, but before its last validation was reported.
void Trainer::report_again() const {
  if (is_first_worker() && run_.report && !metrics_.empty()) run_.report(metrics_, 0.0);
}

/// A step that is broken off changes no parameters, but the statistics of normalisation: the last checkpoint
/// is what a later run can go on from.
void Trainer::step_unless_interrupted(BatchLoader& loader) {
  try {
    end_if_interrupted();
    step(loader);
  } catch (const Interrupted&) {
    const std::string kept = metrics_.empty()
                                 ? std::string("nothing was written yet")
                                 : fmt::format("continue with --resume from step {}", metrics_.back().step);
    throw Interrupted(fmt::format("interrupted after {} of {} steps; {}", step_, step_count_, kept));
  }
}

BatchPlan Trainer::own_plan() const {
  BatchPlan plan(task_.views(), options_.batch_size, options_.seed);
  if (run_.workers == nullptr) return plan;
  const PartOfWork shards = part_of_worker(options_.shards, run_.workers->rank(), run_.workers->size());
  const int per_shard = options_.batch_size / options_.shards;
  return plan.part(static_cast<int>(shards.begin) * per_shard, static_cast<int>(shards.end) * per_shard);
}

void Trainer::agree() const {
  WorkerGroup& workers = *run_.workers;
  require_same(workers, "other options or another number of samples", identity());
  require_same(workers, "another checkpoint", fmt::format("{}", step_));
  BatchPlan plan(task_.views(), options_.batch_size, options_.seed);
  const TrainingBatch batch = plan.batch(step_);
  require_same(workers, "other samples", hash_of(batch.inputs) + hash_of(batch.targets));
  require_same(workers, "other weights", hash_of(network_.parameters()) + hash_of(averaged_->parameters()));
}

void Trainer::look_at_time() {
  if (run_.minutes <= 0.0) return;
  time_share_ = whole_time_.seconds() / (60.0 * run_.minutes);
  if (run_.workers == nullptr) return;
  const std::string said = from_first(
      *run_.workers, std::string_view(reinterpret_cast<const char*>(&time_share_), sizeof time_share_));
  std::memcpy(&time_share_, said.data(), sizeof time_share_);
}

double Trainer::progress() const {
  const double steps = static_cast<double>(step_ + 1) / static_cast<double>(step_count_);
  return std::min(1.0, std::max(steps, time_share_));
}

void Trainer::step(BatchLoader& loader) {
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

double Trainer::scale_for(double norm) const {
  const double limit = options_.gradient_clip;
  return limit > 0.0 && norm > limit ? limit / norm : 1.0;
}

double Trainer::decay_of_average() const {
  const auto steps = static_cast<double>(step_);
  return std::min(options_.average_decay, (1.0 + steps) / (kAverageDelay + steps));
}

void Trainer::validate(const BatchLoader& loader) {
  // Workers on machines that do not compute alike would drift apart, and nobody would see it.
  if (run_.workers != nullptr) require_same(*run_.workers, "other weights", hash_of(averaged_->parameters()));
  TrainingMetrics metrics;
  if (is_first_worker()) metrics = measured(loader);
  if (run_.workers != nullptr) metrics = shared(metrics);
  if (is_first_worker() && is_kept(metrics)) task_.save(run_.model, *averaged_);
  metrics_.push_back(metrics);
  if (is_first_worker()) {
    save_checkpoint();
    if (run_.report) run_.report(metrics_, seconds_left());
  }
  loss_sum_ = 0.0;
  loss_count_ = 0;
  waited_before_ = loader.waited_seconds();
  since_validation_ = Stopwatch();
}

TrainingMetrics Trainer::measured(const BatchLoader& loader) {
  const torch::NoGradGuard no_gradient;
  const double seconds = since_validation_.seconds();  // of steps alone
  const BatchPlan plan(task_.views(), options_.batch_size, options_.seed);
  measure_norm_statistics(*averaged_, plan, kNormBatches, device_);

  TrainingMetrics metrics;
  metrics.step = step_;
  metrics.samples = step_ * options_.batch_size;
  metrics.learning_rate = learning_rate_at(options_.learning_rate, progress());
  metrics.training_loss = loss_sum_ / static_cast<double>(loss_count_);
  metrics.samples_per_second = static_cast<double>(loss_count_ * options_.batch_size) / seconds;
  metrics.waiting_share = (loader.waited_seconds() - waited_before_) / seconds;
  metrics.validation = task_.validate(*averaged_, device_);
  return metrics;
}

TrainingMetrics Trainer::shared(const TrainingMetrics& metrics) const {
  std::string own;
  if (is_first_worker()) {
    const torch::Tensor values = as_tensor({metrics});
    own.assign(static_cast<const char*>(values.data_ptr()), values.nbytes());
  }
  std::string said = from_first(*run_.workers, own);
  const auto count = static_cast<int64_t>(said.size() / sizeof(double));
  return metrics_of(torch::from_blob(said.data(), {1, count}, torch::kDouble)).front();
}

bool Trainer::is_kept(const TrainingMetrics& metrics) const {
  if (!std::isfinite(metrics.validation.back())) return false;
  return options_.keep == "last" || std::ranges::all_of(metrics_, [&](const TrainingMetrics& before) {
           return !(before.validation.back() <= metrics.validation.back());
         });
}

double Trainer::seconds_left() const {
  const double elapsed = whole_time_.seconds();
  const double left = elapsed * static_cast<double>(end_ - step_) / static_cast<double>(step_ - first_step_);
  return run_.minutes > 0.0 ? std::clamp(60.0 * run_.minutes - elapsed, 0.0, left) : left;
}

std::string Trainer::identity() const {
  return task_.identity(options_as_toml(options_)) + fmt::format("[data]\nsamples = {}\ninitial = \"{}\"\n",
                                                                 task_.views()->size(),
                                                                 run_.initial.filename().string());
}

void Trainer::load_initial() {
  const torch::NoGradGuard no_gradient;
  task_.load(run_.initial, *averaged_);
  const auto copy = [](const std::vector<torch::Tensor>& from, const std::vector<torch::Tensor>& to) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i].copy_(from[i]);
  };
  copy(averaged_->parameters(), network_.parameters());
  copy(averaged_->buffers(), network_.buffers());
  network_.share_buffers();
  if (is_first_worker() && run_.report_initial) run_.report_initial(task_.validate(*averaged_, device_));
}

void Trainer::save_checkpoint() {
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

void Trainer::load_checkpoint() {
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
  const bool has_metrics = metrics.size() == 1 && metrics[0].dim() == 2 &&
                           metrics[0].size(1) > static_cast<int64_t>(kFixedColumns);
  if (!has_metrics) fail("{}: the metrics are missing", run_.checkpoint.string());
  metrics_ = metrics_of(metrics.front());
  archive.copy_into("moments", optimiser_.moments());
  step_ = static_cast<std::int64_t>(archive.number("step"));
  optimiser_.set_steps(step_);
}

}  // namespace knuckle
