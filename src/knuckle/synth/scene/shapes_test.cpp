// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/shapes.h"

#include <map>

#include "knuckle/core/testing.h"
#include "knuckle/synth/scene/things.h"

namespace knuckle {
namespace {

using Eigen::Vector3f;

/// The volume inside a closed surface whose faces are counter-clockwise from outside.
double volume_of(const SceneMesh& mesh) {
  double volume = 0.0;
  for (const auto& [a, b, c] : mesh.faces)
    volume += mesh.vertices[a].cross(mesh.vertices[b]).dot(mesh.vertices[c]) / 6.0;
  return volume;
}

TEST(Shapes, VolumesArePositiveAndRight) {
  EXPECT_NEAR(volume_of(box_shape({20, 30, 40}).mesh), 20.0 * 30 * 40, 1.0);
  const double kPi = 3.14159265;
  const double cylinder = kPi * 25 * 25 * 100;
  EXPECT_NEAR(volume_of(cone_shape(25, 25, 100, 64).mesh), cylinder, 0.01 * cylinder);
  const double ball = 4.0 / 3.0 * kPi * 30 * 30 * 30;
  EXPECT_NEAR(volume_of(ball_shape(30).mesh), ball, 0.08 * ball);
  const std::array<Vector3f, 3> line = {Vector3f(0, 0, 0), Vector3f(50, 0, 0), Vector3f(100, 0, 0)};
  EXPECT_NEAR(volume_of(tube(line, 10, 48)), kPi * 100 * 100, 0.01 * kPi * 100 * 100);
}

TEST(Shapes, SolidsKnowInsideFromOutside) {
  const Shape box = box_shape({20, 30, 40});
  EXPECT_FLOAT_EQ(distance_mm(box.solids, {0, 0, 50}), 10.0f);
  EXPECT_FLOAT_EQ(distance_mm(box.solids, {0, 0, 20}), -10.0f);
  const Shape cone = cone_shape(20, 10, 50);
  EXPECT_LT(distance_mm(cone.solids, {14.9f, 0, 25}), 0.0f);
  EXPECT_GT(distance_mm(cone.solids, {15.1f, 0, 25}), 0.0f);
  EXPECT_FLOAT_EQ(distance_mm(ball_shape(30).solids, {0, 0, 30}), -30.0f);
}

class EveryThing : public ::testing::TestWithParam<std::string_view> {};

/// So a hand that keeps clear of the solids keeps clear of what is drawn.
TEST_P(EveryThing, LiesWithinItsSolidsAndStandsOnTheGround) {
  for (std::uint64_t i = 0; i < 30; ++i) {
    Random random(1, i);
    const Shape shape = sampled_thing(GetParam(), random);
    float lowest = 1e9f;
    for (const Vector3f& vertex : shape.mesh.vertices) {
      ASSERT_TRUE(vertex.allFinite());
      EXPECT_LE(distance_mm(shape.solids, vertex), 0.51f) << GetParam();
      lowest = std::min(lowest, vertex.z());
    }
    EXPECT_NEAR(lowest, 0.0f, 0.6f) << GetParam();
    EXPECT_EQ(shape.mesh.labels.size(), shape.mesh.faces.size());
  }
}

/// Each edge belongs to as many faces one way round as the other.
TEST_P(EveryThing, IsClosed) {
  Random random(2, 0);
  const Shape shape = sampled_thing(GetParam(), random);
  EXPECT_GT(volume_of(shape.mesh), 0.0);
  const auto key = [](const Vector3f& point) {
    return std::array{std::lround(100 * point.x()), std::lround(100 * point.y()),
                      std::lround(100 * point.z())};
  };
  using Key = std::array<long, 3>;
  std::map<std::pair<Key, Key>, int> edges;
  for (const auto& face : shape.mesh.faces) {
    for (int i = 0; i < 3; ++i) {
      const Key from = key(shape.mesh.vertices[face[i]]);
      const Key to = key(shape.mesh.vertices[face[(i + 1) % 3]]);
      if (from == to) continue;
      ++edges[{from, to}];
      --edges[{to, from}];
    }
  }
  for (const auto& [edge, count] : edges) EXPECT_EQ(count, 0) << GetParam();
}

INSTANTIATE_TEST_SUITE_P(Kinds, EveryThing, ::testing::ValuesIn(thing_kinds().begin(), thing_kinds().end()),
                         [](const auto& parameter) { return std::string(parameter.param); });

/// The longest extent of a thing [mm], at least and at most: loosely, what such things have in a household.
struct Extent {
  std::string_view kind;
  float least;
  float most;
};

TEST(Things, AreAsLargeAsThoseOfEverydayAre) {
  for (const auto& [kind, least, most] :
       {Extent{"box", 40, 260}, Extent{"block", 20, 110}, Extent{"book", 140, 320}, Extent{"phone", 120, 180},
        Extent{"keyboard", 270, 460}, Extent{"can", 45, 190}, Extent{"mug", 80, 150}, Extent{"pen", 100, 200},
        Extent{"ball", 25, 160}, Extent{"bottle", 120, 340}}) {
    float largest = 0.0f;
    float smallest = 1e9f;
    for (std::uint64_t i = 0; i < 100; ++i) {
      Random random(3, i);
      Eigen::AlignedBox3f extent;
      for (const Vector3f& vertex : sampled_thing(kind, random).mesh.vertices) extent.extend(vertex);
      largest = std::max(largest, extent.sizes().maxCoeff());
      smallest = std::min(smallest, extent.sizes().maxCoeff());
    }
    EXPECT_LT(largest, most) << kind;
    EXPECT_GT(smallest, least) << kind;
    EXPECT_GT(largest, 1.2f * smallest) << kind << ": they differ";
  }
}

TEST(Things, AnUnknownKindIsNamed) {
  Random random(1, 1);
  EXPECT_THAT(testing::error_of([&] { sampled_thing("teapot", random); }), ::testing::HasSubstr("teapot"));
}

TEST(Things, AClothLiesWithinItsSolid) {
  for (std::uint64_t i = 0; i < 30; ++i) {
    Random random(3, i);
    const Shape cloth = sampled_cloth(random);
    for (const Vector3f& vertex : cloth.mesh.vertices) {
      EXPECT_LE(distance_mm(cloth.solids, vertex), 0.01f);
      EXPECT_GT(vertex.z(), 0.0f);
    }
  }
}

TEST(Shapes, StandingPutsTheFootAndTheAxis) {
  const Vector3f up = Vector3f(1, 2, -2).normalized();
  const Eigen::Isometry3f place = standing({5, 6, 7}, up, 1.2);
  EXPECT_LT((place * Vector3f(0, 0, 3) - (Vector3f(5, 6, 7) + 3 * up)).norm(), 1e-4f);
  EXPECT_NEAR(place.linear().determinant(), 1.0f, 1e-5f);
  EXPECT_LT((standing({0, 0, 0}, Vector3f::UnitZ(), 0.0).linear() - Eigen::Matrix3f::Identity()).norm(),
            1e-6f);
}

}  // namespace
}  // namespace knuckle
