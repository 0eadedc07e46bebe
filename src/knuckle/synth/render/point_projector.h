// SPDX-License-Identifier: Apache-2.0
// Private to the module: the first half of the rasteriser.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "knuckle/camera/projection.h"

namespace knuckle {

/// The rasteriser computes with whole parts of a pixel: its edges are exact.
inline constexpr int kSubpixelBits = 12;
inline constexpr int kSubpixels = 1 << kSubpixelBits;  ///< parts of a pixel's side

/// A place in the image in subpixels.
struct Place {
  std::int32_t x = kNowhere;
  std::int32_t y = kNowhere;
  static constexpr std::int32_t kNowhere = -(1 << 30);  ///< of a point that cannot be drawn

  bool is_drawable() const { return x != kNowhere; }
};

/// A corner in the image. `key` grows towards the camera and is linear in the image over a plane.
struct Corner {
  double u = 0.0;
  double v = 0.0;
  double key = 0.0;
  Place place;
};

/// Points projected into the image, an array for each coordinate: the loops over them have no branch.
struct ProjectedPoints {
  std::vector<double> u;
  std::vector<double> v;
  std::vector<double> key;
  std::vector<Place> places;

  /// So many points, none of which can be drawn yet.
  explicit ProjectedPoints(std::size_t size) : u(size), v(size), key(size), places(size) {}
  Corner corner(std::int32_t i) const { return {u[i], v[i], key[i], places[i]}; }
};

/// True where rays meet in one point, false where they are parallel.
inline bool is_projective(const Camera& camera) {
  return camera.model == CameraModel::projective;
}

/// Maps points into the image; knows how far from the axis the camera's distortion can be trusted.
class PointProjector {
 public:
  /// Points nearer than `near_mm` [mm] are not drawn.
  PointProjector(const Camera& camera, double near_mm);

  /// `points`: camera coordinates [mm].
  ProjectedPoints operator()(std::span<const Eigen::Vector3f> points) const;

 private:
  template <class Scale>
  void project_straight(std::span<const Eigen::Vector3f> points, ProjectedPoints& projected,
                        const Scale& scale_at) const;
  /// The polynomials fold far outside the image: such points are not drawn.
  void project_distorted(std::span<const Eigen::Vector3f> points, ProjectedPoints& projected) const;
  double widest_ray_of_border() const;

  Projection projection_;
  Camera camera_;
  double near_mm_;
  bool is_distorted_;
  double widest_ray_ = 0.0;
};

}  // namespace knuckle
