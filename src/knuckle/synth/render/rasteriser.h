// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"

namespace knuckle {

/// What lies outside the image of a face: nothing, or the backs of closed surfaces.
enum class FaceCulling {
  none,
  back_faces,  ///< skips faces seen from behind: the same picture of a closed surface in less time
};

/// A triangle mesh in camera coordinates [mm].
struct TriangleMesh {
  std::span<const Eigen::Vector3f> vertices;
  std::span<const std::array<std::int32_t, 3>> faces;  ///< counter-clockwise from outside
};

/// How a mesh is drawn.
struct RasteriserOptions {
  double near_mm = 20.0;  ///< what lies nearer is cut away, above 0 [mm]
  FaceCulling culling = FaceCulling::none;
};

/// What each pixel of a camera sees of a mesh.
struct Rendering {
  Image<float> depth_mm;     ///< distance along z at the pixel's centre [mm]; 0 where no face is seen
  Image<std::int32_t> face;  ///< the face that is seen, or kNoFace
  static constexpr std::int32_t kNoFace = -1;
};

/// The mesh in a z-buffer, sampled at the pixels' centres. Neighbouring triangles share the pixels of their
/// common edge without gap or overlap: corners are snapped to 1/4096 px, edge functions are exact integers
/// and the top-left rule decides ties (Pineda, "A parallel algorithm for polygon rasterization", 1988). Depth
/// follows the triangle's own plane, which is linear in the image in 1 / z (projective) or z (orthographic).
///
/// Under distortion the corners are distorted and the edges between them stay straight: right for triangles
/// of a few pixels, as bodies have them.
Rendering render(const TriangleMesh& mesh, const Camera& camera, const RasteriserOptions& options = {});

/// The same with a z-buffer for each of several groups of faces: group i begins where the last one ended and
/// ends before face `ends[i]`. Faces keep their numbers in the whole mesh. Throws an Error where the ends go
/// back or beyond the last face.
std::vector<Rendering> render_groups(const TriangleMesh& mesh, std::span<const std::size_t> ends,
                                     const Camera& camera, const RasteriserOptions& options = {});

/// What is seen where the things of several renderings of one mesh are all there: at each pixel the nearest,
/// of equals the first. There is at least one.
Rendering nearest_of(std::span<const Rendering> renderings);

/// 1 where the seen face's label is not 0, else 0. `face_labels` has one per face.
Image<std::uint8_t> mask_of(const Rendering& rendering, std::span<const std::uint8_t> face_labels);

}  // namespace knuckle
