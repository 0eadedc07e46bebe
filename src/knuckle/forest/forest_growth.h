// SPDX-License-Identifier: Apache-2.0
// Growing the trees of a forest one after another, so that a training may be killed at any moment.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/progress.h"
#include "knuckle/forest/flat_trees.h"
#include "knuckle/forest/tree_grower.h"
#include "knuckle/storage/model_file.h"

namespace knuckle {

/// What training does beside the forest itself.
struct TrainingRun {
  /// Where finished trees are kept, so that a stopped training goes on; empty: nowhere. The splits of the
  /// tree that is being grown lie beside it, in `checkpoint` + ".tree". Both are removed at the end. One of
  /// other options or samples is refused.
  std::filesystem::path checkpoint = {};
  /// Least time between two writings of the tree that is being grown [s].
  double checkpoint_interval_s = 30.0;
  /// Called after every tree with the number there are; may be empty.
  std::function<void(int trees)> tree_done = {};
  /// Called when some nodes were split, with the number of the tree's nodes that are done; may be empty.
  std::function<void(std::size_t nodes)> nodes_done = {};
};

/// What a checkpoint calls itself.
inline constexpr std::string_view kCheckpointFormat = "knuckle-forest-checkpoint";
/// The version of checkpoints that is written and read.
inline constexpr int kCheckpointVersion = 3;

/// Writes a checkpoint, atomically; `write` adds the trees.
void write_checkpoint(const std::filesystem::path& path, const std::string& fingerprint,
                      const std::function<void(ModelWriter&)>& write);

/// Opens one; nothing where the file is missing or `path` is empty. Throws an Error where it is none, or of
/// another fingerprint.
std::optional<ModelFile> open_checkpoint(const std::filesystem::path& path, const std::string& fingerprint);

/// Where the splits of the tree that is being grown lie.
std::filesystem::path tree_checkpoint(const std::filesystem::path& checkpoint);

/// Removes both files where they exist: a fresh training starts without what an earlier one left.
void remove_checkpoint(const std::filesystem::path& checkpoint);

/// The checkpoint of the tree that is being grown: its splits so far.
template <class Feature>
class TreeCheckpoint {
 public:
  TreeCheckpoint(const TrainingRun& run, std::string fingerprint, std::size_t tree)
      : path_(tree_checkpoint(run.checkpoint)),
        interval_(run.checkpoint_interval_s),
        fingerprint_(std::move(fingerprint)),
        tree_(tree),
        written_(Clock::now()) {}

  /// The splits that a stopped run left of this tree. One of an earlier tree is of no use: that tree is done.
  SplitLog<Feature> load() const {
    const std::optional<ModelFile> file = open_checkpoint(path_, fingerprint_);
    if (!file || file->number("tree") != static_cast<double>(tree_)) return {};
    const std::vector<float> gain = file->read<float>("node_gain").values;
    SplitLog<Feature> log(gain.size());
    for (std::size_t i = 0; i < gain.size(); ++i) log[i].gain = gain[i];
    detail::read_splits<Feature>(*file, log);
    return log;
  }

  /// Writes the splits where the last writing is long enough ago.
  void update(const SplitLog<Feature>& log) {
    if (std::chrono::duration<double>(Clock::now() - written_).count() >= interval_) write(log);
  }

  /// Writes the splits, where there are any and a place for them.
  void write(const SplitLog<Feature>& log) {
    if (path_.empty() || log.empty()) return;
    write_checkpoint(path_, fingerprint_, [&](ModelWriter& file) {
      file.set("tree", static_cast<double>(tree_));
      std::vector<float> gain;
      for (const NodeSplit<Feature>& split : log) gain.push_back(split.gain);
      detail::write_column(file, "node_gain", gain);
      detail::write_splits<Feature>(file, log);
    });
    written_ = Clock::now();
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::filesystem::path path_;
  double interval_;
  std::string fingerprint_;
  std::size_t tree_;
  Clock::time_point written_;
};

/// Grows trees `first_tree`, ..., `trees` - 1 of a forest. `append` takes each and writes the checkpoint of
/// whole trees.
template <class Features, class Statistics, class Append>
void grow_trees(const Features& features, const Statistics& statistics, const TreeOptions& options,
                std::span<const std::uint32_t> order, std::size_t first_tree, std::size_t trees,
                const TrainingRun& run, const std::string& fingerprint, const Append& append) {
  using Grower = TreeGrower<Features, Statistics>;
  const std::int64_t steps_per_tree = Grower::kStepsPerLevel * options.max_depth;
  Progress progress("train forest", "steps", static_cast<std::int64_t>(trees) * steps_per_tree);
  progress.advance(static_cast<std::int64_t>(first_tree) * steps_per_tree);
  Grower grower(features, statistics, options);
  for (std::size_t tree = first_tree; tree < trees; ++tree) {
    TreeCheckpoint<typename Features::Feature> checkpoint(run, fingerprint, tree);
    typename Grower::Log log = checkpoint.load();
    const auto nodes_done = [&](const typename Grower::Log& grown) {
      checkpoint.update(grown);
      if (run.nodes_done) run.nodes_done(grown.size());
    };
    try {
      append(grower.grow(order, derived_seed(options.seed, tree), progress, log, nodes_done));
    } catch (const Interrupted&) {
      checkpoint.write(log);
      throw Interrupted(fmt::format("interrupted after {} of {} trees{}", tree, trees,
                                    run.checkpoint.empty() ? "" : "; continue with --resume"));
    }
    if (!run.checkpoint.empty()) std::filesystem::remove(tree_checkpoint(run.checkpoint));
    if (run.tree_done) run.tree_done(static_cast<int>(tree) + 1);
  }
}

}  // namespace knuckle
