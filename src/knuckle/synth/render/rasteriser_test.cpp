// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/render/rasteriser.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/synth/render/testing_ray_caster.h"

namespace knuckle {
namespace {

using testing::cast_ray;

struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::int32_t, 3>> faces;
  operator TriangleMesh() const { return {vertices, faces}; }
};

/// A closed ball with bumps that hide one another: `rings` x `2 rings` quads, outside counter-clockwise.
Mesh bumpy_ball(const Eigen::Vector3f& centre, float radius, int rings, float bump) {
  Mesh mesh;
  const int sectors = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const float theta = static_cast<float>(M_PI) * static_cast<float>(i) / static_cast<float>(rings);
      const float phi = static_cast<float>(M_PI) * static_cast<float>(j) / static_cast<float>(rings);
      const float r = radius * (1.0f + bump * std::sin(5.0f * theta) * std::cos(4.0f * phi));
      mesh.vertices.push_back(centre + r * Eigen::Vector3f(std::sin(theta) * std::cos(phi), std::cos(theta),
                                                           -std::sin(theta) * std::sin(phi)));
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const int a = i * sectors + j;
      const int b = i * sectors + (j + 1) % sectors;
      mesh.faces.push_back({a, a + sectors, b + sectors});
      mesh.faces.push_back({a, b + sectors, b});
    }
  }
  return mesh;
}

Camera small_camera() {
  return {.width = 80, .height = 60, .fx = 70.0, .fy = 71.0, .cx = 39.3, .cy = 29.8};
}

/// The nearest and the farthest depth that rays meet a hair's breadth around a pixel's centre.
std::pair<double, double> depths_around(const Mesh& mesh, const Projection& projection, int column, int row,
                                        double near_mm) {
  constexpr double kHair = 0.003;
  std::vector<double> depths;
  for (const auto& [du, dv] : {std::pair{kHair, 0.0}, {-kHair, 0.0}, {0.0, kHair}, {0.0, -kHair}}) {
    depths.push_back(cast_ray(mesh, projection, column + du, row + dv, near_mm).depth_mm);
  }
  const auto [low, high] = std::ranges::minmax(depths);
  return {low, high};
}

/// Compares each pixel with the ray through its centre: both see nothing, or the same depth within 0.05 mm.
/// Where they differ, the pixel must be a tie: rays around it differ as much.
void expect_like_rays(const Mesh& mesh, const Camera& camera, const RasteriserOptions& options = {}) {
  const Rendering rendering = render(mesh, camera, options);
  const Projection projection(camera);
  int seen = 0;
  int ties = 0;
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const bool is_seen = rendering.face(column, row) != Rendering::kNoFace;
      const double depth =
          is_seen ? rendering.depth_mm(column, row) : std::numeric_limits<double>::infinity();
      const double truth = cast_ray(mesh, projection, column, row, options.near_mm).depth_mm;
      ASSERT_EQ(is_seen, rendering.depth_mm(column, row) > 0.0f);
      seen += is_seen ? 1 : 0;
      if (depth == truth || std::abs(depth - truth) <= 0.05) continue;
      ++ties;
      const auto [low, high] = depths_around(mesh, projection, column, row, options.near_mm);
      ASSERT_GE(depth, low - 0.05) << column << ", " << row;
      ASSERT_LE(depth, high + 0.05) << column << ", " << row;
    }
  }
  EXPECT_GT(seen, camera.width * camera.height / 20);
  EXPECT_LT(ties, 5);
}

TEST(Rasteriser, AgreesWithRaysForAProjectiveCamera) {
  expect_like_rays(bumpy_ball({15, -10, 400}, 110, 24, 0.2f), small_camera());
}

TEST(Rasteriser, AgreesWithRaysWhereTrianglesAreLarge) {
  expect_like_rays(bumpy_ball({0, 10, 300}, 150, 5, 0.1f), small_camera());
}

TEST(Rasteriser, AgreesWithRaysWhereTheImageCutsTheMesh) {
  expect_like_rays(bumpy_ball({-160, 100, 350}, 120, 20, 0.2f), small_camera());
}

TEST(Rasteriser, AgreesWithRaysForAnOrthographicCamera) {
  Camera camera = small_camera();
  camera.model = CameraModel::orthographic;
  camera.fx = 0.25;
  camera.fy = 0.26;
  expect_like_rays(bumpy_ball({15, -10, 400}, 90, 24, 0.2f), camera);
}

TEST(Rasteriser, AgreesWithRaysUnderDistortionWhereTrianglesAreSmall) {
  Camera camera = small_camera();
  camera.distortion = {-0.17, 0.03, 0.002, -0.001};
  expect_like_rays(bumpy_ball({15, -10, 400}, 150, 60, 0.05f), camera);
}

TEST(Rasteriser, AgreesWithRaysWhereTheYAxisPointsUp) {
  Camera camera = small_camera();
  camera.fy = -camera.fy;
  expect_like_rays(bumpy_ball({15, -10, 400}, 110, 16, 0.2f), camera);
  expect_like_rays(bumpy_ball({15, -10, 400}, 110, 16, 0.2f), camera, {.culling = FaceCulling::back_faces});
}

TEST(Rasteriser, CutsAtTheNearPlane) {
  expect_like_rays(bumpy_ball({5, -10, 100}, 85, 16, 0.1f), small_camera(), {.near_mm = 60.0});
}

TEST(Rasteriser, NothingBehindTheCameraIsSeen) {
  const Rendering rendering = render(bumpy_ball({0, 0, -300}, 100, 10, 0.0f), small_camera());
  EXPECT_EQ(std::ranges::count(rendering.depth_mm.pixels(), 0.0f), 80 * 60);
  EXPECT_EQ(std::ranges::count(rendering.face.pixels(), Rendering::kNoFace), 80 * 60);
}

TEST(Rasteriser, SkippingBackFacesChangesNothingOnAClosedSurface) {
  const Mesh ball = bumpy_ball({15, -10, 400}, 110, 30, 0.2f);
  const Rendering all = render(ball, small_camera());
  const Rendering front = render(ball, small_camera(), {.culling = FaceCulling::back_faces});
  EXPECT_EQ(all.depth_mm, front.depth_mm);
  EXPECT_EQ(all.face, front.face);
}

/// Each triangle is drawn alone: where they tile the image, every pixel belongs to exactly one of them, also
/// where pixel centres lie exactly on edges and corners. A tile is 5 x 4 times `scale` pixels.
void expect_each_pixel_once(int scale) {
  Camera camera{
      .model = CameraModel::orthographic, .width = 40 * scale, .height = 30 * scale, .fx = 1.0, .fy = 1.0};
  Random random(7);
  Mesh grid;
  constexpr int kColumns = 9;
  for (int j = 0; j <= 8; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      // Half of the corners lie on pixel centres.
      const bool whole = random.below(2) == 0;
      const auto shift = [&] {
        return static_cast<float>(whole ? random.below(3) - 1.0 : random.uniform(-1, 1));
      };
      grid.vertices.emplace_back(5.0f * static_cast<float>(scale * i) + shift(),
                                 4.0f * static_cast<float>(scale * j) + shift(), 100.0f);
    }
  }
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i + 1 < kColumns; ++i) {
      const int a = j * kColumns + i;
      grid.faces.push_back({a, a + 1, a + kColumns});
      grid.faces.push_back({a + kColumns, a + 1, a + kColumns + 1});
    }
  }
  Image<int> count(camera.width, camera.height);
  for (std::size_t f = 0; f < grid.faces.size(); ++f) {
    const TriangleMesh one{grid.vertices, std::span(grid.faces).subspan(f, 1)};
    const Rendering rendering = render(one, camera);
    for (std::size_t i = 0; i < count.size(); ++i) count.data()[i] += rendering.face.data()[i] == 0 ? 1 : 0;
  }
  for (int row = 2; row < 30 * scale - 2; ++row) {
    for (int column = 2; column < 40 * scale - 4; ++column)
      ASSERT_EQ(count(column, row), 1) << column << ", " << row;
  }
}

TEST(Rasteriser, SmallTilesCoverEachPixelOnce) {
  expect_each_pixel_once(1);
}

TEST(Rasteriser, LargeTilesCoverEachPixelOnce) {
  expect_each_pixel_once(8);
}

TEST(Rasteriser, APlaneHasItsDepthExactly) {
  const Mesh plane{{{-1000, -1000, 300}, {1000, -1000, 700}, {1000, 1000, 700}, {-1000, 1000, 300}},
                   {{0, 1, 2}, {0, 2, 3}}};  // z = 500 + 0.2 x
  const Camera camera = small_camera();
  const Rendering rendering = render(plane, camera);
  for (int column = 0; column < camera.width; ++column) {
    const double ray = (column - camera.cx) / camera.fx;
    EXPECT_NEAR(rendering.depth_mm(column, 20), 500.0 / (1.0 - 0.2 * ray), 1e-3);
  }
}

TEST(Rasteriser, TheMaskIsThatOfTheLabels) {
  Mesh mesh = bumpy_ball({0, 0, 400}, 80, 12, 0.0f);
  std::vector<std::uint8_t> labels(mesh.faces.size());
  for (std::size_t f = 0; f < labels.size(); ++f) labels[f] = f % 3 == 0;
  const Rendering rendering = render(mesh, small_camera());
  const Image<std::uint8_t> mask = mask_of(rendering, labels);
  int hand = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const std::int32_t face = rendering.face.data()[i];
    EXPECT_EQ(mask.data()[i], face >= 0 && face % 3 == 0 ? 1 : 0);
    hand += mask.data()[i];
  }
  EXPECT_GT(hand, 20);
}

TEST(Rasteriser, RefusesImpossibleOptions) {
  const Mesh mesh = bumpy_ball({0, 0, 400}, 80, 4, 0.0f);
  EXPECT_THAT(testing::error_of([&] { render(mesh, small_camera(), {.near_mm = 0.0}); }),
              ::testing::HasSubstr("near_mm"));
  EXPECT_THAT(testing::error_of([&] { render(mesh, Camera{}); }), ::testing::HasSubstr("width"));
}

}  // namespace
}  // namespace knuckle
