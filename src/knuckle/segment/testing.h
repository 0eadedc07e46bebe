// SPDX-License-Identifier: Apache-2.0
// Made-up frames for tests and benchmarks; not part of the library.
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "knuckle/camera/projection.h"
#include "knuckle/core/box.h"
#include "knuckle/core/frame.h"
#include "knuckle/core/random.h"
#include "knuckle/forest/pixel_forest.h"

namespace knuckle::testing {

/// A camera of 320 x 240 pixels like those of the paper's time.
inline Camera quarter_vga_camera() {
  Camera camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = 241.42;
  camera.fy = 241.42;
  camera.cx = 160.0;
  camera.cy = 120.0;
  return camera;
}

/// Takes every measured pixel for a hand.
inline PixelForest trusting_forest() {
  PixelForest::Parts parts;
  parts.trees.roots = {0};
  parts.trees.nodes = {{~0, {}, 0}};
  parts.leaf_codes = {255};
  return {parts, "test"};
}

inline Frame blank_frame(const Camera& camera) {
  Frame frame;
  frame.name = "made_up";
  frame.camera = camera;
  frame.depth_mm = Image<float>(camera.width, camera.height);
  return frame;
}

/// Keeps the nearer of two surfaces.
inline void put_depth(Frame& frame, int column, int row, double depth_mm) {
  float& pixel = frame.depth_mm(column, row);
  if (pixel == 0.0f || depth_mm < pixel) pixel = static_cast<float>(depth_mm);
}

/// A box that the ball's picture lies in, with room to spare for perspective and distortion.
inline Box picture_box(const Camera& camera, const Point3& centre, double radius_mm) {
  const Box image{0, 0, camera.width, camera.height};
  const double nearest_mm = centre.z() - radius_mm;
  if (nearest_mm <= 0) return image;
  const Projection projection(camera);
  const ImagePoint place = projection.to_image(centre);
  const double reach = 2.0 * radius_mm * projection.pixels_per_mm(nearest_mm) + 2.0;
  const int size = static_cast<int>(2.0 * reach) + 1;
  return intersection(image,
                      {static_cast<int>(place.u - reach), static_cast<int>(place.v - reach), size, size});
}

/// Draws a ball by intersecting the rays of the pixels with it.
inline void draw_ball(Frame& frame, const RayTable& rays, const Point3& centre, double radius_mm) {
  const bool is_parallel = frame.camera.model == CameraModel::orthographic;
  const Box box = picture_box(frame.camera, centre, radius_mm);
  for (int row = box.y; row < box.bottom(); ++row) {
    for (int column = box.x; column < box.right(); ++column) {
      const double x = rays.rays_x()(column, row);
      const double y = rays.rays_y()(column, row);
      const Point3 origin = is_parallel ? Point3(x, y, 0) : Point3(0, 0, 0);
      const Point3 direction = is_parallel ? Point3(0, 0, 1) : Point3(x, y, 1);
      const double a = direction.squaredNorm();
      const double b = direction.dot(centre - origin);
      const double c = (centre - origin).squaredNorm() - radius_mm * radius_mm;
      const double discriminant = b * b - a * c;
      if (discriminant >= 0) put_depth(frame, column, row, (b - std::sqrt(discriminant)) / a);
    }
  }
}

inline void draw_ball(Frame& frame, const Point3& centre, double radius_mm) {
  draw_ball(frame, RayTable(frame.camera), centre, radius_mm);
}

/// Draws a rod of balls.
inline void draw_rod(Frame& frame, const RayTable& rays, const Point3& from, const Point3& to,
                     double radius_mm) {
  const int count = 1 + static_cast<int>((to - from).norm() / (0.35 * radius_mm));
  for (int i = 0; i <= count; ++i) {
    draw_ball(frame, rays, from + (to - from) * (static_cast<double>(i) / count), radius_mm);
  }
}

/// Draws something like a right hand with its forearm: a palm, five spread and bent fingers, an arm. About
/// 190 mm from the wrist to the tip of the middle finger. `random` varies it.
inline void draw_hand(Frame& frame, const Point3& palm, Random& random) {
  const RayTable rays(frame.camera);
  const double turn = random.uniform(-0.8, 0.8);  // in the image plane
  const double tilt = random.uniform(-0.8, 0.8);  // towards the camera
  const Eigen::Matrix3d camera_from_hand =
      (Eigen::AngleAxisd(turn, Point3::UnitZ()) * Eigen::AngleAxisd(tilt, Point3::UnitX()))
          .toRotationMatrix();
  const auto at = [&](double x, double y, double z) -> Point3 {
    return palm + camera_from_hand * Point3(x, y, z);
  };
  for (int i = 0; i < 4; ++i) draw_rod(frame, rays, at(-27 + 18 * i, 40, 0), at(-30 + 20 * i, -40, 0), 13);
  constexpr std::array<double, 4> kLengths{70, 80, 74, 58};
  for (int i = 0; i < 4; ++i) {
    const double bend = random.uniform(0.0, 1.4);
    const double spread = 0.15 * (i - 1.5);
    const double length = kLengths[i];
    const Point3 root = at(-30 + 20 * i, -45, 0);
    const Point3 middle = root + camera_from_hand * Point3(spread * length / 2, -length / 2, 0);
    const Point3 tip =
        middle + camera_from_hand * (Point3(spread, -std::cos(bend), -std::sin(bend)) * (length / 2));
    draw_rod(frame, rays, root, middle, 9);
    draw_rod(frame, rays, middle, tip, 8);
  }
  draw_rod(frame, rays, at(-30, 25, 0), at(-75, -20, -10), 10);
  draw_rod(frame, rays, at(0, 45, 0), at(0, 330, 60), 28);
}

/// A hand, a body behind it, and noise, with exactly `measured` measured pixels (the rest of the body is cut
/// away).
inline Frame hand_frame(std::uint64_t seed, int measured = 20000) {
  Random random(seed);
  Frame frame = blank_frame(quarter_vga_camera());
  draw_hand(frame, Point3(random.uniform(-60, 60), random.uniform(-40, 40), random.uniform(400, 550)),
            random);
  int count = 0;
  for (const float depth : frame.depth_mm.pixels()) count += is_measured(depth) ? 1 : 0;
  for (std::size_t i = frame.depth_mm.size(); i-- > 0;) {  // the body, from the bottom up
    float& depth = frame.depth_mm.data()[i];
    if (is_measured(depth)) {
      if (count > measured) depth = 0.0f, --count;
    } else if (count < measured) {
      depth = 800.0f, ++count;
    }
  }
  for (float& depth : frame.depth_mm.pixels()) {
    if (is_measured(depth)) depth += static_cast<float>(3.0 * random.normal());
  }
  return frame;
}

}  // namespace knuckle::testing
