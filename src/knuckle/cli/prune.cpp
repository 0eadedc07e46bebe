// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/hdf5_file.h"
#include "knuckle/estimate/pose_forest.h"
#include "knuckle/segment/segmentation_forest.h"

namespace knuckle::cli {
namespace {

struct PruneArguments {
  std::filesystem::path model;
  std::filesystem::path out;
  std::int64_t leaves = 0;
};

/// Leaves before and after.
struct LeafCounts {
  std::size_t before = 0;
  std::size_t after = 0;
};

LeafCounts prune_pose_forest(const PruneArguments& arguments, std::size_t most) {
  const PoseForestModel whole = load_pose_forest(arguments.model);
  const PoseForestModel small = pruned(whole, most);
  save_pose_forest(arguments.out, small);
  return {whole.forest.parts().leaves.leaf_count(), small.forest.parts().leaves.leaf_count()};
}

LeafCounts prune_segmentation_forest(const PruneArguments& arguments, std::size_t most) {
  const PixelForest whole = load_segmentation_forest(arguments.model);
  const PixelForest small = whole.pruned(most);
  save_segmentation_forest(arguments.out, small);
  return {whole.parts().leaf_codes.size(), small.parts().leaf_codes.size()};
}

LeafCounts prune(const PruneArguments& arguments) {
  const auto most = static_cast<std::size_t>(arguments.leaves);
  const std::string kind = Hdf5File::open(arguments.model).text_attribute("kind");
  if (kind == "pose") return prune_pose_forest(arguments, most);
  if (kind == "segmentation") return prune_segmentation_forest(arguments, most);
  fail("{}: a forest of kind \"{}\", expected \"pose\" or \"segmentation\"", arguments.model.string(), kind);
}

void run_prune(const PruneArguments& arguments) {
  const LeafCounts leaves = prune(arguments);
  constexpr double kBytesAMegabyte = 1e6;
  fmt::print("{} of {} leaves, {:.2f} MB: {}\n", leaves.after, leaves.before,
             static_cast<double>(std::filesystem::file_size(arguments.out)) / kBytesAMegabyte,
             arguments.out.string());
}

}  // namespace

void add_prune(CLI::App& program) {
  CLI::App& verb =
      add_verb(program, "prune", "Make a forest smaller",
               "knuckle prune --model models/pose_forest.h5 --leaves 20000 --out small_forest.h5");
  auto arguments = std::make_shared<PruneArguments>();
  verb.add_option("--model", arguments->model, "A pose or segmentation forest")->required();
  verb.add_option("--leaves", arguments->leaves,
                  "Leaves of all trees together at most; those are merged that change the answers least")
      ->required()
      ->check(CLI::PositiveNumber);
  verb.add_option("--out", arguments->out, "File for the smaller forest")->required();
  verb.callback([arguments] { run_prune(*arguments); });
}

}  // namespace knuckle::cli
