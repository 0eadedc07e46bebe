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
#include <type_traits>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/worker_messages.h"
#include "knuckle/forest/flat_trees.h"
#include "knuckle/forest/shared_growth.h"
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

/// The log that worker 0 has, for all workers.
template <class Feature>
SplitLog<Feature> log_of_first(WorkerGroup& workers, const SplitLog<Feature>& own) {
  static_assert(std::is_trivially_copyable_v<NodeSplit<Feature>>);
  OwnMessages sent(static_cast<std::size_t>(workers.size()));
  if (workers.rank() == 0) {
    for (std::vector<std::byte>& message : sent) append_values(message, std::span(own));
  }
  const ReceivedMessages received = exchanged(workers, std::move(sent));
  const std::span<const std::byte> message = received.parts[0];
  if (message.size() % sizeof(NodeSplit<Feature>) != 0)
    fail("a worker's message of splits has {} bytes, which is no number of them", message.size());
  SplitLog<Feature> log(message.size() / sizeof(NodeSplit<Feature>));
  MessageReader(message).read(std::span(log));
  return log;
}

/// Grows trees `first_tree`, ..., `trees` - 1 of a forest, with `grow(seed, progress, log, nodes_done)`.
/// `append` takes each and writes the checkpoint of whole trees. Where several workers grow it, worker 0 has
/// the checkpoints.
template <class Feature, class Grow, class Append>
void grow_each_tree(const TreeOptions& options, std::size_t first_tree, std::size_t trees,
                    std::int64_t steps_per_level, const TrainingRun& run, const std::string& fingerprint,
                    WorkerGroup* workers, const Grow& grow, const Append& append) {
  using Log = SplitLog<Feature>;
  if (first_tree > trees) {
    fail("forest training: {} trees are done of {}: the checkpoint or another worker is damaged", first_tree,
         trees);
  }
  const std::int64_t steps_per_tree = steps_per_level * options.max_depth;
  Progress progress("train forest", "steps", static_cast<std::int64_t>(trees) * steps_per_tree);
  progress.advance(static_cast<std::int64_t>(first_tree) * steps_per_tree);
  for (std::size_t tree = first_tree; tree < trees; ++tree) {
    TreeCheckpoint<Feature> checkpoint(run, fingerprint, tree);
    Log log = checkpoint.load();
    const auto nodes_done = [&](const Log& grown) {
      checkpoint.update(grown);
      if (run.nodes_done) run.nodes_done(grown.size());
    };
    try {
      if (workers != nullptr) log = log_of_first(*workers, log);
      append(grow(derived_seed(options.seed, tree), progress, log, nodes_done));
    } catch (const Interrupted&) {
      checkpoint.write(log);
      throw Interrupted(fmt::format("interrupted after {} of {} trees{}", tree, trees,
                                    run.checkpoint.empty() ? "" : "; continue with --resume"));
    } catch (...) {
      if (workers != nullptr) checkpoint.write(log);  // another worker was lost: what is done is kept
      throw;
    }
    if (!run.checkpoint.empty()) std::filesystem::remove(tree_checkpoint(run.checkpoint));
    if (run.tree_done) run.tree_done(static_cast<int>(tree) + 1);
  }
}

/// Grows them from all samples, `order` them in the order to work in.
template <class Features, class Statistics, class Append>
void grow_trees(const Features& features, const Statistics& statistics, const TreeOptions& options,
                std::span<const std::uint32_t> order, std::size_t first_tree, std::size_t trees,
                const TrainingRun& run, const std::string& fingerprint, const Append& append) {
  using Grower = TreeGrower<Features, Statistics>;
  Grower grower(features, statistics, options);
  const auto grow = [&](std::uint64_t seed, Progress& progress, typename Grower::Log& log,
                        const auto& nodes_done) {
    return grower.grow(order, seed, progress, log, nodes_done);
  };
  grow_each_tree<typename Features::Feature>(options, first_tree, trees, Grower::kStepsPerLevel, run,
                                             fingerprint, nullptr, grow, append);
}

/// Grows them with other workers. `next_samples` gives this worker's samples of all, before each tree.
template <class Features, class Statistics, class Next, class Append>
void grow_shared_trees(WorkerGroup& workers, const Features& features, const Statistics& statistics,
                       const TreeOptions& options, const Next& next_samples, const MoveSamples& move,
                       std::size_t first_tree, std::size_t trees, const TrainingRun& run,
                       const std::string& fingerprint, const Append& append) {
  using Grower = SharedTreeGrower<Features, Statistics>;
  Grower grower(workers, features, statistics, options, move);
  const auto grow = [&](std::uint64_t seed, Progress& progress, typename Grower::Log& log,
                        const auto& nodes_done) {
    return grower.grow(next_samples(), seed, progress, log, nodes_done);
  };
  grow_each_tree<typename Features::Feature>(options, first_tree, trees, Grower::kStepsPerLevel, run,
                                             fingerprint, &workers, grow, append);
}

}  // namespace knuckle
