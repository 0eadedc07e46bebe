// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "knuckle/forest/flat_trees.h"
#include "knuckle/forest/leaf_coding.h"
#include "knuckle/forest/leaf_table.h"
#include "knuckle/forest/pixel_pairs.h"
#include "knuckle/forest/training_samples.h"
#include "knuckle/storage/model_file.h"

namespace knuckle {

/// Regression trees on pixel differences (Riegler et al. 2015, equation 3), in flat arrays.
class RegressionForest {
 public:
  using Node = TreeNode<PixelPair>;
  static_assert(sizeof(Node) == 12);

  /// What a forest is made of.
  struct Parts {
    int feature_count = 0;
    FeatureQuantizer quantizer;
    FlatTrees<PixelPair> trees;
    LeafTable leaves;
  };

  /// Throws an Error that starts with `origin` where the parts do not fit together.
  RegressionForest(Parts parts, const std::string& origin);

  int feature_count() const { return parts_.feature_count; }
  int target_count() const { return parts_.leaves.dimensions(); }
  int tree_count() const { return static_cast<int>(parts_.trees.roots.size()); }
  const Parts& parts() const { return parts_; }

  /// The mean of the trees' leaves, and how far the trees disagree.
  struct Prediction {
    std::vector<float> mean;       ///< one per target
    std::vector<float> deviation;  ///< one per target: the standard deviation over the trees
  };
  /// `features` has feature_count() entries (an Error otherwise). Safe to call from many threads.
  Prediction predict(std::span<const float> features) const;

  /// The row of the table of leaves that `features` reaches in each tree.
  std::vector<std::uint32_t> leaves_of(std::span<const float> features) const;

  /// A forest of the same structure whose leaves are kept with 8, 16 or 32 bits per value.
  RegressionForest with_leaf_bits(int bits) const;

  /// A forest of at most `most_leaves` leaves (or one per tree), see pruned_nodes(). `scale`: what a unit of
  /// each target counts (an Error where there is not one per target).
  RegressionForest pruned(std::size_t most_leaves, std::span<const float> scale) const;

 private:
  Parts parts_;
};

/// Adds the forest to a file, its leaves as they are or coded, or reads it back. The caller writes the file's
/// format and version. Throws an Error that names the file where something is missing, out of range or not
/// finite.
void write_forest(ModelWriter& file, const RegressionForest& forest,
                  const std::optional<LeafCoding>& coding = std::nullopt);
/// Reads the forest back.
RegressionForest read_forest(const ModelFile& file);

}  // namespace knuckle
