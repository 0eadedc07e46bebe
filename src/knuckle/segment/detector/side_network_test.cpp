// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/side_network.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "knuckle/core/likelihood.h"
#include "knuckle/segment/detector/detector_testing.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

using testing::blank_frame;
using testing::constant_detector;
using testing::quarter_vga_camera;
using testing::small_detector;

TEST(SideNetworkTest, SaysOfEachHandWhatTheNetworkSaysAtItsPlace) {
  const DetectorWeights weights = random_detector(small_detector(), 5);
  Random random(6);
  Frame frame = blank_frame(quarter_vga_camera());
  testing::draw_hand(frame, Point3(20, 10, 450), random);
  const DetectorView view(small_detector(), frame.camera);
  const HandDetector detector(weights);
  const DetectorInput input = view.shrink(frame.depth_mm);
  const DetectorMaps maps = detector.maps_of(input);
  const DetectorMaps mirror =
      detector.maps_of({mirrored(input.inverse_depth), mirrored(input.measured_share)});

  std::vector<Point3> centres;
  std::vector<double> expected;
  for (int row = 0; row < maps.height; ++row) {
    for (int column = 0; column < maps.width; ++column) {
      // 0.3 cells beside the middle of the cell
      const auto in_picture = [](double cell) { return (cell + 0.3) * kMapStride + 0.5 * (kMapStride - 1); };
      centres.push_back(view.to_camera({in_picture(column), in_picture(row), 2.0}));
      const double odds = maps.cell(column, row)[kSideMap];
      expected.push_back(logistic(0.5 * (odds - mirror.cell(maps.width - 1 - column, row)[kSideMap])));
    }
  }
  EXPECT_EQ(SideNetwork(weights).right_hands(frame, centres), expected);
  EXPECT_GT(*std::ranges::max_element(expected), *std::ranges::min_element(expected) + 1e-4);
}

TEST(SideNetworkTest, HandsOutsideOfWhatItSeesHaveTheNearestPlace) {
  const DetectorWeights weights = random_detector(small_detector(), 5);
  Frame frame = blank_frame(quarter_vga_camera());
  testing::draw_ball(frame, Point3(0, 0, 500), 80);
  const SideNetwork network(weights);
  const std::vector<Point3> outside = {{-1e5, -1e5, 300}, {1e5, 1e5, 300}};
  const std::vector<Point3> corners = {{-1e3, -1e3, 300}, {1e3, 1e3, 300}};
  EXPECT_EQ(network.right_hands(frame, outside), network.right_hands(frame, corners));
}

TEST(SideNetworkTest, OfWhatLiesNowhereBeforeTheCameraNothingIsKnown) {
  Frame frame = blank_frame(quarter_vga_camera());
  testing::draw_ball(frame, Point3(0, 0, 500), 80);
  const SideNetwork network(random_detector(small_detector(), 5));
  const double nan = std::nan("");
  const std::vector<Point3> centres = {{0, 0, 0}, {0, 0, -500}, {nan, 0, 500}, {0, 0, nan}, {30, 0, 500}};
  const std::vector<double> right = network.right_hands(frame, centres);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(right[i], 0.5);
  EXPECT_NE(right[4], 0.5);
}

TEST(SideNetworkTest, InAMirrorARightHandIsALeftOne) {
  Random random(6);
  Frame frame = blank_frame(quarter_vga_camera());
  testing::draw_hand(frame, Point3(20, 10, 450), random);
  const SideNetwork network(random_detector(small_detector(), 5));
  const std::vector<Point3> centres = {{20, 10, 450}, {-60, 80, 450}, {90, -20, 450}};
  std::vector<Point3> in_mirror = centres;
  for (Point3& centre : in_mirror) centre.x() = -centre.x();
  const std::vector<double> right = network.right_hands(frame, centres);
  const std::vector<double> left = network.right_hands(mirrored(frame), in_mirror);
  for (std::size_t i = 0; i < centres.size(); ++i) {
    EXPECT_NEAR(right[i], 1.0 - left[i], 1e-6);
    EXPECT_GT(std::abs(right[i] - 0.5), 1e-5) << "else this shows nothing";
  }
}

TEST(SideNetworkTest, WhatItSaysOfBothPicturesAlikeItDoesNotKnow) {
  Frame frame = blank_frame(quarter_vga_camera());
  const DetectedHand left{.centre = Point3(0, 0, 500),
                          .extent_mm = 80,
                          .score = 0.5,
                          .side = HandSide::left,
                          .side_confidence = 0.8};
  const SideNetwork network(constant_detector(small_detector(), frame.camera, left));
  const std::vector<Point3> centres = {{0, 0, 500}, {50, 20, 400}};
  for (const double right : network.right_hands(frame, centres)) EXPECT_DOUBLE_EQ(right, 0.5);
  EXPECT_TRUE(network.right_hands(frame, {}).empty());
}

}  // namespace
}  // namespace knuckle
