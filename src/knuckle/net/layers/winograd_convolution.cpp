// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/winograd_convolution.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "knuckle/net/layers/lane_products.h"

namespace knuckle {
namespace {

constexpr std::size_t kKernel = 9;  // weights of an input and an output
/// Tiles that are worked on together: they share what is read of the weights, and stay in the second cache.
constexpr int kTilesPerStrip = 4 * kPixelsTogether;
/// Numbers between points in memory: at the distance of a power of two they would compete for the same lines.
constexpr int kPadding = kLanes;

template <class Tile>
constexpr std::size_t kPoints = std::size_t{Tile::kSide} * Tile::kSide;

template <class Number, std::size_t kSide>
using Square = std::array<std::array<Number, kSide>, kSide>;

int parts_of(int count, int most) {
  return (count + most - 1) / most;
}

/// The first of part `i` where `count` things are dealt to `parts` as evenly as can be.
int first_of_part(int i, int count, int parts) {
  return i * count / parts;
}

/// One transform along the rows, then along the columns.
template <class Number, std::size_t kTo, std::size_t kFrom, class Transform>
inline Square<Number, kTo> transformed(const Square<Number, kFrom>& square, const Transform& transform) {
  std::array<std::array<Number, kFrom>, kTo> columns;
  for (std::size_t y = 0; y < kFrom; ++y) {
    const std::array<Number, kTo> row = transform(square[y]);
    for (std::size_t x = 0; x < kTo; ++x) columns[x][y] = row[x];
  }
  Square<Number, kTo> result;
  for (std::size_t x = 0; x < kTo; ++x) {
    const std::array<Number, kTo> column = transform(columns[x]);
    for (std::size_t y = 0; y < kTo; ++y) result[y][x] = column[y];
  }
  return result;
}

/// The points of a kernel, in the order of a tile's.
template <class Tile>
std::array<float, kPoints<Tile>> kernel_points(std::span<const float> kernel) {
  Square<double, 3> square;
  for (std::size_t k = 0; k < kKernel; ++k) square[k / 3][k % 3] = kernel[k];
  const auto points = transformed<double, Tile::kSide>(square, Tile::kernel);
  std::array<float, kPoints<Tile>> numbers;
  for (std::size_t k = 0; k < numbers.size(); ++k)
    numbers[k] = static_cast<float>(points[k / Tile::kSide][k % Tile::kSide]);
  return numbers;
}

/// The products of a few tiles at one point of them.
struct ProductsAtPoint {
  template <int kTiles, int kVectors>
  static void run(const Window& window, const float* weights, float* products) {
    Sums<kTiles, kVectors> sums{};
    add_products<kTiles, kVectors>(window, weights, sums);
    for (int t = 0; t < kTiles; ++t)
      for (int v = 0; v < kVectors; ++v) store_lanes(products + (t * kVectors + v) * kLanes, sums[t][v]);
  }
};

template <int kVectors>
constexpr auto kProductsAtPoint = loops_by_pixels<ProductsAtPoint, kVectors>();

}  // namespace

/// Some tiles of a map, row by row.
template <class Tile>
struct WinogradConvolution<Tile>::Strip {
  const FeatureMap& input;
  FeatureMap& output;
  const FeatureMap* added;
  Activation activation;
  int first;
  int count;

  int row(int tile) const { return (first + tile) / per_row() * Tile::kOutputs; }
  int column(int tile) const { return (first + tile) % per_row() * Tile::kOutputs; }
  int per_row() const { return parts_of(output.width(), Tile::kOutputs); }
};

/// Of one thread.
template <class Tile>
struct WinogradConvolution<Tile>::Workspace {
  AlignedVector inputs;    // transformed: points x tiles x inputs
  AlignedVector products;  // points x tiles x outputs of a block
  AlignedVector outside;   // zeros, for what lies beyond the border

  void fit(int input_stride) {
    const auto enough = [](AlignedVector& numbers, std::size_t count) {
      if (numbers.size() < count) numbers.resize(count);
    };
    enough(inputs, kPoints<Tile> * static_cast<std::size_t>(kTilesPerStrip * input_stride + kPadding));
    enough(products, kPoints<Tile> * static_cast<std::size_t>(kTilesPerStrip * kOutputsTogether + kPadding));
    enough(outside, static_cast<std::size_t>(input_stride));
  }
};

template <class Tile>
WinogradConvolution<Tile>::WinogradConvolution(int inputs, int outputs, int input_stride,
                                               std::span<const float> weights, std::span<const float> bias)
    : outputs_(outputs), input_stride_(input_stride), bias_(bias.begin(), bias.end()) {
  bias_.resize(static_cast<std::size_t>(whole_lanes(outputs)));
  std::vector<float> points;
  for (std::size_t i = 0; i < weights.size(); i += kKernel) {
    const auto kernel = kernel_points<Tile>(weights.subspan(i, kKernel));
    points.insert(points.end(), kernel.begin(), kernel.end());
  }
  weights_ = weights_in_blocks(points, outputs, inputs, static_cast<int>(kPoints<Tile>), input_stride);
}

template <class Tile>
void WinogradConvolution<Tile>::apply(const FeatureMap& input, FeatureMap& output, Activation activation,
                                      const FeatureMap* added) const {
  thread_local Workspace workspace;
  workspace.fit(input_stride_);
  const int tiles = parts_of(output.height(), Tile::kOutputs) * parts_of(output.width(), Tile::kOutputs);
  const int strips = parts_of(tiles, kTilesPerStrip);
  const int outputs = whole_lanes(outputs_);
  for (int i = 0; i < strips; ++i) {
    const int first = first_of_part(i, tiles, strips);
    const Strip strip{input, output, added, activation, first, first_of_part(i + 1, tiles, strips) - first};
    transform_inputs(strip, workspace);
    int block = 0;
    for (; block + kOutputsTogether <= outputs; block += kOutputsTogether)
      apply_block<kVectorsTogether>(strip, workspace, block);
    if (block < outputs) apply_block<1>(strip, workspace, block);
  }
}

template <class Tile>
void WinogradConvolution<Tile>::transform_inputs(const Strip& strip, Workspace& workspace) const {
  const std::ptrdiff_t point_stride = strip.count * input_stride_ + kPadding;
  for (int tile = 0; tile < strip.count; ++tile) {
    Square<const float*, Tile::kSide> pixels;
    for (int y = 0; y < Tile::kSide; ++y) {
      for (int x = 0; x < Tile::kSide; ++x) {
        const int row = strip.row(tile) + y - 1;
        const int column = strip.column(tile) + x - 1;
        const bool is_there = row <= strip.input.height() && column <= strip.input.width();
        pixels[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] =
            is_there ? strip.input.pixel(row, column) : workspace.outside.data();
      }
    }
    for (int i = 0; i < input_stride_; i += kLanes) {
      Square<FloatLanes, Tile::kSide> read;
      for (std::size_t y = 0; y < Tile::kSide; ++y)
        for (std::size_t x = 0; x < Tile::kSide; ++x) read[y][x] = load_lanes(pixels[y][x] + i);
      const auto points = transformed<FloatLanes, Tile::kSide>(read, Tile::template input<FloatLanes>);
      float* to = workspace.inputs.data() + tile * input_stride_ + i;
      for (const auto& row : points)
        for (const FloatLanes& point : row) store_lanes(std::exchange(to, to + point_stride), point);
    }
  }
}

template <class Tile>
template <int kVectors>
void WinogradConvolution<Tile>::apply_block(const Strip& strip, Workspace& workspace,
                                            int first_output) const {
  constexpr int kOutputs = kVectors * kLanes;
  const int parts = parts_of(strip.count, kPixelsTogether);
  const float* weights = weights_.data() + static_cast<std::size_t>(first_output) * kPoints<Tile> *
                                               static_cast<std::size_t>(input_stride_);
  const float* inputs = workspace.inputs.data();
  float* products = workspace.products.data();
  for (std::size_t k = 0; k < kPoints<Tile>; ++k) {
    for (int part = 0; part < parts; ++part) {
      const int first = first_of_part(part, strip.count, parts);
      const int tiles = first_of_part(part + 1, strip.count, parts) - first;
      const Window window{inputs + first * input_stride_, input_stride_, 0, 1, input_stride_};
      kProductsAtPoint<kVectors>[static_cast<std::size_t>(tiles) - 1](window, weights,
                                                                      products + first * kOutputs);
    }
    weights += input_stride_ * kOutputs;
    inputs += strip.count * input_stride_ + kPadding;
    products += strip.count * kOutputs + kPadding;
  }
  write_outputs<kVectors>(strip, workspace, first_output);
}

template <class Tile>
template <int kVectors>
void WinogradConvolution<Tile>::write_outputs(const Strip& strip, const Workspace& workspace,
                                              int first_output) const {
  constexpr int kOutputs = kVectors * kLanes;
  const std::ptrdiff_t point_stride = strip.count * kOutputs + kPadding;
  for (int tile = 0; tile < strip.count; ++tile) {
    const int row = strip.row(tile);
    const int column = strip.column(tile);
    const int height = std::min(Tile::kOutputs, strip.output.height() - row);
    const int width = std::min(Tile::kOutputs, strip.output.width() - column);
    for (int i = 0; i < kOutputs; i += kLanes) {
      Square<FloatLanes, Tile::kSide> products;
      const float* from = workspace.products.data() + tile * kOutputs + i;
      for (auto& line : products)
        for (FloatLanes& product : line) product = load_lanes(std::exchange(from, from + point_stride));
      const auto sums = transformed<FloatLanes, Tile::kOutputs>(products, Tile::template output<FloatLanes>);
      const FloatLanes bias = load_lanes(bias_.data() + first_output + i);
      for (int y = 0; y < height; ++y) {
        float* to = strip.output.pixel(row + y, column) + first_output + i;
        const float* added =
            strip.added == nullptr ? nullptr : strip.added->pixel(row + y, column) + first_output + i;
        for (int x = 0; x < width; ++x) {
          const FloatLanes sum = sums[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] + bias;
          store_lanes(to, activated(sum, added, strip.activation));
          to += strip.output.pixel_stride();
          if (added != nullptr) added += strip.added->pixel_stride();
        }
      }
    }
  }
}

template class WinogradConvolution<Tile2>;
template class WinogradConvolution<Tile4>;

}  // namespace knuckle
