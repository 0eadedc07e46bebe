// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace knuckle {

/// Where a source's pixel coordinates start. Inside the library it is always `centre`.
enum class PixelOrigin {
  centre,  ///< the centre of the first pixel is (0, 0)
  corner,  ///< the outer corner of the first pixel is (0, 0), so its centre is (0.5, 0.5)
};

/// How a camera maps points to its image.
enum class CameraModel {
  projective,    ///< pinhole with OpenCV's distortion
  orthographic,  ///< parallel rays along z
};

/// Intrinsics of a depth camera: data only; camera/projection.h has the mathematics.
struct Camera {
  CameraModel model = CameraModel::projective;
  int width = 0;    ///< [px], at least 1
  int height = 0;   ///< [px], at least 1
  double fx = 0.0;  ///< focal length; px for a projective camera, px per mm for an orthographic one; never 0
  double fy = 0.0;  ///< the same down the image; negative where the set's y axis points up
  double cx = 0.0;  ///< principal point [px], pixel-centre coordinates
  double cy = 0.0;
  std::array<double, 8> distortion{};  ///< OpenCV's order: k1, k2, p1, p2, k3, k4, k5, k6; projective only

  bool is_distorted() const;
  bool operator==(const Camera&) const = default;
};

/// Throws an Error that names the field and its bound where a value is impossible.
void check(const Camera& camera);

/// Moves the principal point from the coordinates of one pixel origin to another's (half a pixel).
Camera with_pixel_origin(Camera camera, PixelOrigin from, PixelOrigin to);

/// The camera of the mirrored image: column u of this camera is column width - 1 - u of the result, and the x
/// axis points the other way. The sign of the tangential coefficient p2 flips with it, so the result is
/// exact.
Camera mirrored(Camera camera);

}  // namespace knuckle
