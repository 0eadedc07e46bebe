// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/detector_augmentation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace knuckle {
namespace {

constexpr double kNearestCutMm = 700.0;
constexpr double kFarthestCutMm = 2500.0;
constexpr int kLeastSeenCells = 6;       // of a hand
constexpr double kLeastSeenShare = 0.1;  // of the disc of its extent
constexpr double kSeenDepth = 1.5;       // how far before or behind its centre a hand is [extents]
constexpr double kMillimetresPerMetre = 1000.0;

struct Middle {
  explicit Middle(const DetectorOptions& options)
      : u(0.5 * (options.width - 1)), v(0.5 * (options.height - 1)) {}
  double u;
  double v;
};

/// The cells of a picture whose distance to (u, v) is at most `radius`, in a square around them.
struct CellsAround {
  CellsAround(const DetectorOptions& options, double u, double v, double radius)
      : left(first(u - radius, options.width)),
        right(first(u + radius + 1.0, options.width)),
        top(first(v - radius, options.height)),
        bottom(first(v + radius + 1.0, options.height)) {}

  /// The first cell at or behind a place, in [0, count].
  static int first(double place, int count) {
    return static_cast<int>(std::ceil(std::clamp(place, 0.0, static_cast<double>(count))));
  }

  int left;
  int right;  ///< behind the last
  int top;
  int bottom;  ///< behind the last
};

/// Forgets the cells of an input where `is_lost(column, row)`.
template <class IsLost>
void lose_cells(const DetectorOptions& options, std::span<float> input, const IsLost& is_lost) {
  const std::size_t cells = input.size() / kMeasuredInputs;
  for (int row = 0; row < options.height; ++row) {
    for (int column = 0; column < options.width; ++column) {
      if (!is_lost(column, row)) continue;
      const std::size_t i = static_cast<std::size_t>(row) * options.width + column;
      input[i] = input[cells + i] = 0.0f;
    }
  }
}

/// Forgets the cells nearer than `radius` to (u, v).
void lose_disc(const DetectorOptions& options, std::span<float> input, double u, double v, double radius) {
  const std::size_t cells = input.size() / kMeasuredInputs;
  const CellsAround near(options, u, v, radius);
  for (int row = near.top; row < near.bottom; ++row) {
    for (int column = near.left; column < near.right; ++column) {
      if (std::hypot(column - u, row - v) >= radius) continue;
      const std::size_t i = static_cast<std::size_t>(row) * options.width + column;
      input[i] = input[cells + i] = 0.0f;
    }
  }
}

}  // namespace

void DetectorAugmentation::visit(OptionVisitor& visitor) {
  visitor.real("mirrored_share", mirrored_share, closed(0, 1));
  visitor.real("zoom", zoom, closed(0, 0.9));
  visitor.real("shift_cells", shift_cells, closed(0, 512));
  visitor.real("rotation_deg", rotation_deg, closed(0, 180));
  visitor.real("noise_per_m", noise_per_m, closed(0, 1));
  visitor.real("missing_share", missing_share, closed(0, 0.9));
  visitor.integer("erased_discs", erased_discs, closed(0, 100));
  visitor.real("erased_cells", erased_cells, closed(0, 512));
  visitor.real("cut_share", cut_share, closed(0, 1));
}

PictureView random_view(const DetectorAugmentation& augmentation, Random& random) {
  PictureView view;
  view.is_mirrored = random.uniform() < augmentation.mirrored_share;
  view.zoom = std::exp(random.uniform(-1.0, 1.0) * std::log(1.0 + augmentation.zoom));
  view.rotation = random.uniform(-1.0, 1.0) * augmentation.rotation_deg * std::numbers::pi / 180.0;
  view.shift_u = random.uniform(-1.0, 1.0) * augmentation.shift_cells;
  view.shift_v = random.uniform(-1.0, 1.0) * augmentation.shift_cells;
  return view;
}

void view_cells(const DetectorSample& sample, const DetectorOptions& options, const PictureView& view,
                std::span<float> input) {
  const Middle middle(options);
  const double cosine = std::cos(view.rotation) / view.zoom;
  const double sine = std::sin(view.rotation) / view.zoom;
  const std::size_t cells = input.size() / kMeasuredInputs;
  const auto zoom = static_cast<float>(view.zoom);
  std::size_t i = 0;
  for (int row = 0; row < options.height; ++row) {
    const double dv = row - middle.v - view.shift_v;
    for (int column = 0; column < options.width; ++column, ++i) {
      const int turned = view.is_mirrored ? options.width - 1 - column : column;
      const double du = turned - middle.u - view.shift_u;
      const auto u = static_cast<int>(std::floor(cosine * du + sine * dv + middle.u + 0.5));
      const auto v = static_cast<int>(std::floor(cosine * dv - sine * du + middle.v + 0.5));
      const bool is_inside = u >= 0 && u < options.width && v >= 0 && v < options.height;
      const std::size_t from = is_inside ? static_cast<std::size_t>(v) * options.width + u : 0;
      input[i] = is_inside ? std::min(zoom * DetectorSamples::inverse_depth_of_code(sample.codes[from]),
                                      static_cast<float>(kMostInverseDepth))
                           : 0.0f;
      input[cells + i] = is_inside ? DetectorSamples::share_of(sample.measured[from]) : 0.0f;
    }
  }
}

void view_hands(const DetectorSample& sample, const DetectorOptions& options, const PictureView& view,
                std::span<float> hands) {
  const Middle middle(options);
  const double cosine = std::cos(view.rotation) * view.zoom;
  const double sine = std::sin(view.rotation) * view.zoom;
  std::ranges::copy(sample.hands, hands.begin());
  for (std::size_t first = 0; first < hands.size(); first += kHandNumbers) {
    float* const hand = hands.data() + first;
    if (std::isnan(hand[kHandCounts])) continue;
    const double du = hand[kHandU] - middle.u;
    const double dv = hand[kHandV] - middle.v;
    double u = cosine * du - sine * dv + middle.u + view.shift_u;
    const double v = sine * du + cosine * dv + middle.v + view.shift_v;
    if (view.is_mirrored) {
      u = options.width - 1 - u;
      hand[kHandSide] = 1.0f - hand[kHandSide];
    }
    hand[kHandU] = static_cast<float>(u);
    hand[kHandV] = static_cast<float>(v);
    hand[kHandInverseDepth] += static_cast<float>(std::log(view.zoom));
    const bool is_inside = u >= 0.0 && u <= options.width - 1 && v >= 0.0 && v <= options.height - 1;
    if (!is_inside) hand[kHandCounts] = 0.0f;
  }
}

void spoil_cells(const DetectorAugmentation& augmentation, const DetectorOptions& options, Random& random,
                 std::span<float> input) {
  const double deviation = random.uniform() * augmentation.noise_per_m;
  const std::span<float> inverse_depths = input.first(input.size() / kMeasuredInputs);
  for (float& inverse : inverse_depths) {
    if (inverse > 0.0f) {
      inverse = std::max(1e-3f, inverse + static_cast<float>(deviation * random.normal()));
    }
  }
  const double lost = random.uniform() * augmentation.missing_share;
  lose_cells(options, input, [&](int, int) { return random.uniform() < lost; });
  const auto discs = random.below(static_cast<std::uint32_t>(augmentation.erased_discs) + 1);
  for (std::uint32_t i = 0; i < discs; ++i) {
    const double u = random.uniform(0.0, options.width);
    const double v = random.uniform(0.0, options.height);
    const double radius = random.uniform() * augmentation.erased_cells;
    lose_disc(options, input, u, v, radius);
  }
  if (random.uniform() < augmentation.cut_share) {
    const double farthest = kMillimetresPerMetre / random.uniform(kNearestCutMm, kFarthestCutMm);
    lose_cells(options, input, [&](int column, int row) {
      return input[static_cast<std::size_t>(row) * options.width + column] < farthest;
    });
  }
}

void excuse_unseen_hands(const DetectorOptions& options, std::span<const float> input,
                         std::span<float> hands) {
  for (std::size_t first = 0; first < hands.size(); first += kHandNumbers) {
    float* const hand = hands.data() + first;
    if (std::isnan(hand[kHandCounts])) continue;
    const double depth_m = std::exp(-static_cast<double>(hand[kHandInverseDepth]));
    const double extent_m =
        kExtentUnitMm / kMillimetresPerMetre * std::exp(static_cast<double>(hand[kHandExtent]));
    const double radius = options.focal_cells * extent_m / depth_m;
    int seen = 0;
    const CellsAround near(options, hand[kHandU], hand[kHandV], radius);
    for (int row = near.top; row < near.bottom; ++row) {
      for (int column = near.left; column < near.right; ++column) {
        if (std::hypot(column - hand[kHandU], row - hand[kHandV]) > radius) continue;
        const double inverse = input[static_cast<std::size_t>(row) * options.width + column];
        seen += inverse > 0.0 && std::abs(1.0 / inverse - depth_m) < kSeenDepth * extent_m ? 1 : 0;
      }
    }
    const double least =
        std::max<double>(kLeastSeenCells, kLeastSeenShare * std::numbers::pi * radius * radius);
    if (seen < least) hand[kHandCounts] = 0.0f;
  }
}

}  // namespace knuckle
