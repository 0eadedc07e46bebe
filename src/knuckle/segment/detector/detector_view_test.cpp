// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detector_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "knuckle/core/testing.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

using testing::blank_frame;
using testing::draw_ball;
using testing::hand_frame;
using testing::quarter_vga_camera;

Camera vga_camera() {
  Camera camera = quarter_vga_camera();
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 575.8;
  camera.cx = 318.3;
  camera.cy = 241.7;
  return camera;
}

/// A wide field: 120 degrees.
Camera wide_camera() {
  Camera camera = vga_camera();
  camera.fx = camera.fy = 185.0;
  return camera;
}

std::vector<Camera> cameras() {
  std::vector<Camera> cameras{quarter_vga_camera(), vga_camera(), wide_camera()};
  cameras.push_back(quarter_vga_camera());
  cameras.back().distortion = {-0.25, 0.06, 0.001, -0.001, 0, 0, 0, 0};
  cameras.push_back(quarter_vga_camera());
  cameras.back().fy = -240.0;
  cameras.push_back(quarter_vga_camera());
  cameras.back().model = CameraModel::orthographic;
  cameras.back().fx = cameras.back().fy = 0.5;
  return cameras;
}

TEST(DetectorView, FromCameraAndBackIsTheSamePoint) {
  for (const Camera& camera : cameras()) {
    const DetectorView view({}, camera);
    for (const Point3& point : {Point3(10, -20, 300), Point3(-150, 60, 900), Point3(400, 200, 1800)}) {
      EXPECT_LT((view.to_camera(view.to_view(point)) - point).norm(), 1e-9);
    }
  }
}

/// The middle and the size of what was measured in a small picture.
struct Blob {
  double u = 0.0;
  double v = 0.0;
  double cells = 0.0;
  double nearest = 0.0;  // largest inverse depth [1/m]
};

Blob blob_in(const DetectorInput& input) {
  Blob blob;
  for (int row = 0; row < input.measured_share.height(); ++row) {
    for (int column = 0; column < input.measured_share.width(); ++column) {
      const double share = input.measured_share(column, row);
      blob.cells += share;
      blob.u += share * column;
      blob.v += share * row;
      blob.nearest = std::max(blob.nearest, static_cast<double>(input.inverse_depth(column, row)));
    }
  }
  blob.u /= blob.cells;
  blob.v /= blob.cells;
  return blob;
}

TEST(DetectorView, ABallLiesWhereItsCentreIsWhateverTheCamera) {
  const Point3 centre(60, -50, 700);
  for (const Camera& camera : cameras()) {
    Frame frame = blank_frame(camera);
    draw_ball(frame, centre, 70);
    const DetectorView view({}, camera);
    const Blob blob = blob_in(view.shrink(frame.depth_mm));
    const ViewPlace place = view.to_view(centre);
    EXPECT_NEAR(blob.u, place.u, 0.5) << camera.fx;
    EXPECT_NEAR(blob.v, place.v, 0.5) << camera.fx;
    EXPECT_NEAR(blob.nearest, view.scale() * 1000.0 / 630.0, 0.02 * view.scale()) << camera.fx;
  }
}

TEST(DetectorView, AHandOfOneSizeAtOneDistanceCoversAsManyCellsForAllCameras) {
  const Point3 centre(0, 0, 600);
  std::vector<double> cells;
  for (const Camera& camera : {quarter_vga_camera(), vga_camera()}) {
    Frame frame = blank_frame(camera);
    draw_ball(frame, centre, 80);
    const DetectorView view({}, camera);
    EXPECT_EQ(view.scale(), 1.0);
    cells.push_back(blob_in(view.shrink(frame.depth_mm)).cells);
  }
  EXPECT_NEAR(cells[0], cells[1], 0.02 * cells[0]);
}

TEST(DetectorView, AWiderFieldIsShrunkAndWidthsStay) {
  const DetectorView view({}, wide_camera());
  EXPECT_LT(view.scale(), 0.5);
  EXPECT_GE(view.scale(), DetectorView::kSmallestScale);
  // A millimetre across covers as many cells as its depth, as the network knows it, says.
  const ViewPlace left = view.to_view({-40, 0, 500});
  const ViewPlace right = view.to_view({40, 0, 500});
  EXPECT_NEAR((right.u - left.u) / 0.08, DetectorOptions{}.focal_cells * left.inverse_depth, 1e-9);
}

TEST(DetectorView, TheMirroredFrameGivesTheMirroredPicture) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    Frame frame = hand_frame(seed);
    frame.camera.cx = 150.3;
    const DetectorInput picture = DetectorView({}, frame.camera).shrink(frame.depth_mm);
    const Frame mirror = mirrored(frame);
    const DetectorInput other = DetectorView({}, mirror.camera).shrink(mirror.depth_mm);
    EXPECT_EQ(mirrored(other.inverse_depth), picture.inverse_depth);
    const auto turned = mirrored(other.measured_share);
    EXPECT_TRUE(std::ranges::equal(turned.pixels(), picture.measured_share.pixels(),
                                   [](float a, float b) { return std::abs(a - b) < 1e-6f; }));
  }
}

TEST(DetectorView, OneFlyingPixelPerCellIsNotSeen) {
  Frame frame = blank_frame(vga_camera());
  std::ranges::fill(frame.depth_mm.pixels(), 800.0f);
  for (int row = 3; row < 480; row += 9) {
    for (int column = 3; column < 640; column += 9) frame.depth_mm(column, row) = 300.0f;
  }
  const DetectorInput input = DetectorView({}, frame.camera).shrink(frame.depth_mm);
  for (const float inverse : input.inverse_depth.pixels()) {
    EXPECT_TRUE(inverse == 0.0f || std::abs(inverse - 1.25f) < 1e-6f) << inverse;
  }
}

TEST(DetectorView, WhatIsNotMeasuredIsInfinitelyFar) {
  Frame frame = blank_frame(vga_camera());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float nothing : {0.0f, -5.0f, nan, infinity, -infinity}) {
    std::ranges::fill(frame.depth_mm.pixels(), nothing);
    const DetectorInput input = DetectorView({}, frame.camera).shrink(frame.depth_mm);
    EXPECT_THAT(input.inverse_depth.pixels(), ::testing::Each(0.0f)) << nothing;
    EXPECT_THAT(input.measured_share.pixels(), ::testing::Each(0.0f)) << nothing;
  }
  std::ranges::fill(frame.depth_mm.pixels(), 1e-30f);
  const DetectorInput nearest = DetectorView({}, frame.camera).shrink(frame.depth_mm);
  EXPECT_THAT(nearest.inverse_depth.pixels(), ::testing::Each(::testing::Le(kMostInverseDepth)));
}

TEST(DetectorView, FramesOfOnePixelAndOf48Million) {
  Camera camera = quarter_vga_camera();
  camera.width = camera.height = 1;
  camera.cx = camera.cy = 0.0;
  const DetectorInput one = DetectorView({}, camera).shrink(Image<float>(1, 1, 500.0f));
  EXPECT_FLOAT_EQ(*std::ranges::max_element(one.inverse_depth.pixels()), 2.0f);

  camera = vga_camera();
  camera.width = 8000;
  camera.height = 6000;
  camera.fx = camera.fy = 7000.0;
  camera.cx = 4000.0;
  camera.cy = 3000.0;
  const DetectorInput many = DetectorView({}, camera).shrink(Image<float>(8000, 6000, 500.0f));
  EXPECT_FLOAT_EQ(many.inverse_depth(64, 48), 2.0f);
}

}  // namespace
}  // namespace knuckle
