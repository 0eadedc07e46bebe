// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/camera.h"

#include "knuckle/core/frame.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

Camera example_camera() {
  Camera camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 224.0;
  camera.cx = 160.0;
  camera.cy = 120.0;
  return camera;
}

TEST(CameraTest, AFileThatCountsFromTheCornerHasItsPrincipalPointHalfAPixelLower) {
  const Camera corner = example_camera();
  const Camera centre = with_pixel_origin(corner, PixelOrigin::corner, PixelOrigin::centre);
  EXPECT_EQ(centre.cx, 159.5);
  EXPECT_EQ(centre.cy, 119.5);
  EXPECT_EQ(with_pixel_origin(centre, PixelOrigin::centre, PixelOrigin::corner), corner);
  EXPECT_EQ(with_pixel_origin(corner, PixelOrigin::corner, PixelOrigin::corner), corner);
}

TEST(CameraTest, ImpossibleValuesAreNamed) {
  const auto fault = [](auto change) {
    Camera camera = example_camera();
    change(camera);
    return error_of([&] { check(camera); });
  };
  EXPECT_NO_THROW(check(example_camera()));
  EXPECT_THAT(fault([](Camera& c) { c.width = 0; }), HasSubstr("width is 0"));
  EXPECT_THAT(fault([](Camera& c) { c.height = -1; }), HasSubstr("height is -1"));
  EXPECT_THAT(fault([](Camera& c) { c.width = 16385; }), HasSubstr("expected at most 16384 a side"));
  EXPECT_THAT(fault([](Camera& c) { c.height = 16385; }), HasSubstr("expected at most 16384 a side"));
  Camera largest = example_camera();
  largest.width = 16384;
  largest.height = 2048;
  EXPECT_NO_THROW(check(largest));
  EXPECT_THAT(fault([](Camera& c) { c.width = c.height = 16384; }),
              HasSubstr("camera: has 16384 x 16384 pixels, expected at most 48000000 in all"));
  EXPECT_THAT(fault([](Camera& c) { c.fx = 0.0; }), HasSubstr("fx is 0"));
  EXPECT_THAT(fault([](Camera& c) { c.fy = kNaN; }), HasSubstr("fy is nan"));
  EXPECT_THAT(fault([](Camera& c) { c.fy = 0.0; }), HasSubstr("fy is 0"));
  EXPECT_THAT(fault([](Camera& c) { c.fx = INFINITY; }), HasSubstr("fx is inf"));
  EXPECT_THAT(fault([](Camera& c) { c.fx = 1e-7; }),
              HasSubstr("fx is 1e-07, expected a size from 1e-06 to 1e+09"));
  EXPECT_THAT(fault([](Camera& c) { c.fy = -1e10; }), HasSubstr("fy is -10000000000"));
  Camera extreme = example_camera();
  extreme.fx = 1e-6;
  extreme.fy = -1e9;
  EXPECT_NO_THROW(check(extreme));
  EXPECT_THAT(fault([](Camera& c) { c.cx = kNaN; }), HasSubstr("cx is nan"));
  EXPECT_THAT(fault([](Camera& c) { c.cy = -INFINITY; }), HasSubstr("cy is -inf"));
  EXPECT_THAT(fault([](Camera& c) { c.distortion[2] = kNaN; }), HasSubstr("distortion"));
  EXPECT_THAT(fault([](Camera& c) {
                c.model = CameraModel::orthographic;
                c.distortion[0] = 0.1;
              }),
              HasSubstr("orthographic"));
}

TEST(CameraTest, AnOriginMovesBothCoordinatesByHalfAPixel) {
  Camera camera = example_camera();
  camera.cx = 11.25;
  camera.cy = 70.75;
  const Camera corner = with_pixel_origin(camera, PixelOrigin::centre, PixelOrigin::corner);
  EXPECT_EQ(corner.cx, 11.75);
  EXPECT_EQ(corner.cy, 71.25);
}

TEST(CameraTest, AMirrorTurnsTheSignOfTheSecondTangentialCoefficientAlone) {
  Camera camera = example_camera();
  camera.cx = 100.25;
  camera.distortion = {0.1, 0.2, 0.01, 0.02, 0.3, 0.4, 0.5, 0.6};
  const Camera mirror = mirrored(camera);
  EXPECT_EQ(mirror.distortion, (std::array{0.1, 0.2, 0.01, -0.02, 0.3, 0.4, 0.5, 0.6}));
  EXPECT_EQ(mirror.cx, 218.75);
  EXPECT_EQ(mirror.cy, 120.0);
  EXPECT_EQ(mirror.fx, 224.0);
}

TEST(FrameTest, AMirrorTurnsEachImageTruthAndSideAndKeepsTheRest) {
  Frame frame;
  frame.name = "000012";
  frame.camera = {.width = 3, .height = 2, .fx = 5.0, .fy = 6.0, .cx = 0.5, .cy = 1.5};
  frame.depth_mm = Image<float>(3, 2);
  frame.infrared = Image<std::uint16_t>(3, 2);
  frame.mask = Image<std::uint8_t>(3, 2);
  for (int i = 0; i < 6; ++i) {
    frame.depth_mm.data()[i] = 500.0f + static_cast<float>(i);
    frame.infrared.data()[i] = static_cast<std::uint16_t>(40 + i);
  }
  frame.mask(2, 1) = 1;
  frame.truth = HandPose::missing(convention_from_name("nyu14"));
  frame.truth->joints[4] = {2.0, 1.0, 505.0};
  frame.side = HandSide::left;
  frame.time_s = 12.5;
  frame.sequence = 3;
  const Frame mirror = mirrored(frame);
  EXPECT_EQ(mirror.name, "000012");
  EXPECT_EQ(mirror.camera.cx, 1.5);
  EXPECT_THAT(mirror.depth_mm.pixels(), ::testing::ElementsAre(502, 501, 500, 505, 504, 503));
  EXPECT_THAT(mirror.infrared.pixels(), ::testing::ElementsAre(42, 41, 40, 45, 44, 43));
  EXPECT_THAT(mirror.mask.pixels(), ::testing::ElementsAre(0, 0, 0, 1, 0, 0));
  EXPECT_EQ(mirror.truth->joints[4].u, 0.0);
  EXPECT_EQ(mirror.truth->joints[4].v, 1.0);
  EXPECT_EQ(mirror.side, HandSide::right);
  EXPECT_EQ(mirrored(mirror).side, HandSide::left);
  EXPECT_EQ(mirror.time_s, 12.5);
  EXPECT_EQ(mirror.sequence, 3);
  frame.side.reset();
  EXPECT_FALSE(mirrored(frame).side);
}

TEST(CameraTest, AMirroredFrameMirrorsBackToItself) {
  Frame frame;
  frame.camera = example_camera();
  frame.camera.distortion = {0.1, 0.2, 0.01, 0.02, 0, 0, 0, 0};
  frame.depth_mm = Image<float>(320, 240);
  frame.depth_mm(3, 5) = 400.0f;
  frame.truth = HandPose::missing(superset_convention());
  frame.truth->joints[0] = {3.0, 5.0, 400.0};
  frame.labels = Image<std::uint8_t>(320, 240);
  frame.labels(3, 5) = static_cast<std::uint8_t>(PixelLabel::other_hand);
  frame.hands.push_back({HandSide::left, *frame.truth, {Occluder::object}, 0.5});
  const Frame mirror = mirrored(frame);
  EXPECT_EQ(mirror.labels(316, 5), frame.labels(3, 5));
  EXPECT_EQ(mirror.hands[0].side, HandSide::right);
  EXPECT_EQ(mirror.hands[0].pose.joints[0].u, 316.0);
  EXPECT_EQ(mirror.hands[0].occluders, frame.hands[0].occluders);
  EXPECT_EQ(mirror.hands[0].visible_share, 0.5);
  EXPECT_EQ(mirrored(mirror).hands[0].side, HandSide::left);
  EXPECT_EQ(mirror.depth_mm(316, 5), 400.0f);
  EXPECT_EQ(mirror.truth->joints[0].u, 316.0);
  EXPECT_EQ(mirrored(mirror).camera, frame.camera);
  EXPECT_EQ(mirrored(mirror).depth_mm, frame.depth_mm);
}

}  // namespace
}  // namespace knuckle
