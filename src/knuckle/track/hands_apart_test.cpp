// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/hands_apart.h"

#include <array>
#include <limits>

#include <gtest/gtest.h>

#include "knuckle/camera/projection.h"

namespace knuckle {
namespace {

Camera small_camera() {
  Camera camera;
  camera.width = 80;
  camera.height = 60;
  camera.fx = 70.0;
  camera.fy = 90.0;
  camera.cx = 33.0;
  camera.cy = 31.0;
  return camera;
}

HandSkin bar(const Point3& from, const Point3& to, double radius) {
  return {{from, to, radius, 0, 0}};
}

/// A wall whose distance differs from pixel to pixel.
Frame uneven_wall(double depth_mm) {
  Frame frame;
  frame.camera = small_camera();
  frame.depth_mm = Image<float>(frame.camera.width, frame.camera.height);
  for (int row = 0; row < frame.camera.height; ++row) {
    for (int column = 0; column < frame.camera.width; ++column) {
      frame.depth_mm(column, row) = static_cast<float>(depth_mm + 7 * ((3 * column + 5 * row) % 11));
    }
  }
  return frame;
}

TEST(HandsApart, DistanceToSkinIsThatToTheNearestOfItsCapsules) {
  HandSkin skin = bar({0, 0, 500}, {100, 0, 500}, 10.0);
  EXPECT_NEAR(distance_to_skin_mm({50, 30, 500}, skin), 20.0, 1e-12);
  EXPECT_NEAR(distance_to_skin_mm({130, 0, 540}, skin), 40.0, 1e-12);
  EXPECT_NEAR(distance_to_skin_mm({50, 4, 500}, skin), -6.0, 1e-12);
  skin.push_back({{50, 60, 500}, {50, 60, 500}, 5.0, 1, 0});  // a ball
  EXPECT_NEAR(distance_to_skin_mm({50, 40, 500}, skin), 15.0, 1e-12);
  EXPECT_EQ(distance_to_skin_mm({0, 0, 500}, {}), std::numeric_limits<double>::infinity());
}

TEST(HandsApart, TakesExactlyWhatIsNearTheOthersAndNotNearerToOneself) {
  const Frame frame = uneven_wall(480.0);
  const HandSkin other = bar({-60, -40, 500}, {90, 50, 520}, 14.0);
  const HandSkin own = bar({-70, 50, 510}, {80, -30, 500}, 18.0);
  const Projection projection(frame.camera);
  for (const HandSkin& mine : {own, HandSkin()}) {
    const Frame alone = without_hands(frame, std::array{other}, mine, 12.0);
    int taken = 0;
    for (int row = 0; row < frame.camera.height; ++row) {
      for (int column = 0; column < frame.camera.width; ++column) {
        const float depth = frame.depth_mm(column, row);
        const Point3 point = projection.to_camera({1.0 * column, 1.0 * row, depth});
        const double distance = distance_to_skin_mm(point, other);
        const bool is_others = distance < 12.0 && distance < distance_to_skin_mm(point, mine);
        EXPECT_EQ(alone.depth_mm(column, row), is_others ? 0.0f : depth) << column << ' ' << row;
        taken += is_others ? 1 : 0;
      }
    }
    EXPECT_GT(taken, 100);
  }
}

TEST(HandsApart, TakesAllOfTheOthers) {
  const Frame frame = uneven_wall(500.0);
  const std::array others = {bar({-100, 0, 530}, {-60, 0, 530}, 40.0),
                             bar({60, 0, 530}, {100, 0, 530}, 40.0)};
  const Frame both = without_hands(frame, others, {}, 10.0);
  const Frame first = without_hands(frame, std::array{others[0]}, {}, 10.0);
  const Frame then = without_hands(first, std::array{others[1]}, {}, 10.0);
  EXPECT_NE(first.depth_mm, frame.depth_mm);
  EXPECT_NE(then.depth_mm, first.depth_mm);
  EXPECT_EQ(both.depth_mm, then.depth_mm);
}

TEST(HandsApart, HandsOutOfViewOrThroughTheCameraDoNoHarm) {
  const Frame frame = uneven_wall(500.0);
  for (const HandSkin& other :
       {bar({5000, 0, 500}, {5100, 0, 500}, 10.0), bar({0, -9000, 500}, {0, -8000, 500}, 10.0),
        bar({0, 0, -300}, {0, 0, -200}, 10.0), HandSkin()}) {
    EXPECT_EQ(without_hands(frame, std::array{other}, {}, 15.0).depth_mm, frame.depth_mm);
  }
  // From behind the camera to the wall: what it meets there is still taken.
  const Frame cut = without_hands(frame, std::array{bar({0, 0, -300}, {0, 0, 560}, 10.0)}, {}, 15.0);
  EXPECT_NE(cut.depth_mm, frame.depth_mm);
}

}  // namespace
}  // namespace knuckle
