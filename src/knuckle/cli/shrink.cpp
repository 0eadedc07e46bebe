// SPDX-License-Identifier: Apache-2.0
#include <optional>

#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/estimate/pose_forest.h"
#include "knuckle/segment/segmentation_forest.h"
#include "knuckle/storage/model_file.h"

namespace knuckle::cli {
namespace {

struct ShrinkArguments {
  std::filesystem::path model;
  std::filesystem::path out;
  std::optional<std::size_t> leaves;
  std::optional<float> leaf_step;
};

/// Leaves before and after.
struct LeafCounts {
  std::size_t before = 0;
  std::size_t after = 0;
};

LeafCounts shrink_pose_forest(const ShrinkArguments& arguments) {
  PoseForestModel model = load_pose_forest(arguments.model);
  const auto leaf_count = [&] { return model.forest.parts().leaves.leaf_count(); };
  const std::size_t before = leaf_count();
  if (arguments.leaves) model = pruned(model, *arguments.leaves);
  if (arguments.leaf_step) {
    save_pose_forest(arguments.out, model, *arguments.leaf_step);
  } else {
    save_pose_forest(arguments.out, model);
  }
  return {before, leaf_count()};
}

LeafCounts shrink_segmentation_forest(const ShrinkArguments& arguments) {
  if (arguments.leaf_step) {
    fail("{}: a segmentation forest's leaves are single bytes; --leaf-step is for pose forests",
         arguments.model.string());
  }
  const PixelForest whole = load_segmentation_forest(arguments.model);
  const PixelForest small = whole.pruned(*arguments.leaves);
  save_segmentation_forest(arguments.out, small);
  return {whole.parts().leaf_codes.size(), small.parts().leaf_codes.size()};
}

LeafCounts shrink(const ShrinkArguments& arguments) {
  if (!arguments.leaves && !arguments.leaf_step) fail("shrink: give --leaves, --leaf-step, or both");
  const std::string kind = ModelFile::open(arguments.model).text("kind");
  if (kind == "pose") return shrink_pose_forest(arguments);
  if (kind == "segmentation") return shrink_segmentation_forest(arguments);
  fail("{}: a forest of kind \"{}\", expected \"pose\" or \"segmentation\"", arguments.model.string(), kind);
}

void run_shrink(const ShrinkArguments& arguments) {
  const LeafCounts leaves = shrink(arguments);
  constexpr double kBytesPerMegabyte = 1e6;
  const auto megabytes = [](const std::filesystem::path& path) {
    return static_cast<double>(std::filesystem::file_size(path)) / kBytesPerMegabyte;
  };
  fmt::print("{} leaves, {:.2f} MB -> {} leaves, {:.2f} MB: {}\n", leaves.before, megabytes(arguments.model),
             leaves.after, megabytes(arguments.out), arguments.out.string());
}

}  // namespace

void add_shrink(CLI::App& program) {
  CLI::App& verb =
      add_verb(program, "shrink", "Make a forest's file smaller",
               "knuckle shrink --model models/pose_forest.model --leaf-step 0.2 --out small_forest.model");
  auto arguments = std::make_shared<ShrinkArguments>();
  verb.add_option("--model", arguments->model, "A pose or segmentation forest")->required();
  verb.add_option("--leaves", arguments->leaves,
                  "Leaves of all trees together at most; those are merged that change the answers least")
      ->check(CLI::PositiveNumber);
  verb.add_option(
          "--leaf-step", arguments->leaf_step,
          "Keep a pose forest's leaves in steps of this along their principal components, in half patches: "
          "0.16 takes a third of the room and loses some 0.1 mm")
      ->check(CLI::PositiveNumber);
  verb.add_option("--out", arguments->out, "File for the smaller forest")->required();
  verb.callback([arguments] { run_shrink(*arguments); });
}

}  // namespace knuckle::cli
