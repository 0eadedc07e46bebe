// SPDX-License-Identifier: Apache-2.0
#include "knuckle/export/dense_graph.h"

#include <array>

#include <fmt/format.h>

#include "knuckle/export/encoder_decoder_graph.h"
#include "knuckle/export/graph_builder.h"
#include "knuckle/net/dense_architecture.h"

namespace knuckle {
namespace {

/// By how much the weight of a cell that is no hand lies below those that are, before the softmax: its share
/// is then 0 in single precision. Where no cell is hand all lie as much lower, and it cancels.
constexpr float kNotHand = 2048.0f;

/// Votes of all cells, as matrices of joints x cells. Only operators that OpenCV 4.6 runs, which broadcasts
/// nothing that is computed: a number per joint is brought to all cells, and summed over them, by products
/// with ones.
class DenseGraph {
 public:
  DenseGraph(OnnxModel& model, const NetworkWeights& weights)
      : graph_(model),
        weights_(weights),
        options_(weights.options()),
        shape_(dense_shape(options_)),
        joints_(options_.joint_count()),
        side_(options_.patch.size_px / kMapStride),
        cells_(std::int64_t{side_} * side_) {}

  void add() {
    const std::int64_t size = options_.patch.size_px;
    graph_.input("patch", {1, 1, size, size});
    features_ = add_encoder_decoder(graph_, shape_, weights_, "patch");
    add_nearest_depths();
    add_votes();
    add_landmarks();
    add_confidence();
    const DenseMaps maps(options_);
    if (maps.side) add_probability("right_hand", *maps.side);
    if (maps.hand) add_probability("hand", *maps.hand);
  }

 private:
  std::string head(const std::string& name, int first, int count) {
    return add_head(graph_, shape_, weights_, features_, {first, count}, name);
  }
  /// Maps of the joints as joints x cells.
  std::string as_rows(const std::string& maps, const std::string& name, int rows) {
    return graph_.reshape(maps, name, {rows, cells_});
  }
  std::string sum_over_cells(const std::string& values, const std::string& name) {
    return graph_.node("MatMul", {values, graph_.constant("ones", {cells_, 1}, 1.0f)}, name);
  }
  std::string to_all_cells(const std::string& values, const std::string& name) {
    return graph_.node("MatMul", {values, graph_.constant("row_of_ones", {1, cells_}, 1.0f)}, name);
  }
  /// A map as `channels` maps, times a factor, plus a bias.
  std::string repeated(const std::string& map, const std::string& name, int channels, float factor,
                       float bias) {
    return graph_.node("Conv",
                       {map, graph_.constant(name + ".factor", {channels, 1, 1, 1}, factor),
                        graph_.constant(name + ".bias", {channels}, bias)},
                       name, {{"kernel_shape", std::vector<std::int64_t>{1, 1}}});
  }
  std::string number(const std::string& name, float value) { return graph_.constant(name, {1}, value); }

  /// The nearest surface of each cell, and whether it is hand: 1, or 0 where it is background (at +1). The
  /// smallest distance from 1 that a float below it has, 2^-24, becomes 1, so nothing lies between.
  void add_nearest_depths() {
    const std::vector<std::int64_t> cell = {kMapStride, kMapStride};
    const std::string nearer = graph_.node("Neg", {"patch"}, "nearness");
    nearness_ =
        graph_.node("MaxPool", {nearer}, "nearness.cells", {{"kernel_shape", cell}, {"strides", cell}});
    const std::string one = number("one", 1.0f);
    const std::string ahead = graph_.node("Add", {nearness_, one}, "before_background");
    const std::string scaled =
        graph_.node("Mul", {ahead, number("two_to_24", 16777216.0f)}, "before_background.scaled");
    const std::string positive = graph_.node("Relu", {scaled}, "before_background.positive");
    const std::string rest =
        graph_.node("Sub", {number("one.minus_positive", 1.0f), positive}, "background.unbounded");
    const std::string background = graph_.node("Relu", {rest}, "background");
    hand_ = graph_.node("Sub", {number("one.minus_background", 1.0f), background}, "hand_cells");
  }

  /// What the softmax gives each cell for maps of so many channels.
  std::string shares(const std::string& name, int channels, const std::string& logits) {
    std::string lowered = repeated(hand_, name + ".lowered", channels, kNotHand, -kNotHand);
    if (!logits.empty()) lowered = graph_.node("Add", {logits, lowered}, name + ".logits");
    return graph_.node("Softmax", {as_rows(lowered, name + ".rows", channels)}, name,
                       {{"axis", std::int64_t{1}}});
  }

  std::string centres(const std::string& name, bool along_rows) {
    const double half = 0.5 * (options_.patch.size_px - 1);
    std::vector<float> values;
    for (std::int64_t i = 0; i < joints_ * cells_; ++i) {
      const std::int64_t cell = i % cells_;
      const auto place = static_cast<double>(along_rows ? cell % side_ : cell / side_);
      values.push_back(static_cast<float>((place * kMapStride + 0.5 * (kMapStride - 1) - half) / half));
    }
    return graph_.constant(name, {1, joints_, side_, side_}, std::move(values));
  }

  /// One coordinate of all votes: where the cell is, plus the offset times the distance.
  void add_votes() {
    const auto kernel = static_cast<float>(options_.dense.kernel);
    const std::string closeness = head("closeness", 3 * joints_, joints_);
    const std::string less =
        graph_.node("Mul", {closeness, number("minus_kernel", -kernel)}, "distance.less");
    const std::string distance = graph_.node("Add", {less, number("kernel", kernel)}, "distance");
    const std::array<std::string, 3> places = {centres("cells.u", true), centres("cells.v", false),
                                               repeated(nearness_, "cells.d", joints_, -1.0f, 0.0f)};
    for (std::size_t i = 0; i < places.size(); ++i) {
      const std::string axis(1, "uvd"[i]);
      const std::string offset = head("offset_" + axis, static_cast<int>(i) * joints_, joints_);
      const std::string reach = graph_.node("Mul", {offset, distance}, "reach_" + axis);
      const std::string vote = graph_.node("Add", {reach, places[i]}, "vote_" + axis);
      votes_[i] = as_rows(vote, "votes_" + axis, joints_);
    }
    shares_ = shares("shares", joints_, head("weight", 4 * joints_, joints_));
  }

  void add_landmarks() {
    for (std::size_t i = 0; i < votes_.size(); ++i) {
      const std::string part = graph_.node("Mul", {shares_, votes_[i]}, votes_[i] + ".shared");
      means_[i] = sum_over_cells(part, votes_[i] + ".mean");
    }
    const std::string table =
        graph_.node("Concat", {means_[0], means_[1], means_[2]}, "means", {{"axis", std::int64_t{1}}});
    graph_.reshape(table, "landmarks", {1, joints_, 3});
    graph_.output("landmarks", {1, joints_, 3});
  }

  /// exp(-spread / kSpreadScale), the spread being that of the votes.
  void add_confidence() {
    std::string squares;
    for (std::size_t i = 0; i < votes_.size(); ++i) {
      const std::string& vote = votes_[i];
      const std::string apart =
          graph_.node("Sub", {vote, to_all_cells(means_[i], vote + ".mean.all")}, vote + ".apart");
      const std::string square = graph_.node("Mul", {apart, apart}, vote + ".square");
      squares = i == 0 ? square : graph_.node("Add", {squares, square}, fmt::format("{}.squares", vote));
    }
    const std::string shared = graph_.node("Mul", {shares_, squares}, "squares.shared");
    const std::string spread = graph_.node("Sqrt", {sum_over_cells(shared, "variance")}, "spread");
    const auto scale = static_cast<float>(-1.0 / kSpreadScale);
    const std::string exponent = graph_.node("Mul", {spread, number("spread.scale", scale)}, "spread.scaled");
    graph_.reshape(graph_.node("Exp", {exponent}, "sureness"), "confidence", {1, joints_});
    graph_.output("confidence", {1, joints_});
  }

  /// A map's mean over the hand is a logit.
  void add_probability(const std::string& name, int map) {
    const std::string even = shares(name + ".shares", 1, {});
    const std::string logits = as_rows(head(name + ".map", map, 1), name + ".row", 1);
    const std::string mean =
        sum_over_cells(graph_.node("Mul", {even, logits}, name + ".shared"), name + ".logit");
    graph_.node("Sigmoid", {mean}, name);
    graph_.output(name, {1, 1});
  }

  GraphBuilder graph_;
  const NetworkWeights& weights_;
  const NetworkOptions& options_;
  EncoderDecoderShape shape_;
  int joints_;
  int side_;  // cells along a side of the patch
  std::int64_t cells_;
  std::string features_, nearness_, hand_, shares_;
  std::array<std::string, 3> votes_, means_;
};

}  // namespace

void add_dense_graph(OnnxModel& model, const NetworkWeights& weights) {
  DenseGraph(model, weights).add();
}

}  // namespace knuckle
