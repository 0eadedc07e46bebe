// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_skin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "knuckle/core/statistics.h"

namespace knuckle {

/// In palm lengths: medians over 240 frames of manifests/test_creative.toml, fingers alike.
double depth_below_skin_mm(Landmark landmark, double palm_mm) {
  constexpr int kWristAndPalm = 2;  // landmarks of the 22 before those of the digits
  constexpr int kPerDigit = 4;
  constexpr double kWrist = 0.38;
  constexpr double kPalm = 0.30;
  constexpr std::array<double, kPerDigit> kThumb{0.35, 0.17, 0.105, 0.035};
  constexpr std::array<double, kPerDigit> kFinger{0.17, 0.085, 0.065, 0.03};
  if (landmark == Landmark::wrist) return kWrist * palm_mm;
  if (landmark == Landmark::palm) return kPalm * palm_mm;
  const int number = static_cast<int>(landmark) - kWristAndPalm;
  if (number < 0 || static_cast<int>(landmark) >= kSupersetSize) return 0.0;
  const auto part = static_cast<std::size_t>(number % kPerDigit);
  return palm_mm * (number < kPerDigit ? kThumb : kFinger)[part];
}

SkinDepths skin_depths(const std::vector<ImagePoint>& landmarks) {
  constexpr double kMarginMm = 45.0;  // fingers that were estimated wrong may be that far off
  constexpr int kFewest = 3;
  SkinDepths depths{.near_mm = 1e9, .far_mm = 0.0};
  int known = 0;
  for (const ImagePoint& point : landmarks) {
    if (point.is_missing()) continue;
    depths.near_mm = std::min(depths.near_mm, point.depth_mm - kMarginMm);
    depths.far_mm = std::max(depths.far_mm, point.depth_mm + kMarginMm);
    ++known;
  }
  return known < kFewest ? SkinDepths() : depths;
}

std::optional<double> skin_depth_at(const Frame& frame, double u, double v, const SkinDepths& depths) {
  constexpr int kFarthestPx = 6;
  const int column = static_cast<int>(std::lround(u));
  const int row = static_cast<int>(std::lround(v));
  for (int reach = 1; reach <= kFarthestPx; ++reach) {
    std::vector<double> found;
    for (int y = std::max(0, row - reach); y <= std::min(frame.depth_mm.height() - 1, row + reach); ++y) {
      for (int x = std::max(0, column - reach); x <= std::min(frame.depth_mm.width() - 1, column + reach);
           ++x) {
        const auto depth = static_cast<double>(frame.depth_mm(x, y));
        if (is_measured(frame.depth_mm(x, y)) && depth >= depths.near_mm && depth <= depths.far_mm)
          found.push_back(depth);
      }
    }
    if (!found.empty()) return median(std::move(found));
  }
  return std::nullopt;
}

ImagePoint placed_on_pixel(const Frame& frame, double u, double v, Landmark landmark, double palm_mm,
                           double depth_mm, const SkinDepths& depths) {
  const auto skin = skin_depth_at(frame, u, v, depths);
  if (skin) return {u, v, *skin + depth_below_skin_mm(landmark, palm_mm)};
  return depth_mm > 0.0 ? ImagePoint{u, v, depth_mm} : ImagePoint{};
}

double settled_depth_mm(double measured_mm, double fitted_mm) {
  constexpr double kFarMm = 30.0;
  constexpr double kFarthestMm = 20.0;
  const double apart = (fitted_mm - measured_mm) / kFarMm;
  const double trust = 2.0 * std::pow(1.0 + apart * apart, -2.0);
  const double settled = (trust * measured_mm + fitted_mm) / (trust + 1.0);
  return std::clamp(settled, measured_mm - kFarthestMm, measured_mm + kFarthestMm);
}

}  // namespace knuckle
