// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/synth/render/rasteriser.h"

namespace knuckle {

/// Cosine of the angle between line of sight and surface normal at each pixel, [0, 1]; 0 where nothing is
/// seen. Exact: from the plane of the face that the pixel shows. The line of sight meets the plane n p = h
/// (n of length 1) at p = z r, where r is the pixel's ray with depth 1, so the cosine is h / (z |r|).
Image<float> surface_cosines(const Rendering& rendering, const TriangleMesh& mesh, const Camera& camera);

/// Squared length of each pixel's ray, from the camera to depth 1: at least 1, and 1 everywhere for an
/// orthographic camera.
Image<float> squared_ray_lengths(const Camera& camera);

}  // namespace knuckle
