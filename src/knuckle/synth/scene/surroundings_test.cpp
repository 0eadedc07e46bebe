// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/surroundings.h"

#include "knuckle/core/testing.h"
#include "knuckle/hand/body_rig.h"
#include "knuckle/hand/testing_body.h"
#include "knuckle/synth/people/body_shape.h"
#include "knuckle/synth/pose/motion.h"
#include "knuckle/synth/render/rasteriser.h"
#include "knuckle/synth/scene/clutter.h"
#include "knuckle/synth/scene/room.h"
#include "knuckle/synth/scene/table.h"

namespace knuckle {
namespace {

using Eigen::Vector3f;

/// A box hand in random postures.
class SurroundingsTest : public ::testing::Test {
 protected:
  SurroundingsTest()
      : body_(testing::box_hand_body()),
        person_(shaped_body(body_, std::vector<double>(body_.shapedirs.size(), 0.0))),
        rig_(person_) {}

  SceneActors actors(std::uint64_t number) const {
    const Camera camera{.width = 160, .height = 120, .fx = 112, .fy = 112, .cx = 79.5, .cy = 59.5};
    const PostureOptions options{{}, {.above_share = 0.5}, {}};
    const PlacedPosture placed =
        posture_of_frame(rig_, camera, options, 7, static_cast<std::int64_t>(number));
    const PosedBody posed = posed_body(person_, rig_.pose(placed.posture, placed.camera_from_body));
    const Point3& wrist = posed.landmarks[static_cast<std::size_t>(Landmark::wrist)];
    const Point3& knuckle = posed.landmarks[static_cast<std::size_t>(Landmark::middle_mcp)];
    return {camera,
            posed.landmarks,
            wrist + 2.0 * (wrist - knuckle),
            placed.camera_from_body.linear() * Vector3f::UnitY(),
            posed.vertices,
            posed.vertices.size()};
  }

  Body body_;
  ShapedBody person_;
  BodyRig rig_;
};

/// Whether a point lies inside closed surfaces: how often a ray leaves them less how often it enters.
bool is_inside(const SceneMesh& mesh, const Vector3f& point) {
  const Eigen::Vector3d direction = Eigen::Vector3d(0.31, 0.77, -0.55).normalized();
  int windings = 0;
  for (const auto& [ia, ib, ic] : mesh.faces) {
    const Eigen::Vector3d a = (mesh.vertices[ia] - point).cast<double>();
    const Eigen::Vector3d ab = (mesh.vertices[ib] - point).cast<double>() - a;
    const Eigen::Vector3d ac = (mesh.vertices[ic] - point).cast<double>() - a;
    const Eigen::Vector3d p = direction.cross(ac);
    const double determinant = ab.dot(p);
    if (std::abs(determinant) < 1e-12) continue;
    const double s = -a.dot(p) / determinant;
    const Eigen::Vector3d q = (-a).cross(ab);
    const double t = direction.dot(q) / determinant;
    if (s < 0.0 || t < 0.0 || s + t > 1.0 || ac.dot(q) / determinant <= 0.0) continue;
    windings += determinant < 0.0 ? 1 : -1;
  }
  return windings > 0;
}

TEST_F(SurroundingsTest, SkinIsNeverInsideThings) {
  const SceneOptions options{.table_share = 1, .most_things = 10, .cloth_share = 0, .before_share = 1};
  std::size_t faces = 0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    const SceneActors around = actors(i);
    const Surroundings scene = sampled_surroundings(around, options, i);
    for (const SceneMesh* part : {&scene.things, &scene.before}) {
      faces += part->faces.size();
      for (const Vector3f& point : around.points) EXPECT_FALSE(is_inside(*part, point)) << i;
    }
  }
  EXPECT_GT(faces, 1000u) << "there were things";
}

TEST_F(SurroundingsTest, AHandIsAboveItsTableOrTouchesIt) {
  int resting = 0;
  int tables = 0;
  for (std::uint64_t i = 0; i < 100; ++i) {
    const SceneActors around = actors(i);
    Random random(5, i);
    const auto table = sampled_table(around, {.table_share = 1, .rest_share = 0.5}, random);
    if (!table) continue;
    ++tables;
    const Eigen::Isometry3f table_from_camera = table->camera_from_table.inverse();
    EXPECT_GT(table_from_camera.translation().z(), 50.0f) << "the camera looks down on it";
    float lowest = 1e9f;
    for (const Vector3f& point : around.points) {
      constexpr float kNear = 250.0f;  // the rest of the arm may hang below its edge
      if ((point - around.palm().cast<float>()).norm() > kNear) continue;
      const Vector3f place = table_from_camera * point;
      if (table->top.contains(place.head<2>())) lowest = std::min(lowest, place.z());
    }
    if (lowest > 1e8f) continue;
    EXPECT_GT(lowest, -4.0f) << "skin yields, but not more";
    resting += lowest < 0.5f ? 1 : 0;
  }
  EXPECT_GT(tables, 20);
  EXPECT_GT(resting, tables / 5);
}

TEST_F(SurroundingsTest, ThingsStandOnTheTable) {
  for (std::uint64_t i = 0; i < 40; ++i) {
    const SceneActors around = actors(i);
    Random random(6, i);
    const auto table = sampled_table(around, {}, random);
    if (!table) continue;
    for (const PlacedShape& thing : things_on_table(around, *table, {.most_things = 8}, random)) {
      const Vector3f foot = table->camera_from_table.inverse() * thing.camera_from_shape.translation();
      EXPECT_NEAR(foot.z(), 0.0f, 0.01f);
      EXPECT_TRUE(table->top.contains(foot.head<2>()));
      EXPECT_GT(thing.camera_from_shape.linear().col(2).dot(table->up()), 0.999f);
    }
  }
}

/// Radius of the upright cylinder about its axis that a thing fills.
float reach_of(const PlacedShape& thing) {
  float reach = 0.0f;
  for (const Vector3f& vertex : thing.shape.mesh.vertices) reach = std::max(reach, vertex.head<2>().norm());
  return reach;
}

TEST_F(SurroundingsTest, ThingsOnATableStandBesideOneAnother) {
  std::size_t pairs = 0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    const SceneActors around = actors(i);
    Random random(6, i);
    const auto table = sampled_table(around, {}, random);
    if (!table) continue;
    const auto things = things_on_table(around, *table, {.most_things = 8, .cloth_share = 0}, random);
    for (std::size_t a = 0; a < things.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b, ++pairs) {
        const Vector3f between =
            things[a].camera_from_shape.translation() - things[b].camera_from_shape.translation();
        // Corners may come nearer: a circle about a box is wider than the box.
        EXPECT_GT(between.norm(), 0.79f * (reach_of(things[a]) + reach_of(things[b]))) << i;
      }
    }
  }
  EXPECT_GT(pairs, 50u);
}

TEST_F(SurroundingsTest, FurnitureStandsInItsRoomBesideTheTable) {
  std::size_t pieces = 0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    const SceneActors around = actors(i);
    Random random(9, i);
    const auto table = sampled_table(around, {}, random);
    if (!table) continue;
    const Room room = sampled_room(around, table, random);
    const Eigen::Isometry3f room_from_camera = room.camera_from_room.inverse();
    const Eigen::Isometry3f table_from_camera = table->camera_from_table.inverse();
    for (const PlacedShape& piece : furniture(around, room, table, {.most_things = 5}, random)) {
      ++pieces;
      const Vector3f foot = room_from_camera * piece.camera_from_shape.translation();
      EXPECT_NEAR(foot.z(), 0.0f, 0.1f) << "on the floor";
      const Vector3f above_floor = foot + Vector3f(0, 0, 1);
      EXPECT_TRUE(room.inside.contains(above_floor)) << i;
      for (const Vector3f& vertex : piece.shape.mesh.vertices) {
        const Vector3f place = table_from_camera * (piece.camera_from_shape * vertex);
        EXPECT_FALSE(table->top.contains(place.head<2>())) << i;
      }
    }
  }
  EXPECT_GT(pieces, 30u);
}

TEST_F(SurroundingsTest, FurnitureIsNeitherInSkinNorInTheCamera) {
  std::size_t pieces = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const SceneActors around = actors(i);
    Random random(9, i);
    const Room room = sampled_room(around, std::nullopt, random);
    for (const PlacedShape& piece : furniture(around, room, std::nullopt, {.most_things = 5}, random)) {
      ++pieces;
      SceneMesh mesh;
      mesh.append(piece.shape.mesh, piece.camera_from_shape);
      EXPECT_FALSE(is_inside(mesh, Vector3f::Zero())) << i;
      for (const Vector3f& point : around.points) EXPECT_FALSE(is_inside(mesh, point)) << i;
    }
  }
  EXPECT_GT(pieces, 100u);
}

TEST_F(SurroundingsTest, ARoomSurroundsAllAndIsSeenFromInside) {
  for (std::uint64_t i = 0; i < 20; ++i) {
    const SceneActors around = actors(i);
    Random random(8, i);
    const Room room = sampled_room(around, std::nullopt, random);
    const Eigen::Isometry3f room_from_camera = room.camera_from_room.inverse();
    for (const Vector3f& point : around.points) EXPECT_TRUE(room.inside.contains(room_from_camera * point));
    const SceneMesh mesh = mesh_of(room);
    const Rendering seen = render(mesh.triangles(), around.camera, {.culling = FaceCulling::back_faces});
    EXPECT_EQ(std::ranges::count(seen.face.pixels(), Rendering::kNoFace), 0) << "walls all around";
  }
}

TEST_F(SurroundingsTest, WhatIsSwitchedOffChangesNothingElse) {
  const SceneOptions all{.room_share = 1, .table_share = 1, .most_things = 6, .before_share = 1};
  SceneOptions less = all;
  less.before_share = 0;
  for (std::uint64_t i = 0; i < 10; ++i) {
    const SceneActors around = actors(i);
    const Surroundings a = sampled_surroundings(around, all, i);
    const Surroundings b = sampled_surroundings(around, less, i);
    EXPECT_EQ(a.things.vertices, b.things.vertices);
    EXPECT_EQ(a.room.vertices, b.room.vertices);
    EXPECT_TRUE(b.before.faces.empty());
  }
}

TEST(RestingUp, ASlabComesToLieOnItsSide) {
  std::vector<Vector3f> slab;
  for (int i = 0; i < 8; ++i)
    slab.emplace_back((i & 1) != 0 ? 80 : -80, (i & 2) != 0 ? 50 : -50, (i & 4) != 0 ? 10 : -10);
  const Vector3f tilted = Vector3f(0.15f, -0.1f, 1.0f).normalized();
  const auto height = [&](const Vector3f& up) {
    float lowest = 1e9f;
    for (const Vector3f& point : slab) lowest = std::min(lowest, up.dot(point));
    return -lowest;
  };
  for (std::uint64_t i = 0; i < 20; ++i) {
    Random random(1, i);
    const Vector3f up = resting_up(slab, Vector3f::Zero(), tilted, random);
    EXPECT_NEAR(up.norm(), 1.0f, 1e-5f);
    EXPECT_LE(height(up), height(tilted));
  }
}

}  // namespace
}  // namespace knuckle
