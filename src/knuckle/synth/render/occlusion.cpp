// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/render/occlusion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace knuckle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double depth_at(const Rendering& rendering, int column, int row) {
  const bool is_seen = rendering.face(column, row) != Rendering::kNoFace;
  return is_seen ? rendering.depth_mm(column, row) : kInfinity;
}

/// The pixel that holds a place; -1 where there is none.
int pixel_of(double place) {
  constexpr double kFarthest = 1e6;
  return std::abs(place) < kFarthest ? static_cast<int>(std::floor(place + 0.5)) : -1;
}

Occluder occluder_of(PixelLabel label) {
  switch (label) {
    case PixelLabel::hand:
    case PixelLabel::other_hand:
      return Occluder::other_hand;
    case PixelLabel::person:
      return Occluder::person;
    default:
      return Occluder::object;
  }
}

Occluder occluder_at(int column, int row, double landmark_mm, double flesh, const Rendering& hand,
                     std::span<const LabelledRendering> others) {
  const double skin = depth_at(hand, column, row);
  double nearest = std::min(skin, landmark_mm);
  Occluder occluder = skin < landmark_mm - flesh ? Occluder::own_hand : Occluder::none;
  for (const auto& [label, rendering] : others) {
    const double depth = depth_at(*rendering, column, row);
    if (depth >= nearest) continue;
    nearest = depth;
    occluder = occluder_of(label);
  }
  return occluder;
}

}  // namespace

double flesh_mm(Landmark landmark, const std::array<Point3, kSupersetSize>& landmarks) {
  const double palm_mm = (landmarks[static_cast<std::size_t>(Landmark::middle_mcp)] -
                          landmarks[static_cast<std::size_t>(Landmark::wrist)])
                             .norm();
  constexpr int kThumb = static_cast<int>(Landmark::thumb_cmc);
  constexpr std::array<double, 4> kThumbFlesh = {0.32, 0.24, 0.19, 0.15};
  constexpr std::array<double, 4> kFingerFlesh = {0.28, 0.16, 0.14, 0.12};
  if (landmark == Landmark::wrist) return 0.42 * palm_mm;
  if (landmark == Landmark::palm) return 0.48 * palm_mm;
  const int place = static_cast<int>(landmark) - kThumb;
  return (place < 4 ? kThumbFlesh[place] : kFingerFlesh[place % 4]) * palm_mm;
}

std::vector<Occluder> occluders_of(const std::array<Point3, kSupersetSize>& landmarks, const HandPose& pose,
                                   const Rendering& hand, std::span<const LabelledRendering> others) {
  std::vector<Occluder> occluders;
  for (int i = 0; i < kSupersetSize; ++i) {
    const ImagePoint& point = pose.joints[i];
    const int column = pixel_of(point.u);
    const int row = pixel_of(point.v);
    occluders.push_back(hand.face.contains(column, row)
                            ? occluder_at(column, row, landmarks[i].z(),
                                          flesh_mm(static_cast<Landmark>(i), landmarks), hand, others)
                            : Occluder::border);
  }
  return occluders;
}

}  // namespace knuckle
