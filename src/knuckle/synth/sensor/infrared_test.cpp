// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/infrared.h"

#include <cmath>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

const Camera kRowCamera{.width = 5, .height = 1, .fx = 100, .fy = 100, .cx = 2, .cy = 0};
const InfraredOptions kLight{.infrared = 1000.0};

std::uint16_t amplitude(float depth_mm, float cosine, int column = 2) {
  return infrared_image(Image<float>(5, 1, depth_mm), Image<float>(5, 1, cosine), kRowCamera, kLight, 1)(
      column, 0);
}

TEST(Infrared, FallsWithTheSquareOfTheDistance) {
  EXPECT_EQ(amplitude(1000.0f, 1.0f), 1000);
  EXPECT_EQ(amplitude(500.0f, 1.0f), 4000);
  EXPECT_EQ(amplitude(2000.0f, 1.0f), 250);
}

TEST(Infrared, FallsWithTheCosineOfTheAngle) {
  EXPECT_EQ(amplitude(1000.0f, 0.5f), 500);
  EXPECT_EQ(amplitude(1000.0f, 0.0f), 0);
}

TEST(Infrared, MeasuresDistanceAlongTheLineOfSight) {
  const double squared_length = 1.0 + 0.02 * 0.02;
  EXPECT_EQ(amplitude(100.0f, 1.0f, 4), 65535);  // saturated
  EXPECT_NEAR(amplitude(250.0f, 1.0f, 4), 16000.0 / squared_length, 1.0);
  Camera wide = kRowCamera;
  wide.fx = 2.0;
  const auto image = infrared_image(Image<float>(5, 1, 1000.0f), {}, wide, kLight, 1);
  EXPECT_EQ(image(2, 0), 1000);
  EXPECT_EQ(image(4, 0), 500);  // the ray is sqrt 2 long
}

TEST(Infrared, NoiseHasItsDeviationAndLeavesTheUnseenDark) {
  Image<float> depths(200, 100, 1000.0f);
  for (int i = 0; i < 10000; ++i) depths.data()[i] = 0.0f;
  const Camera camera{.width = 200, .height = 100, .fx = 1e6, .fy = 1e6};
  const auto image = infrared_image(depths, {}, camera, {.infrared = 1000.0, .infrared_sigma = 30.0}, 1);
  double squares = 0.0;
  for (int i = 0; i < 10000; ++i) {
    EXPECT_EQ(image.data()[i], 0);
    squares += std::pow(image.data()[10000 + i] - 1000.0, 2) / 10000;
  }
  EXPECT_NEAR(std::sqrt(squares), 30.0, 1.0);
}

}  // namespace
}  // namespace knuckle
