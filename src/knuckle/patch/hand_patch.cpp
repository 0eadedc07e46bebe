// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/hand_patch.h"

namespace knuckle {
namespace {

/// Image pixels from the patch's centre to the centre of its first or last pixel: what 1 in patch coordinates
/// is.
double half_extent(const PatchGeometry& geometry) {
  return 0.5 * (geometry.size_px - 1) * geometry.image_px_per_patch_px;
}

}  // namespace

PatchPoint PatchGeometry::to_patch(const ImagePoint& point) const {
  return {(point.u - centre_u) / half_extent(*this), (point.v - centre_v) / half_extent(*this),
          (point.depth_mm - mean_depth_mm) / depth_deviation_mm};
}

ImagePoint PatchGeometry::to_image(const PatchPoint& point) const {
  return {centre_u + point.u * half_extent(*this), centre_v + point.v * half_extent(*this),
          mean_depth_mm + point.d * depth_deviation_mm};
}

}  // namespace knuckle
