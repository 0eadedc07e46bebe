// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/window_matching.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "knuckle/synth/sensor/depth_edges.h"
#include "knuckle/synth/sensor/pixel_random.h"

namespace knuckle {
namespace {

constexpr std::uint32_t kWholeFrame = 0xffffffffu;  ///< the pixel of what is drawn once a frame

/// 1 / z of each pixel; 0 where nothing was measured.
Image<double> inverse_depths(const Image<float>& depth_mm) {
  Image<double> inverse(depth_mm.width(), depth_mm.height());
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    const float depth = depth_mm.data()[i];
    inverse.data()[i] = depth != 0.0f ? 1.0 / depth : 0.0;
  }
  return inverse;
}

/// Sums of 1 / z and counts of measured pixels over rectangles.
class InverseSums {
 public:
  InverseSums(const Image<float>& depth_mm, const Image<double>& inverse)
      : stride_(depth_mm.width() + 1),
        sums_(static_cast<std::size_t>(stride_) * (depth_mm.height() + 1)),
        counts_(sums_.size()) {
    for (int row = 0; row < depth_mm.height(); ++row) {
      const float* depths = depth_mm.row(row).data();
      const double* inverses = inverse.row(row).data();
      double sum = 0.0;
      std::int32_t count = 0;
      const std::size_t above = static_cast<std::size_t>(row) * stride_;
      for (int column = 0; column < depth_mm.width(); ++column) {
        sum += inverses[column];
        count += depths[column] != 0.0f ? 1 : 0;
        sums_[above + stride_ + column + 1] = sums_[above + column + 1] + sum;
        counts_[above + stride_ + column + 1] = counts_[above + column + 1] + count;
      }
    }
  }

  /// The depth of the mean of 1 / z over columns [left, right) and rows [top, bottom), which hold a
  /// measurement.
  float mean_depth(int left, int top, int right, int bottom) const {
    const auto over = [&](const auto& values) {
      return values[place(right, bottom)] - values[place(left, bottom)] - values[place(right, top)] +
             values[place(left, top)];
    };
    return static_cast<float>(over(counts_) / over(sums_));
  }

 private:
  std::size_t place(int column, int row) const { return static_cast<std::size_t>(row) * stride_ + column; }

  int stride_;
  std::vector<double> sums_;
  std::vector<std::int32_t> counts_;
};

struct Window {
  int left, top, right, bottom;
};

Window window_at(const Image<float>& image, int column, int row, int reach) {
  return {std::max(column - reach, 0), std::max(row - reach, 0), std::min(column + reach + 1, image.width()),
          std::min(row + reach + 1, image.height())};
}

/// 1 where a window holds a depth edge.
Image<std::uint8_t> windows_with_edges(const Image<float>& depth_mm, int reach, double jump_mm) {
  Image<std::uint8_t> has_edge(depth_mm.width(), depth_mm.height());
  for (const std::int32_t pixel : edge_pixels(depth_mm, jump_mm)) {
    const Window window = window_at(depth_mm, pixel % depth_mm.width(), pixel / depth_mm.width(), reach);
    for (int row = window.top; row < window.bottom; ++row)
      std::fill(has_edge.row(row).begin() + window.left, has_edge.row(row).begin() + window.right, 1);
  }
  return has_edge;
}

/// Sums over the pixels of one surface in a window.
struct Surface {
  double inverse_sum = 0.0;
  int count = 0;
  float depth() const { return static_cast<float>(count / inverse_sum); }
};

/// The depth that a window with an edge finds; 0: none.
float matched_at_edge(const Image<float>& depth_mm, const Image<double>& inverse, const Window& window,
                      double nearer_share, double jump_mm, bool is_doubtful_lost) {
  float nearest = INFINITY;
  const auto each = [&](const auto& take) {
    for (int row = window.top; row < window.bottom; ++row) {
      const float* depths = depth_mm.row(row).data();
      const double* inverses = inverse.row(row).data();
      for (int column = window.left; column < window.right; ++column)
        if (depths[column] != 0.0f) take(depths[column], inverses[column]);
    }
  };
  each([&](float depth, double /*inverse*/) { nearest = std::min(nearest, depth); });
  Surface nearer;
  Surface farther;
  each([&](float depth, double inverse_depth) {
    Surface& surface = depth <= nearest + jump_mm ? nearer : farther;
    surface.inverse_sum += inverse_depth;
    ++surface.count;
  });
  const int area = (window.right - window.left) * (window.bottom - window.top);
  constexpr double kDoubt = 0.06;
  const double excess = static_cast<double>(nearer.count) / area - nearer_share;
  if (is_doubtful_lost && std::abs(excess) < kDoubt) return 0.0f;
  if (excess > 0.0) return nearer.depth();
  return 2 * (area - nearer.count) > 0 && 2 * farther.count > area - nearer.count ? farther.depth() : 0.0f;
}

}  // namespace

void WindowMatchingOptions::visit(OptionVisitor& visitor) {
  visitor.integer("window_px", window_px, closed(0, 16));
  visitor.integer("widest_window_px", widest_window_px, closed(0, 16));
  visitor.real("window_share", window_share, closed(0, 1));
  visitor.real("nearer_share", nearer_share, closed(0, 1));
  visitor.real("largest_nearer_share", largest_nearer_share, closed(0, 1));
  visitor.real("window_grain", window_grain, closed(0, 4));
}

int drawn_window_px(const WindowMatchingOptions& options, std::uint64_t seed) {
  const auto words = pixel_words(seed, PixelUse::matching, kWholeFrame);
  if (uniform_from_bits(words[0]) >= static_cast<float>(options.window_share)) return 0;
  const int widest = std::max(options.window_px, options.widest_window_px);
  const auto choices = static_cast<std::uint32_t>(widest - options.window_px + 1);
  return options.window_px + static_cast<int>(words[1] % choices);
}

double drawn_nearer_share(const WindowMatchingOptions& options, std::uint64_t seed) {
  const double largest = std::max(options.nearer_share, options.largest_nearer_share);
  const auto words = pixel_words(seed, PixelUse::matching, kWholeFrame);
  return options.nearer_share +
         (largest - options.nearer_share) * static_cast<double>(uniform_from_bits(words[2]));
}

Image<float> matched_in_windows(const Image<float>& depth_mm, const WindowMatchingOptions& options,
                                double jump_mm, std::uint64_t seed) {
  const int reach = drawn_window_px(options, seed);
  if (reach == 0) return depth_mm;
  const double nearer_share = drawn_nearer_share(options, seed);
  const Image<double> inverse = inverse_depths(depth_mm);
  const InverseSums sums(depth_mm, inverse);
  const Image<std::uint8_t> has_edge = windows_with_edges(depth_mm, reach, jump_mm);
  Image<float> matched(depth_mm.width(), depth_mm.height());
  for (int row = 0; row < depth_mm.height(); ++row) {
    for (int column = 0; column < depth_mm.width(); ++column) {
      const Window window = window_at(depth_mm, column, row, reach);
      if (has_edge(column, row) == 0) {
        if (depth_mm(column, row) == 0.0f) continue;  // as all in its window
        matched(column, row) = sums.mean_depth(window.left, window.top, window.right, window.bottom);
        continue;
      }
      const auto pixel = static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(depth_mm.width()) +
                         static_cast<std::uint32_t>(column);
      const bool is_doubtful_lost = (pixel_words(seed, PixelUse::matching, pixel)[0] & 1u) != 0;
      matched(column, row) =
          matched_at_edge(depth_mm, inverse, window, nearer_share, jump_mm, is_doubtful_lost);
    }
  }
  return matched;
}

}  // namespace knuckle
