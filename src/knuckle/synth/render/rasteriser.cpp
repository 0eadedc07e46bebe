// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/render/rasteriser.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/synth/render/point_projector.h"

namespace knuckle {
namespace {

/// Triangles of at most this extent are drawn in blocks: edge functions of up to 64 px fit 32 bits [px].
constexpr int kSmallExtent = 24;

/// Keys and faces of the pixels so far, with a margin at the right that nobody sees.
struct Canvas {
  static constexpr int kMargin = 8;

  explicit Canvas(const Camera& camera)
      : width(camera.width),
        key(camera.width + kMargin, camera.height, -std::numeric_limits<float>::infinity()),
        face(camera.width + kMargin, camera.height, Rendering::kNoFace) {}

  void see_rows(int first, int last) {
    top = std::min(top, first);
    bottom = std::max(bottom, last);
  }
  /// Empty again; most groups of faces are seen in few rows.
  void clear() {
    for (int row = top; row <= bottom; ++row) {
      std::ranges::fill(key.row(row), -std::numeric_limits<float>::infinity());
      std::ranges::fill(face.row(row), Rendering::kNoFace);
    }
    top = key.height();
    bottom = -1;
  }

  int width;
  Image<float> key;
  Image<std::int32_t> face;
  int top = key.height();  ///< Rows from here
  int bottom = -1;         ///< to here may have been drawn in.
};

/// Value of a triangle's edge function at a pixel, less what the top-left rule takes away, in units of one
/// subpixel along the edge: at least 0 inside. `column` and `row` are its steps from one pixel to the next.
template <class Integer>
struct Edge {
  Integer value;
  Integer column;
  Integer row;

  Edge(const Place& from, const Place& to, int first_column, int first_row) {
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
};

int first_pixel(std::int32_t subpixel) {
  return (subpixel + kSubpixels - 1) >> kSubpixelBits;
}
int last_pixel(std::int32_t subpixel) {
  return subpixel >> kSubpixelBits;
}

inline PixelRange covered_range(const Place& a, const Place& b, const Place& c, const Canvas& canvas) {
  return {std::max(first_pixel(std::min({a.x, b.x, c.x})), 0),
          std::min(last_pixel(std::max({a.x, b.x, c.x})), canvas.width - 1),
          std::max(first_pixel(std::min({a.y, b.y, c.y})), 0),
          std::min(last_pixel(std::max({a.y, b.y, c.y})), canvas.key.height() - 1)};
}

/// The key of a triangle over the pixels of one row, from its first one on.
struct KeyRow {
  float first;
  float step;
  float low;
  float high;

  KeyRow(const KeyPlane& plane, const PixelRange& range, int row)
      : first(static_cast<float>(plane.origin + plane.column * range.left + plane.row * row)),
        step(static_cast<float>(plane.column)),
        low(plane.low),
        high(plane.high) {}

  float at(int steps) const {
    return std::min(std::max(first + step * static_cast<float>(steps), low), high);
  }
};

/// Draws eight pixels at once, without a branch: a pixel beyond the triangle's range fails an edge, and one
/// beyond the image lies in the canvas' margin.
void fill_in_blocks(Canvas& canvas, const PixelRange& range, const Corner& a, const Corner& b,
                    const Corner& c, std::int32_t face) {
  using Integer = std::int32_t;
  Edge<Integer> ab(a.place, b.place, range.left, range.top);
  Edge<Integer> bc(b.place, c.place, range.left, range.top);
  Edge<Integer> ca(c.place, a.place, range.left, range.top);
  const KeyPlane plane(a, b, c);
  for (int row = range.top; row <= range.bottom; ++row) {
    const KeyRow key_at(plane, range, row);
    for (int column = range.left; column <= range.right; column += Canvas::kMargin) {
      const int steps = column - range.left;
      float* keys = canvas.key.row(row).data() + column;
      std::int32_t* faces = canvas.face.row(row).data() + column;
      for (int lane = 0; lane < Canvas::kMargin; ++lane) {
        const Integer step = steps + lane;
        const Integer edges =
            (ab.value + step * ab.column) | (bc.value + step * bc.column) | (ca.value + step * ca.column);
        const float key = key_at.at(step);
        const bool is_nearer = (edges >= 0) & (key > keys[lane]);  // no branch
        keys[lane] = is_nearer ? key : keys[lane];
        faces[lane] = is_nearer ? face : faces[lane];
      }
    }
    ab.value += ab.row;
    bc.value += bc.row;
    ca.value += ca.row;
  }
}

/// The steps [first, last] of a row at which edges are at least 0.
struct Span {
  int first;
  int last;

  void cut(const Edge<std::int64_t>& edge) {
    if (last < first) return;
    const bool is_inside = edge.value >= 0;
    if (edge.column > 0 && !is_inside) {
      first =
          static_cast<int>(std::clamp<std::int64_t>((-edge.value - 1) / edge.column + 1, first, last + 1));
    } else if (edge.column <= 0 && !is_inside) {
      last = first - 1;
    } else if (edge.column < 0) {
      last = static_cast<int>(std::min<std::int64_t>(last, edge.value / -edge.column));
    }
  }
};

/// Draws rows from edge to edge: of a wide triangle most pixels of its range lie outside of it, or far
/// inside.
void fill_in_spans(Canvas& canvas, const PixelRange& range, const Corner& a, const Corner& b, const Corner& c,
                   std::int32_t face) {
  std::array edges{Edge<std::int64_t>(a.place, b.place, range.left, range.top),
                   Edge<std::int64_t>(b.place, c.place, range.left, range.top),
                   Edge<std::int64_t>(c.place, a.place, range.left, range.top)};
  const KeyPlane plane(a, b, c);
  for (int row = range.top; row <= range.bottom; ++row) {
    const KeyRow key_at(plane, range, row);
    Span span{0, range.right - range.left};
    for (Edge<std::int64_t>& edge : edges) {
      span.cut(edge);
      edge.value += edge.row;
    }
    float* keys = canvas.key.row(row).data() + range.left;
    std::int32_t* faces = canvas.face.row(row).data() + range.left;
    for (int step = span.first; step <= span.last; ++step) {
      const float key = key_at.at(step);
      const bool is_nearer = key > keys[step];
      keys[step] = is_nearer ? key : keys[step];
      faces[step] = is_nearer ? face : faces[step];
    }
  }
}

inline bool is_small(const Place& a, const Place& b, const Place& c) {
  constexpr std::int32_t kLimit = kSmallExtent * kSubpixels;
  return std::max({a.x, b.x, c.x}) - std::min({a.x, b.x, c.x}) < kLimit &&
         std::max({a.y, b.y, c.y}) - std::min({a.y, b.y, c.y}) < kLimit;
}

/// Twice the area in square subpixels; positive where the corners go from the x axis to the y axis.
inline std::int64_t double_area(const Place& a, const Place& b, const Place& c) {
  return std::int64_t{b.x - a.x} * (c.y - a.y) - std::int64_t{b.y - a.y} * (c.x - a.x);
}

/// Whether a triangle shows a side that is drawn. `front_sign` is the sign of a front face's area, or 0 where
/// both sides are drawn.
inline bool is_shown(std::int64_t area, int front_sign) {
  return front_sign > 0 ? area > 0 : front_sign < 0 ? area < 0 : area != 0;
}

/// The corners of eight triangles.
struct TriangleBlock {
  static constexpr std::size_t kSize = 8;
  using Lanes = std::array<std::int32_t, kSize>;
  Lanes ax, ay, bx, by, cx, cy;

  void set(std::size_t lane, const Place& a, const Place& b, const Place& c) {
    ax[lane] = a.x;
    ay[lane] = a.y;
    bx[lane] = b.x;
    by[lane] = b.y;
    cx[lane] = c.x;
    cy[lane] = c.y;
  }

  /// 1 where a triangle may be drawn: it may be turned the right way, can be drawn, and may cover a pixel's
  /// centre. No branch: of a body's faces a quarter is drawn, in no order that a processor could foresee.
  Lanes may_be_drawn(const Canvas& canvas, int front_sign) const {
    constexpr float kRounding = 1e-6f;  // of the area in single precision, in parts of its terms
    const std::int32_t last_column = (canvas.width - 1) * kSubpixels;
    const std::int32_t last_row = (canvas.key.height() - 1) * kSubpixels;
    const auto front = static_cast<float>(front_sign);
    Lanes drawn;
    for (std::size_t i = 0; i < kSize; ++i) {
      const float one = static_cast<float>(bx[i] - ax[i]) * static_cast<float>(cy[i] - ay[i]);
      const float other = static_cast<float>(by[i] - ay[i]) * static_cast<float>(cx[i] - ax[i]);
      const float slack = kRounding * (std::abs(one) + std::abs(other));
      const std::int32_t left = std::max(std::min(std::min(ax[i], bx[i]), cx[i]), 0);
      const std::int32_t right = std::min(std::max(std::max(ax[i], bx[i]), cx[i]), last_column);
      const std::int32_t top = std::max(std::min(std::min(ay[i], by[i]), cy[i]), 0);
      const std::int32_t bottom = std::min(std::max(std::max(ay[i], by[i]), cy[i]), last_row);
      const std::int32_t is_shown = (one - other) * front >= -slack ? 1 : 0;
      const std::int32_t has_column = first_pixel(left) <= last_pixel(right) ? 1 : 0;
      const std::int32_t has_row = first_pixel(top) <= last_pixel(bottom) ? 1 : 0;
      drawn[i] = is_shown & has_column & has_row;
    }
    return drawn;
  }
};

/// The faces that may be drawn, in their order; the first of `faces` has the number `first_number`.
std::vector<std::int32_t> drawn_faces(std::span<const std::array<std::int32_t, 3>> faces,
                                      std::size_t first_number, const std::vector<Place>& places,
                                      const Canvas& canvas, int front_sign) {
  std::vector<std::int32_t> drawn(faces.size() + TriangleBlock::kSize);
  std::size_t count = 0;
  TriangleBlock block;
  for (std::size_t first = 0; first < faces.size(); first += TriangleBlock::kSize) {
    const std::size_t size = std::min(TriangleBlock::kSize, faces.size() - first);
    for (std::size_t i = 0; i < TriangleBlock::kSize; ++i) {
      const auto& [a, b, c] = faces[first + std::min(i, size - 1)];
      block.set(i, places[a], places[b], places[c]);
    }
    const TriangleBlock::Lanes may_be_drawn = block.may_be_drawn(canvas, front_sign);
    for (std::size_t i = 0; i < size; ++i) {
      drawn[count] = static_cast<std::int32_t>(first_number + first + i);
      count += static_cast<std::size_t>(may_be_drawn[i]);
    }
  }
  drawn.resize(count);
  return drawn;
}

inline void draw(Canvas& canvas, const ProjectedPoints& points, const std::array<std::int32_t, 3>& triangle,
                 std::int32_t face, int front_sign) {
  const Place a = points.places[triangle[0]];
  const Place b = points.places[triangle[1]];
  const Place c = points.places[triangle[2]];
  const std::int64_t area = double_area(a, b, c);
  if (!is_shown(area, front_sign) || !(a.is_drawable() && b.is_drawable() && c.is_drawable())) return;
  const PixelRange range = covered_range(a, b, c, canvas);
  canvas.see_rows(range.top, range.bottom);
  const Corner first = points.corner(triangle[0]);
  const Corner second = points.corner(triangle[area > 0 ? 1 : 2]);
  const Corner third = points.corner(triangle[area > 0 ? 2 : 1]);
  if (is_small(a, b, c)) {
    fill_in_blocks(canvas, range, first, second, third, face);
  } else {
    fill_in_spans(canvas, range, first, second, third, face);
  }
}

/// The part of a triangle in front of the near plane: a polygon of three or four corners.
std::vector<Eigen::Vector3f> clipped(const std::array<Eigen::Vector3f, 3>& triangle, float near_mm) {
  std::vector<Eigen::Vector3f> polygon;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3f& from = triangle[i];
    const Eigen::Vector3f& to = triangle[(i + 1) % 3];
    if (from.z() >= near_mm) polygon.push_back(from);
    if ((from.z() >= near_mm) != (to.z() >= near_mm)) {
      polygon.push_back(from + (to - from) * ((near_mm - from.z()) / (to.z() - from.z())));
      polygon.back().z() = near_mm;
    }
  }
  return polygon;
}

/// Faces [first, end) of a mesh.
struct FaceRange {
  std::size_t first;
  std::size_t end;
};

/// Draws what is in front of the near plane of the faces that cross it.
void draw_crossing_faces(Canvas& canvas, const TriangleMesh& mesh, const FaceRange& range, double near_mm,
                         const PointProjector& project, int front_sign) {
  for (std::size_t f = range.first; f < range.end; ++f) {
    const auto [a, b, c] = mesh.faces[f];
    const std::array<Eigen::Vector3f, 3> triangle = {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
    const auto is_near = [&](const Eigen::Vector3f& corner) { return corner.z() < near_mm; };
    const auto near_corners = std::ranges::count_if(triangle, is_near);
    if (near_corners == 0 || near_corners == 3) continue;
    const std::vector<Eigen::Vector3f> polygon = clipped(triangle, static_cast<float>(near_mm));
    const ProjectedPoints points = project(polygon);
    for (std::int32_t i = 2; i < static_cast<std::int32_t>(polygon.size()); ++i) {
      draw(canvas, points, {0, i - 1, i}, static_cast<std::int32_t>(f), front_sign);
    }
  }
}

/// Counter-clockwise from outside is a positive area in an image whose y axis points down, once x or y is
/// flipped the sign changes.
int front_sign_of(const Camera& camera, FaceCulling culling) {
  if (culling == FaceCulling::none) return 0;
  return camera.fx * camera.fy > 0 ? -1 : 1;
}

Rendering rendering_of(const Canvas& canvas, const Camera& camera) {
  Rendering result{Image<float>(camera.width, camera.height),
                   Image<std::int32_t>(camera.width, camera.height, Rendering::kNoFace)};
  const bool projective = is_projective(camera);
  for (int row = canvas.top; row <= canvas.bottom; ++row) {
    const float* keys = canvas.key.row(row).data();
    const std::int32_t* faces = canvas.face.row(row).data();
    float* depths = result.depth_mm.row(row).data();
    for (int column = 0; column < camera.width; ++column) {
      const float depth = projective ? 1.0f / keys[column] : -keys[column];
      depths[column] = faces[column] == Rendering::kNoFace ? 0.0f : depth;
    }
    std::copy_n(faces, camera.width, result.face.row(row).data());
  }
  return result;
}

}  // namespace

std::vector<Rendering> render_groups(const TriangleMesh& mesh, std::span<const std::size_t> ends,
                                     const Camera& camera, const RasteriserOptions& options) {
  check(camera);
  if (!(options.near_mm > 0.0)) fail("rasteriser: near_mm is {}, expected above 0", options.near_mm);
  const PointProjector project(camera, static_cast<float>(options.near_mm));
  const ProjectedPoints points = project(mesh.vertices);
  const int front_sign = front_sign_of(camera, options.culling);
  const auto is_near = [&](const Eigen::Vector3f& vertex) { return vertex.z() < options.near_mm; };
  const bool may_cross = std::ranges::any_of(mesh.vertices, is_near);
  std::vector<Rendering> renderings;
  Canvas canvas(camera);
  std::size_t first = 0;
  for (const std::size_t end : ends) {
    if (end < first || end > mesh.faces.size())
      fail("rasteriser: a group of faces ends at {}, expected {} to {}", end, first, mesh.faces.size());
    const auto group = mesh.faces.subspan(first, end - first);
    for (const std::int32_t f : drawn_faces(group, first, points.places, canvas, front_sign)) {
      draw(canvas, points, mesh.faces[f], f, front_sign);
    }
    if (may_cross) draw_crossing_faces(canvas, mesh, {first, end}, options.near_mm, project, front_sign);
    renderings.push_back(rendering_of(canvas, camera));
    canvas.clear();
    first = end;
  }
  return renderings;
}

Rendering render(const TriangleMesh& mesh, const Camera& camera, const RasteriserOptions& options) {
  return std::move(render_groups(mesh, std::array{mesh.faces.size()}, camera, options).front());
}

Rendering nearest_of(std::span<const Rendering> renderings) {
  Rendering nearest = renderings.front();
  for (const Rendering& other : renderings.subspan(1)) {
    float* depths = nearest.depth_mm.data();
    std::int32_t* faces = nearest.face.data();
    for (std::size_t i = 0; i < nearest.face.size(); ++i) {
      const float depth = other.depth_mm.data()[i];
      const bool is_nearer = (other.face.data()[i] != Rendering::kNoFace) &
                             ((faces[i] == Rendering::kNoFace) | (depth < depths[i]));
      depths[i] = is_nearer ? depth : depths[i];
      faces[i] = is_nearer ? other.face.data()[i] : faces[i];
    }
  }
  return nearest;
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
