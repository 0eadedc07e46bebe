// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/pixel_forest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <span>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/forest/pruning.h"
#include "knuckle/forest/simd.h"

namespace knuckle {

namespace {

using Node = PixelForest::Node;
using Int16x4 [[gnu::vector_size(8)]] = std::int16_t;

/// Pixels walked at once by a thread: while one waits for a node, the others go on.
constexpr std::size_t kWalkers = 16;
/// Pixels handed to a thread in one piece.
constexpr std::int64_t kPixelsPerPiece = 2048;

void check_parts(const PixelForest::Parts& parts, const std::string& origin) {
  check_trees(parts.trees, parts.leaf_codes.size(), origin);
  for (std::size_t i = 0; i < parts.trees.nodes.size(); ++i) {
    const OffsetPair& pair = parts.trees.nodes[i].feature;
    for (const int offset : {pair.first_x, pair.first_y, pair.second_x, pair.second_y}) {
      if (std::abs(offset) > kMostOffset) {
        fail("{}: node {} has an offset of {} mm, expected at most {}", origin, i, offset, kMostOffset);
      }
    }
  }
}

/// The probability that belongs to a sum of the trees' codes.
float probability_of(int sum, int trees) {
  return static_cast<float>(sum) / static_cast<float>(PixelForest::kMostCode * trees);
}

/// A measured pixel.
struct Pixel {
  std::int32_t index = 0;  ///< row * width + column
  std::int32_t sum = 0;    ///< of the leaf codes so far
  std::int16_t column = 0;
  std::int16_t row = 0;
};

std::vector<Pixel> measured_pixels(const BorderedDepth& depth) {
  std::vector<Pixel> pixels;
  pixels.reserve(static_cast<std::size_t>(depth.width()) * static_cast<std::size_t>(depth.height()));
  for (int row = 0; row < depth.height(); ++row) {
    const std::int16_t* line = depth.data() + row * depth.stride();
    for (int column = 0; column < depth.width(); ++column) {
      if (line[column] == kFarDepth) continue;
      pixels.push_back({.index = row * depth.width() + column,
                        .sum = 0,
                        .column = static_cast<std::int16_t>(column),
                        .row = static_cast<std::int16_t>(row)});
    }
  }
  return pixels;
}

/// What is the same for all pixels of an image.
struct Ground {
  const std::int16_t* depth = nullptr;  // pixel (0, 0)
  std::int32_t stride = 0;
  Int32x4 lowest{};  // a pixel out of the image, in x, y, x, y
  Int32x4 highest{};
};

/// One pixel on its way down a tree. Lanes are x and y of the first probe, x and y of the second.
struct Walker {
  Int32x4 place{};
  Int32x4 scale{};
  std::uint32_t node = 0;
  std::uint32_t pixel = 0;
};

/// The node that follows: the same arithmetic as offset_feature, four lanes at once.
std::uint32_t next_node(const Node& node, const Walker& walker, const Ground& ground) {
  constexpr std::int32_t kHalf = 1 << (PixelScale::kBits - 1);
  Int16x4 narrow;
  std::memcpy(&narrow, &node.feature, sizeof(narrow));
  const Int32x4 offsets = __builtin_convertvector(narrow, Int32x4);
  Int32x4 probe = walker.place + ((offsets * walker.scale + kHalf) >> PixelScale::kBits);
  probe = probe < ground.lowest ? ground.lowest : probe;
  probe = probe > ground.highest ? ground.highest : probe;
  const int first = ground.depth[probe[1] * ground.stride + probe[0]];
  const int second = ground.depth[probe[3] * ground.stride + probe[2]];
  return static_cast<std::uint32_t>(node.next) + (first - second >= node.threshold ? 1U : 0U);
}

/// Walks pixels down a tree and adds their leaves' codes to their sums.
class TreeWalk {
 public:
  TreeWalk(const Node* nodes, const BorderedDepth& depth, const OffsetScale& scale)
      : nodes_(nodes), scale_(scale) {
    ground_.depth = depth.data();
    ground_.stride = depth.stride();
    ground_.lowest = Int32x4{-1, -1, -1, -1};
    ground_.highest = Int32x4{depth.width(), depth.height(), depth.width(), depth.height()};
  }

  void run(std::uint32_t root, std::span<Pixel> pixels) const {
    std::array<Walker, kWalkers> walkers;
    std::size_t active = std::min(kWalkers, pixels.size());
    for (std::size_t i = 0; i < active; ++i) walkers[i] = start(root, pixels, i);
    std::size_t next_pixel = active;
    while (active > 0) {
      for (std::size_t i = 0; i < active;) {
        Walker& walker = walkers[i];
        const Node& node = nodes_[walker.node];
        if (node.next >= 0) {
          walker.node = next_node(node, walker, ground_);
          __builtin_prefetch(nodes_ + walker.node);
          ++i;
          continue;
        }
        pixels[walker.pixel].sum += ~node.next;
        if (next_pixel < pixels.size()) {
          walker = start(root, pixels, next_pixel++);
        } else {
          walker = walkers[--active];
        }
      }
    }
  }

 private:
  Walker start(std::uint32_t root, std::span<const Pixel> pixels, std::size_t pixel) const {
    const std::int32_t column = pixels[pixel].column;
    const std::int32_t row = pixels[pixel].row;
    const PixelScale scale = scale_.at(ground_.depth[row * ground_.stride + column]);
    return {.place = Int32x4{column, row, column, row},
            .scale = Int32x4{scale.x, scale.y, scale.x, scale.y},
            .node = root,
            .pixel = static_cast<std::uint32_t>(pixel)};
  }

  const Node* nodes_;
  const OffsetScale& scale_;
  Ground ground_;
};

}  // namespace

PixelForest::PixelForest(Parts parts, const std::string& origin) : parts_(std::move(parts)) {
  check_parts(parts_, origin);
  walk_ = parts_.trees.nodes;
  for (Node& node : walk_) {
    if (node.next >= 0) continue;
    const std::int32_t leaf = ~node.next;
    node.next = ~std::int32_t{parts_.leaf_codes[static_cast<std::size_t>(leaf)]};
  }
}

template <class Take>
void PixelForest::sum_codes(const Image<float>& depth_mm, const Camera& camera, int least,
                            const Take& take) const {
  if (depth_mm.width() != camera.width || depth_mm.height() != camera.height) {
    fail("pixel forest: the depth image is {} x {} pixels, its camera {} x {}", depth_mm.width(),
         depth_mm.height(), camera.width, camera.height);
  }
  const BorderedDepth depth(depth_mm);
  const std::vector<Pixel> pixels = measured_pixels(depth);
  const OffsetScale scale(camera);
  const TreeWalk walk(walk_.data(), depth, scale);
  const std::int64_t pieces = (std::ssize(pixels) + kPixelsPerPiece - 1) / kPixelsPerPiece;
  parallel_for(pieces, [&](std::int64_t piece) {
    const auto begin = pixels.begin() + piece * kPixelsPerPiece;
    const auto end = pixels.begin() + std::min((piece + 1) * kPixelsPerPiece, std::ssize(pixels));
    std::vector<Pixel> undecided(begin, end);
    int still_to_come = kMostCode * tree_count();
    for (const std::uint32_t root : parts_.trees.roots) {
      walk.run(root, undecided);
      still_to_come -= kMostCode;
      std::erase_if(undecided, [&](const Pixel& pixel) { return pixel.sum + still_to_come < least; });
    }
    for (const Pixel& pixel : undecided) take(pixel.index, pixel.sum);
  });
}

Image<float> PixelForest::probability(const Image<float>& depth_mm, const Camera& camera) const {
  Image<float> probability(depth_mm.width(), depth_mm.height());
  sum_codes(depth_mm, camera, 0, [&](std::int32_t pixel, int sum) {
    probability.data()[pixel] = probability_of(sum, tree_count());
  });
  return probability;
}

Image<std::uint8_t> PixelForest::above(const Image<float>& depth_mm, const Camera& camera,
                                       float threshold) const {
  int least = 0;
  while (least <= kMostCode * tree_count() && !(probability_of(least, tree_count()) > threshold)) ++least;
  Image<std::uint8_t> mask(depth_mm.width(), depth_mm.height());
  sum_codes(depth_mm, camera, least, [&](std::int32_t pixel, int /*sum*/) { mask.data()[pixel] = 1; });
  return mask;
}

PixelForest PixelForest::pruned(std::size_t most_leaves) const {
  const std::vector<float> scale(1, 1.0F);
  const std::vector<float> codes(parts_.leaf_codes.begin(), parts_.leaf_codes.end());
  auto pruned = pruned_trees(parts_.trees, {1, codes}, scale, most_leaves);
  Parts parts{std::move(pruned.trees), {}};
  for (const float code : pruned.leaves.values) {
    parts.leaf_codes.push_back(static_cast<std::uint8_t>(std::lround(code)));
  }
  return {std::move(parts), "pixel forest"};
}

void write_forest(ModelWriter& file, const PixelForest& forest) {
  const PixelForest::Parts& parts = forest.parts();
  file.set("far_depth_mm", double{kFarDepth});
  write_trees(file, parts.trees);
  detail::write_column(file, "leaf_code", parts.leaf_codes);
}

PixelForest read_pixel_forest(const ModelFile& file) {
  const double far = file.number("far_depth_mm");
  if (far != kFarDepth) fail("{}: far_depth_mm is {}, expected {}", file.origin(), far, kFarDepth);
  PixelForest::Parts parts;
  parts.trees = read_trees<OffsetPair>(file);
  parts.leaf_codes = file.read<std::uint8_t>("leaf_code").values;
  return {std::move(parts), file.origin()};
}

}  // namespace knuckle
