// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/pose_forest_training.h"

#include <atomic>
#include <memory>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/worker_messages.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle {
namespace {

std::vector<PatchPoint> joints_in_patch(const HandPose& truth, const PatchGeometry& geometry) {
  std::vector<PatchPoint> joints;
  for (const ImagePoint& joint : truth.joints) joints.push_back(geometry.to_patch(joint));
  return joints;
}

/// Fills the training set with the patches of a part of a source's frames, on all threads.
class PatchCollector {
 public:
  PatchCollector(const PoseForestTrainingConfig& config, const FrameSource& source, PartOfWork frames,
                 std::int64_t spare)
      : config_(config),
        source_(source),
        frames_(frames),
        extractor_(config.patch),
        set_(frames.size(), config.convention, extractor_.statistics(), spare) {}

  TrainingFrames collect() {
    Progress progress("patches", "frames", frames_.size());
    parallel_for(frames_.size(), [&](std::int64_t i) {
      add(i, source_.read(frames_.begin + i));
      progress.advance();
    });
    return {frames_.size(), without_hand_, with_missing_joints_};
  }

  PoseTrainingSet& set() { return set_; }

 private:
  void add(std::int64_t index, Frame frame) {
    frame = as_right_hand(std::move(frame), config_.finder.hand());
    const Segmentation found = config_.finder.find_right(frame, start_in(frame, config_.start));
    const auto patch = found.hands.empty() ? std::nullopt : extractor_.extract(frame, found.hands.front());
    if (!patch || !frame.truth) {
      ++without_hand_;
      return;
    }
    const HandPose truth = converted(*frame.truth, config_.convention);
    if (set_.set(index, *patch, joints_in_patch(truth, patch->geometry)) ==
        PoseTrainingSet::Kept::joint_missing) {
      ++with_missing_joints_;
    }
  }

  const PoseForestTrainingConfig& config_;
  const FrameSource& source_;
  PartOfWork frames_;
  PatchExtractor extractor_;
  PoseTrainingSet set_;
  std::atomic<std::int64_t> without_hand_ = 0;
  std::atomic<std::int64_t> with_missing_joints_ = 0;
};

std::unique_ptr<FrameSource> source_with_truth(const PoseForestTrainingConfig& config) {
  auto source = open_source(config.source);
  if (!source->convention()) fail("{}: the source has no truth to train on", config.source);
  return source;
}

void check_used(const TrainingFrames& frames, const PoseForestTrainingConfig& config) {
  if (frames.used() > 0) return;
  fail(
      "{}: no frame can be trained on: of {} frames segmentation found no hand in {}, and {} lack a joint "
      "of {}",
      config.source, frames.total, frames.without_hand, frames.with_missing_joints, config.convention.name);
}

/// Samples that a worker may have besides, beyond its part of the frames: parts differ by a few, and by a
/// quarter where another has too much to do (SampleCuts). What is not used takes no memory.
std::int64_t spare_samples(std::int64_t frames) {
  return frames / 4 + 4096;
}

}  // namespace

PoseForestTrainingConfig PoseForestTrainingConfig::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  PoseForestTrainingConfig config{.source = source_in(document, "source"),
                                  .convention = convention_from_key(document, "convention", "icg20"),
                                  .start = start_from_name(document.choice_or("start", "truth", kStartNames)),
                                  .finder = HandFinder(document),
                                  .patch = {},
                                  .forest = {},
                                  .resolved_options = {}};
  document.table("patch").read(config.patch);
  document.table("forest").read(config.forest);
  document.finish();
  config.resolved_options = document.resolved_toml();
  return config;
}

PoseForestTraining run_training(const PoseForestTrainingConfig& config, const TrainingRun& run) {
  const auto source = source_with_truth(config);
  PatchCollector collector(config, *source, {0, source->size()}, 0);
  const TrainingFrames frames = collector.collect();
  check_used(frames, config);
  return {train_pose_forest(collector.set(), config.forest, run), frames};
}

std::optional<PoseForestTraining> run_training(const PoseForestTrainingConfig& config, const TrainingRun& run,
                                               WorkerGroup& workers) {
  const auto source = source_with_truth(config);
  const PartOfWork part = part_of_worker(source->size(), workers.rank(), workers.size());
  PatchCollector collector(config, *source, part, spare_samples(part.size()));
  TrainingFrames frames;
  for (const TrainingFrames& own : values_of_all(workers, collector.collect())) {
    frames.total += own.total;
    frames.without_hand += own.without_hand;
    frames.with_missing_joints += own.with_missing_joints;
  }
  check_used(frames, config);
  auto model = train_pose_forest(workers, collector.set(), part.begin, config.forest, run);
  if (!model) return std::nullopt;
  return PoseForestTraining{std::move(*model), frames};
}

}  // namespace knuckle
