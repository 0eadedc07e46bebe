// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/rasteriser.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr int kSubpixelBits = 12;
constexpr int kSubpixels = 1 << kSubpixelBits;
/// Corners farther from the image than this do not fit the integers [px]. Only what all but touches the
/// camera is.
constexpr double kGuardBand = 1 << 17;
/// Triangles of at most this extent have edge functions that fit 32 bits [px].
constexpr int kSmallExtent = 64;

/// A corner in the image. `key` grows towards the camera and is linear in the image over a plane.
struct Corner {
  double u = 0.0;
  double v = 0.0;
  double key = 0.0;
  std::int32_t x = 0;  ///< u and v in subpixels
  std::int32_t y = 0;
  bool is_drawable = false;
};

bool is_projective(const Camera& camera) {
  return camera.model == CameraModel::projective;
}

/// Maps points to corners; knows how far from the axis the camera's distortion can be trusted.
class CornerProjection {
 public:
  explicit CornerProjection(const Camera& camera)
      : projection_(camera), camera_(camera), is_distorted_(camera.is_distorted()) {
    if (is_distorted_) widest_ray_ = 1.2 * widest_ray_of_border();
  }

  Corner operator()(const Eigen::Vector3d& point) const {
    return is_distorted_ ? distorted(point) : undistorted(point);
  }

 private:
  Corner undistorted(const Eigen::Vector3d& point) const {
    const double scale = is_projective(camera_) ? 1.0 / point.z() : 1.0;
    return corner(camera_.fx * point.x() * scale + camera_.cx, camera_.fy * point.y() * scale + camera_.cy,
                  point.z());
  }

  /// The polynomials fold far outside the image: such points are not drawn.
  Corner distorted(const Eigen::Vector3d& point) const {
    if (point.head<2>().norm() > widest_ray_ * point.z()) return {};
    const ImagePoint image_point = projection_.to_image(point);
    return corner(image_point.u, image_point.v, point.z());
  }

  Corner corner(double u, double v, double z) const {
    if (!(std::abs(u) < kGuardBand && std::abs(v) < kGuardBand)) return {};
    return {.u = u,
            .v = v,
            .key = is_projective(camera_) ? 1.0 / z : -z,
            .x = static_cast<std::int32_t>(std::floor(u * kSubpixels + 0.5)),
            .y = static_cast<std::int32_t>(std::floor(v * kSubpixels + 0.5)),
            .is_drawable = true};
  }

  double widest_ray_of_border() const {
    double widest = 0.0;
    const auto widen = [&](double u, double v) {
      widest = std::max(widest, projection_.to_camera(ImagePoint{u, v, 1.0}).head<2>().norm());
    };
    for (int column = 0; column < camera_.width; ++column) {
      widen(column, 0);
      widen(column, camera_.height - 1);
    }
    for (int row = 0; row < camera_.height; ++row) {
      widen(0, row);
      widen(camera_.width - 1, row);
    }
    return widest;
  }

  Projection projection_;
  Camera camera_;
  bool is_distorted_;
  double widest_ray_ = 0.0;
};

/// Keys and faces of the pixels so far.
struct Canvas {
  Image<float> key;
  Image<std::int32_t> face;
};

/// Value of a triangle's edge function at a pixel, less what the top-left rule takes away, in units of one
/// subpixel along the edge: at least 0 inside. `column` and `row` are its steps from one pixel to the next.
template <class Integer>
struct Edge {
  Integer value;
  Integer column;
  Integer row;

  Edge(const Corner& from, const Corner& to, int first_column, int first_row) {
    const std::int64_t dx = to.x - from.x;
    const std::int64_t dy = to.y - from.y;
    const bool is_top_left = dy < 0 || (dy == 0 && dx > 0);
    const std::int64_t at_pixel = dx * (std::int64_t{first_row} * kSubpixels - from.y) -
                                  dy * (std::int64_t{first_column} * kSubpixels - from.x) -
                                  (is_top_left ? 0 : 1);
    // From pixel to pixel the value changes by whole multiples of kSubpixels: the rest never changes the
    // sign.
    value = static_cast<Integer>(at_pixel >> kSubpixelBits);
    column = static_cast<Integer>(-dy);
    row = static_cast<Integer>(dx);
  }
};

/// The key over a triangle's plane, kept between the keys of its corners: where the triangle is seen edge on,
/// the plane is too steep to be trusted outside.
struct KeyPlane {
  double origin;  ///< at pixel (0, 0)
  double column;
  double row;
  float low;
  float high;

  KeyPlane(const Corner& a, const Corner& b, const Corner& c) {
    const double bu = b.u - a.u;
    const double bv = b.v - a.v;
    const double cu = c.u - a.u;
    const double cv = c.v - a.v;
    const double determinant = bu * cv - bv * cu;
    const double scale = determinant != 0.0 ? 1.0 / determinant : 0.0;
    column = ((b.key - a.key) * cv - (c.key - a.key) * bv) * scale;
    row = ((c.key - a.key) * bu - (b.key - a.key) * cu) * scale;
    origin = a.key - column * a.u - row * a.v;
    low = static_cast<float>(std::min({a.key, b.key, c.key}));
    high = static_cast<float>(std::max({a.key, b.key, c.key}));
  }
};

/// Pixels [left, right] x [top, bottom] whose centres may lie in a triangle.
struct PixelRange {
  int left;
  int right;
  int top;
  int bottom;
  bool empty() const { return left > right || top > bottom; }
};

int first_pixel(std::int32_t subpixel) {
  return (subpixel + kSubpixels - 1) >> kSubpixelBits;
}
int last_pixel(std::int32_t subpixel) {
  return subpixel >> kSubpixelBits;
}

PixelRange covered_range(const Corner& a, const Corner& b, const Corner& c, const Canvas& canvas) {
  return {std::max(first_pixel(std::min({a.x, b.x, c.x})), 0),
          std::min(last_pixel(std::max({a.x, b.x, c.x})), canvas.key.width() - 1),
          std::max(first_pixel(std::min({a.y, b.y, c.y})), 0),
          std::min(last_pixel(std::max({a.y, b.y, c.y})), canvas.key.height() - 1)};
}

template <class Integer>
void fill(Canvas& canvas, const PixelRange& range, const Corner& a, const Corner& b, const Corner& c,
          std::int32_t face) {
  Edge<Integer> ab(a, b, range.left, range.top);
  Edge<Integer> bc(b, c, range.left, range.top);
  Edge<Integer> ca(c, a, range.left, range.top);
  const KeyPlane plane(a, b, c);
  const int width = range.right - range.left + 1;
  const auto key_step = static_cast<float>(plane.column);
  for (int row = range.top; row <= range.bottom; ++row) {
    const auto first_key = static_cast<float>(plane.origin + plane.column * range.left + plane.row * row);
    float* keys = canvas.key.row(row).data() + range.left;
    std::int32_t* faces = canvas.face.row(row).data() + range.left;
    Integer e0 = ab.value;
    Integer e1 = bc.value;
    Integer e2 = ca.value;
    for (int i = 0; i < width; ++i) {
      const float key = std::clamp(first_key + key_step * static_cast<float>(i), plane.low, plane.high);
      if ((e0 | e1 | e2) >= 0 && key > keys[i]) {
        keys[i] = key;
        faces[i] = face;
      }
      e0 += ab.column;
      e1 += bc.column;
      e2 += ca.column;
    }
    ab.value += ab.row;
    bc.value += bc.row;
    ca.value += ca.row;
  }
}

bool is_small(const Corner& a, const Corner& b, const Corner& c) {
  constexpr std::int32_t kLimit = kSmallExtent * kSubpixels;
  return std::max({a.x, b.x, c.x}) - std::min({a.x, b.x, c.x}) < kLimit &&
         std::max({a.y, b.y, c.y}) - std::min({a.y, b.y, c.y}) < kLimit;
}

/// `front_sign` is the sign of a front face's area in the image, or 0 where both sides are drawn.
void draw(Canvas& canvas, const Corner& a, const Corner& b, const Corner& c, std::int32_t face,
          int front_sign) {
  if (!(a.is_drawable && b.is_drawable && c.is_drawable)) return;
  const PixelRange range = covered_range(a, b, c, canvas);
  if (range.empty()) return;
  const std::int64_t area = std::int64_t{b.x - a.x} * (c.y - a.y) - std::int64_t{b.y - a.y} * (c.x - a.x);
  if (area == 0 || (front_sign != 0 && (area > 0) != (front_sign > 0))) return;
  const Corner& second = area > 0 ? b : c;
  const Corner& third = area > 0 ? c : b;
  if (is_small(a, b, c)) {
    fill<std::int32_t>(canvas, range, a, second, third, face);
  } else {
    fill<std::int64_t>(canvas, range, a, second, third, face);
  }
}

/// The part of a triangle in front of the near plane: a polygon of three or four corners.
std::vector<Eigen::Vector3d> clipped(const std::array<Eigen::Vector3d, 3>& triangle, double near_mm) {
  std::vector<Eigen::Vector3d> polygon;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d& from = triangle[i];
    const Eigen::Vector3d& to = triangle[(i + 1) % 3];
    if (from.z() >= near_mm) polygon.push_back(from);
    if ((from.z() >= near_mm) != (to.z() >= near_mm)) {
      Eigen::Vector3d cut = from + (to - from) * ((near_mm - from.z()) / (to.z() - from.z()));
      cut.z() = near_mm;
      polygon.push_back(cut);
    }
  }
  return polygon;
}

void draw_clipped(Canvas& canvas, const std::array<Eigen::Vector3d, 3>& triangle, double near_mm,
                  const CornerProjection& corner_of, std::int32_t face, int front_sign) {
  const std::vector<Eigen::Vector3d> polygon = clipped(triangle, near_mm);
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    draw(canvas, corner_of(polygon[0]), corner_of(polygon[i - 1]), corner_of(polygon[i]), face, front_sign);
  }
}

/// Counter-clockwise from outside is a positive area in an image whose y axis points down, once x or y is
/// flipped the sign changes.
int front_sign_of(const Camera& camera, FaceCulling culling) {
  if (culling == FaceCulling::none) return 0;
  return camera.fx * camera.fy > 0 ? -1 : 1;
}

Image<float> depths_from_keys(const Canvas& canvas, const Camera& camera) {
  Image<float> depth_mm(canvas.key.width(), canvas.key.height());
  const float* keys = canvas.key.data();
  const std::int32_t* faces = canvas.face.data();
  float* depths = depth_mm.data();
  const bool projective = is_projective(camera);
  for (std::size_t i = 0; i < depth_mm.size(); ++i) {
    const float depth = projective ? 1.0f / keys[i] : -keys[i];
    depths[i] = faces[i] == Rendering::kNoFace ? 0.0f : depth;
  }
  return depth_mm;
}

}  // namespace

Rendering render(const TriangleMesh& mesh, const Camera& camera, const RasteriserOptions& options) {
  check(camera);
  if (!(options.near_mm > 0.0)) fail("rasteriser: near_mm is {}, expected above 0", options.near_mm);
  const CornerProjection corner_of(camera);
  std::vector<Corner> corners(mesh.vertices.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (mesh.vertices[i].z() >= options.near_mm) corners[i] = corner_of(mesh.vertices[i].cast<double>());
  }
  constexpr float kNothing = -std::numeric_limits<float>::infinity();
  Canvas canvas{Image<float>(camera.width, camera.height, kNothing),
                Image<std::int32_t>(camera.width, camera.height, Rendering::kNoFace)};
  const int front_sign = front_sign_of(camera, options.culling);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& [a, b, c] = mesh.faces[f];
    const int in_front = (mesh.vertices[a].z() >= options.near_mm) +
                         (mesh.vertices[b].z() >= options.near_mm) +
                         (mesh.vertices[c].z() >= options.near_mm);
    if (in_front == 3) {
      draw(canvas, corners[a], corners[b], corners[c], static_cast<std::int32_t>(f), front_sign);
    } else if (in_front > 0) {
      draw_clipped(
          canvas,
          {mesh.vertices[a].cast<double>(), mesh.vertices[b].cast<double>(), mesh.vertices[c].cast<double>()},
          options.near_mm, corner_of, static_cast<std::int32_t>(f), front_sign);
    }
  }
  Image<float> depth_mm = depths_from_keys(canvas, camera);
  return {std::move(depth_mm), std::move(canvas.face)};
}

Image<std::uint8_t> mask_of(const Rendering& rendering, std::span<const std::uint8_t> face_labels) {
  Image<std::uint8_t> mask(rendering.face.width(), rendering.face.height());
  std::span<const std::int32_t> faces = rendering.face.pixels();
  for (std::size_t i = 0; i < mask.size(); ++i) {
    mask.data()[i] = faces[i] != Rendering::kNoFace && face_labels[faces[i]] != 0 ? 1 : 0;
  }
  return mask;
}

}  // namespace knuckle
