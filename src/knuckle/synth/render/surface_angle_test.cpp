// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/render/surface_angle.h"

#include <cmath>

#include <Eigen/Geometry>

#include "knuckle/camera/projection.h"
#include "knuckle/core/angle.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

/// A large square of small triangles, 600 mm before the camera, turned about the vertical.
struct Board {
  explicit Board(double turn_deg) {
    constexpr int kCells = 80;
    const Eigen::AngleAxisf turn(static_cast<float>(turn_deg * kDegree), Eigen::Vector3f::UnitY());
    normal = turn * Eigen::Vector3f(0, 0, -1);
    for (int row = 0; row <= kCells; ++row) {
      for (int column = 0; column <= kCells; ++column) {
        const Eigen::Vector3f flat(10.0f * (column - kCells / 2), 10.0f * (row - kCells / 2), 0.0f);
        vertices.emplace_back(turn * flat + Eigen::Vector3f(0, 0, 600));
        if (row == kCells || column == kCells) continue;
        const int first = row * (kCells + 1) + column;
        const int below = first + kCells + 1;
        faces.push_back({first, first + 1, below + 1});
        faces.push_back({first, below + 1, below});
      }
    }
  }
  TriangleMesh mesh() const { return {vertices, faces}; }

  Eigen::Vector3f normal;
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::int32_t, 3>> faces;
};

class SurfaceAngle : public ::testing::TestWithParam<Camera> {};

TEST_P(SurfaceAngle, IsTheAngleBetweenRayAndNormal) {
  const Camera camera = GetParam();
  const Projection projection(camera);
  for (const double turn : {0.0, 20.0, 45.0, 60.0}) {
    const Board board(turn);
    const Rendering rendering = render(board.mesh(), camera);
    const Image<float> cosines = surface_cosines(rendering, board.mesh(), camera);
    int seen = 0;
    for (int row = 0; row < camera.height; ++row) {
      for (int column = 0; column < camera.width; ++column) {
        if (rendering.face(column, row) == Rendering::kNoFace) {
          EXPECT_EQ(cosines(column, row), 0.0f);
          continue;
        }
        Point3 ray(0, 0, 1);
        if (camera.model == CameraModel::projective) {
          ray = projection.to_camera(ImagePoint{double(column), double(row), 1.0});
        }
        const double expected = std::abs(ray.normalized().dot(board.normal.cast<double>()));
        EXPECT_NEAR(cosines(column, row), expected, 2e-3) << turn << ": " << column << ", " << row;
        ++seen;
      }
    }
    EXPECT_GT(seen, 100);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Cameras, SurfaceAngle,
    ::testing::Values(Camera{.width = 40, .height = 30, .fx = 30, .fy = 28, .cx = 18.5, .cy = 16},
                      Camera{.width = 40,
                             .height = 30,
                             .fx = 45,
                             .fy = 45,
                             .cx = 20,
                             .cy = 15,
                             .distortion = {-0.02, 0.01, 0.001, -0.001}},
                      Camera{.model = CameraModel::orthographic,
                             .width = 40,
                             .height = 30,
                             .fx = 0.05,
                             .fy = 0.05,
                             .cx = 20,
                             .cy = 15}));

}  // namespace
}  // namespace knuckle
