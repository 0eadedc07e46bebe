// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/cube_patch.h"

#include <cmath>
#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"

namespace knuckle {
namespace {

/// Of each column (or row) of the patch the nearest column (or row) of an image that has `end` of them; -1
/// where it is outside.
std::vector<int> nearest_places(double centre, const PatchGeometry& geometry, int end) {
  std::vector<int> places(static_cast<std::size_t>(geometry.size_px), -1);
  const double first = centre - 0.5 * (geometry.size_px - 1) * geometry.image_px_per_patch_px;
  for (int i = 0; i < geometry.size_px; ++i) {
    const double place = std::floor(first + i * geometry.image_px_per_patch_px + 0.5);
    if (place >= 0.0 && place < end) places[i] = static_cast<int>(place);
  }
  return places;
}

/// Fills one line of the patch and returns how many of its pixels lie in the cube.
int fill_line(const std::vector<int>& columns, const float* depth_mm, const PatchGeometry& geometry,
              float* line) {
  const auto centre_mm = static_cast<float>(geometry.mean_depth_mm);
  const auto scale = static_cast<float>(1.0 / geometry.depth_deviation_mm);
  int count = 0;
  for (int i = 0; i < geometry.size_px; ++i) {
    const float depth = columns[i] < 0 ? 0.0f : depth_mm[columns[i]];
    const float d = (depth - centre_mm) * scale;
    const bool is_inside = is_measured(depth) && d > -1.0f && d < 1.0f;
    line[i] = is_inside ? d : kCubeBackground;
    count += is_inside ? 1 : 0;
  }
  return count;
}

}  // namespace

PatchGeometry cube_geometry(const Camera& camera, const ImagePoint& centre, const Cube& cube) {
  PatchGeometry geometry;
  geometry.size_px = cube.size_px;
  geometry.centre_u = centre.u;
  geometry.centre_v = centre.v;
  const double px_per_mm = std::abs(Projection(camera).pixels_per_mm(centre.depth_mm));
  geometry.image_px_per_patch_px = cube.side_mm * px_per_mm / cube.size_px;
  geometry.mean_depth_mm = centre.depth_mm;
  geometry.depth_deviation_mm = 0.5 * cube.side_mm;
  return geometry;
}

std::optional<HandPatch> extract_cube(const Frame& frame, const ImagePoint& centre, const Cube& cube) {
  if (cube.size_px < 2 || !(cube.side_mm > 0.0)) {
    fail("cube patch: a cube of {} mm on {} px, expected a side above 0 and at least 2 px", cube.side_mm,
         cube.size_px);
  }
  if (centre.is_missing() || centre.depth_mm <= 0.0) return std::nullopt;
  HandPatch patch;
  patch.camera = frame.camera;
  patch.geometry = cube_geometry(frame.camera, centre, cube);
  const std::vector<int> columns = nearest_places(centre.u, patch.geometry, frame.depth_mm.width());
  const std::vector<int> rows = nearest_places(centre.v, patch.geometry, frame.depth_mm.height());
  patch.pixels = Image<float>(cube.size_px, cube.size_px, kCubeBackground);
  int count = 0;
  for (int j = 0; j < cube.size_px; ++j) {
    if (rows[j] < 0) continue;
    count +=
        fill_line(columns, frame.depth_mm.row(rows[j]).data(), patch.geometry, patch.pixels.row(j).data());
  }
  if (count == 0) return std::nullopt;
  return patch;
}

}  // namespace knuckle
