// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/depth_lookup.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "knuckle/core/statistics.h"

namespace knuckle {
namespace {

bool has_place(const ImagePoint& joint) {
  return std::isfinite(joint.u) && std::isfinite(joint.v);
}

/// The depth at the pixel nearest to a place; nothing where that is background.
std::optional<double> depth_at(const Frame& frame, const HandRegion& hand, const ImagePoint& joint) {
  if (!has_place(joint)) return std::nullopt;
  const double nearest_column = std::round(joint.u);
  const double nearest_row = std::round(joint.v);
  const Image<float>& depth_mm = frame.depth_mm;
  if (!(nearest_column >= 0 && nearest_column < depth_mm.width())) return std::nullopt;
  if (!(nearest_row >= 0 && nearest_row < depth_mm.height())) return std::nullopt;
  const int column = static_cast<int>(nearest_column);
  const int row = static_cast<int>(nearest_row);
  const int mask_column = column - hand.box.x;
  const int mask_row = row - hand.box.y;
  if (!hand.mask.contains(mask_column, mask_row) || hand.mask(mask_column, mask_row) == 0)
    return std::nullopt;
  if (!is_measured(depth_mm(column, row))) return std::nullopt;
  return depth_mm(column, row);
}

}  // namespace

void DepthLookupOptions::visit(OptionVisitor& visitor) {
  visitor.real("surface_offset_mm", surface_offset_mm, closed(0, 50));
}

DepthLookup::DepthLookup(const DepthLookupOptions& options) : options_(options) {
  check_options(options_, "depth look-up");
}

RefinedHand DepthLookup::refine(const Frame& frame, const HandRegion& hand, HandPose pose) const {
  std::vector<std::optional<double>> depths;
  std::vector<double> found;
  for (const ImagePoint& joint : pose.joints) {
    depths.push_back(depth_at(frame, hand, joint));
    if (depths.back()) found.push_back(*depths.back());
  }
  if (found.empty()) return {std::move(pose)};
  const double usual_mm = median(found);
  for (std::size_t i = 0; i < pose.joints.size(); ++i) {
    if (has_place(pose.joints[i]))
      pose.joints[i].depth_mm = depths[i].value_or(usual_mm) + options_.surface_offset_mm;
  }
  return {std::move(pose)};
}

}  // namespace knuckle
