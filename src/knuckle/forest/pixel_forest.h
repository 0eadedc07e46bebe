// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/forest/depth_offsets.h"
#include "knuckle/forest/flat_trees.h"
#include "knuckle/storage/model_file.h"

namespace knuckle {

/// Classification trees on differences of depth probes (Riegler et al. 2015, equation 1), in flat arrays: for
/// each pixel of a depth image the probability of class 1.
class PixelForest {
 public:
  using Node = TreeNode<OffsetPair>;
  static_assert(sizeof(Node) == 16);
  /// A leaf's probability is its code / kMostCode.
  static constexpr int kMostCode = 255;

  /// What a forest is made of.
  struct Parts {
    FlatTrees<OffsetPair> trees;
    std::vector<std::uint8_t> leaf_codes;  ///< one per leaf
  };

  /// Throws an Error that starts with `origin` where the parts do not fit together, or an offset is larger
  /// than kMostOffset.
  PixelForest(Parts parts, const std::string& origin);

  int tree_count() const { return static_cast<int>(parts_.trees.roots.size()); }
  const Parts& parts() const { return parts_; }

  /// The mean over the trees of the leaves' probabilities, in [0, 1]; 0 where a pixel was not measured. On
  /// all threads; the same bits for any number of them. Throws an Error where the image has not the size of
  /// its camera.
  Image<float> probability(const Image<float>& depth_mm, const Camera& camera) const;

  /// 1 where that probability is above `threshold`, else 0: the same answer in less time, since most pixels
  /// need not see all trees. What is left of them cannot lift it above the threshold any more.
  Image<std::uint8_t> above(const Image<float>& depth_mm, const Camera& camera, float threshold) const;

  /// A forest of at most `most_leaves` leaves (or one per tree), see pruned_nodes().
  PixelForest pruned(std::size_t most_leaves) const;

 private:
  /// Sums of leaf codes over all trees, of each measured pixel for which it may reach `least`: calls
  /// take(row * width + column, sum).
  template <class Take>
  void sum_codes(const Image<float>& depth_mm, const Camera& camera, int least, const Take& take) const;

  Parts parts_;
  std::vector<Node> walk_;  // the nodes, but a leaf leads to itself and keeps its code instead of a feature
};

/// Adds the forest to a file, or reads it back. The caller writes the file's format and version. Throws an
/// Error that names the file where something is missing or out of range.
void write_forest(ModelWriter& file, const PixelForest& forest);
/// Reads the forest back.
PixelForest read_pixel_forest(const ModelFile& file);

}  // namespace knuckle
