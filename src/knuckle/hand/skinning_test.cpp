// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/skinning.h"

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/testing_body.h"

namespace knuckle {
namespace {

using ::knuckle::testing::box_hand_body;
using ::knuckle::testing::error_of;
using ::testing::HasSubstr;

constexpr float kTolerance = 1e-3f;  // mm: single precision at lengths of some 100 mm

BodyPose rest_pose(const Body& body) {
  return {std::vector<Eigen::Quaternionf>(body.names.size(), Eigen::Quaternionf::Identity()),
          Eigen::Isometry3f::Identity()};
}

Eigen::Quaternionf random_rotation(Random& random) {
  Eigen::Vector4f values;
  for (float& value : values) value = static_cast<float>(random.normal());
  return Eigen::Quaternionf(values.normalized());
}

BodyPose random_pose(const Body& body, std::uint64_t seed) {
  Random random(seed);
  BodyPose pose = rest_pose(body);
  for (Eigen::Quaternionf& rotation : pose.rotations) rotation = random_rotation(random);
  pose.camera_from_body = Eigen::Translation3f(10, -20, 500) * random_rotation(random);
  return pose;
}

ShapedBody plain_person(const Body& body) {
  return shaped_body(body, std::vector<double>(body.shapedirs.size(), 0.0));
}

/// Where bone `bone` takes a point at rest, by walking up the chain in double precision.
Eigen::Vector3d moved_by_chain(const ShapedBody& person, const BodyPose& pose, int bone,
                               Eigen::Vector3d point) {
  for (int i = bone; i >= 0; i = person.body->parents[i]) {
    const Eigen::Vector3d head = person.joints[i].cast<double>();
    point = pose.rotations[i].cast<double>().toRotationMatrix() * (point - head) + head;
  }
  return pose.camera_from_body.cast<double>() * point;
}

TEST(SkinningTest, IdentityPoseIsTheRestShape) {
  const Body body = box_hand_body();
  const ShapedBody person = shaped_body(body, std::array{0.7, -1.0});
  const PosedBody posed = posed_body(person, rest_pose(body));
  for (std::size_t i = 0; i < person.vertices.size(); ++i) {
    EXPECT_LT((posed.vertices[i] - person.vertices[i]).norm(), kTolerance);
  }
  for (int i = 0; i < kSupersetSize; ++i) {
    EXPECT_LT((posed.landmarks[i].cast<float>() - person.landmarks[i]).norm(), kTolerance);
  }
}

TEST(SkinningTest, AgreesWithWalkingUpTheChain) {
  const Body body = box_hand_body();
  const ShapedBody person = shaped_body(body, std::array{-0.5, 1.0});
  const BodyPose pose = random_pose(body, 1);
  const PosedBody posed = posed_body(person, pose);
  for (std::size_t i = 0; i < person.vertices.size(); ++i) {
    Eigen::Vector3d expected = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
      expected += body.weights[i][k] *
                  moved_by_chain(person, pose, body.weight_bones[i][k], person.vertices[i].cast<double>());
    }
    EXPECT_LT((posed.vertices[i].cast<double>() - expected).norm(), kTolerance);
  }
  for (int i = 0; i < kSupersetSize; ++i) {
    const Eigen::Vector3d expected =
        moved_by_chain(person, pose, body.landmark_bones[i], person.landmarks[i].cast<double>());
    EXPECT_LT((posed.landmarks[i] - expected).norm(), kTolerance);
  }
}

TEST(SkinningTest, JointRotationTurnsOnlyWhatHangsOnIt) {
  const Body body = box_hand_body();
  const ShapedBody person = plain_person(body);
  BodyPose pose = rest_pose(body);
  const int bone = body.bone("finger2-2.R");
  pose.rotations[bone] = Eigen::AngleAxisf(1.2f, Eigen::Vector3f::UnitX());
  const PosedBody posed = posed_body(person, pose);
  const auto landmark = [&](Landmark which) { return posed.landmarks[static_cast<std::size_t>(which)]; };
  const auto at_rest = [&](Landmark which) {
    return Point3(person.landmarks[static_cast<std::size_t>(which)].cast<double>());
  };
  EXPECT_LT((landmark(Landmark::index_mcp) - at_rest(Landmark::index_mcp)).norm(), kTolerance);
  EXPECT_LT((landmark(Landmark::index_pip) - at_rest(Landmark::index_pip)).norm(), kTolerance);
  EXPECT_LT((landmark(Landmark::middle_tip) - at_rest(Landmark::middle_tip)).norm(), kTolerance);
  EXPECT_GT((landmark(Landmark::index_dip) - at_rest(Landmark::index_dip)).norm(), 10.0);
}

TEST(SkinningTest, GlobalIsometryKeepsAllDistances) {
  const Body body = box_hand_body();
  const ShapedBody person = plain_person(body);
  BodyPose pose = random_pose(body, 2);
  const PosedBody before = posed_body(person, pose);
  const Eigen::Isometry3f moved =
      Eigen::Translation3f(3, 50, -70) * Eigen::AngleAxisf(0.8f, Eigen::Vector3f(1, 2, 3).normalized());
  pose.camera_from_body = moved * pose.camera_from_body;
  const PosedBody after = posed_body(person, pose);
  for (std::size_t i = 0; i < before.vertices.size(); ++i) {
    EXPECT_LT((after.vertices[i] - moved * before.vertices[i]).norm(), kTolerance);
  }
}

TEST(SkinningTest, BonesKeepTheirLengthInEveryPose) {
  const Body body = box_hand_body();
  const ShapedBody person = shaped_body(body, std::array{0.4, 0.3});
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const PosedBody posed = posed_body(person, random_pose(body, seed));
    for (int first = static_cast<int>(Landmark::thumb_cmc); first < kSupersetSize; first += 4) {
      for (int k = first; k < first + 3; ++k) {
        const double rest = (person.landmarks[k + 1] - person.landmarks[k]).norm();
        EXPECT_NEAR((posed.landmarks[k + 1] - posed.landmarks[k]).norm(), rest, kTolerance);
      }
    }
  }
}

TEST(SkinningTest, ShapeIsLinearAndJointsFollow) {
  const Body body = box_hand_body();
  const ShapedBody base = plain_person(body);
  const ShapedBody half = shaped_body(body, std::array{0.5, 0.5});
  const ShapedBody whole = shaped_body(body, std::array{1.0, 1.0});
  for (std::size_t i = 0; i < base.vertices.size(); ++i) {
    EXPECT_LT((2.0f * half.vertices[i] - base.vertices[i] - whole.vertices[i]).norm(), kTolerance);
  }
  const int bone = body.bone("finger3-3.R");
  EXPECT_NEAR(whole.joints[bone].y(), 1.1f * base.joints[bone].y(), kTolerance);
}

TEST(SkinningTest, FewerVerticesAreTheSameVertices) {
  const Body body = box_hand_body();
  const ShapedBody person = plain_person(body);
  const BodyPose pose = random_pose(body, 3);
  const PosedBody whole = posed_body(person, pose);
  const PosedBody some = posed_body(person, pose, 16);
  ASSERT_EQ(some.vertices.size(), 16u);
  for (std::size_t i = 0; i < some.vertices.size(); ++i) EXPECT_EQ(some.vertices[i], whole.vertices[i]);
  EXPECT_EQ(some.landmarks, whole.landmarks);
}

TEST(SkinningTest, DualQuaternionsMoveAVertexOfOneBoneAsItsMatrixDoes) {
  Body body = box_hand_body();
  for (auto& bones : body.weight_bones) bones[1] = bones[0];  // half and half of the same
  const ShapedBody person = plain_person(body);
  const BodyPose pose = random_pose(body, 6);
  const PosedBody linear = posed_body(person, pose);
  const PosedBody rigid = posed_body(person, pose, Skinning::dual_quaternion);
  for (std::size_t i = 0; i < linear.vertices.size(); ++i) {
    EXPECT_LT((rigid.vertices[i] - linear.vertices[i]).norm(), 5e-3f) << i;
  }
  EXPECT_EQ(rigid.landmarks, linear.landmarks);
}

TEST(SkinningTest, HalfOfABendIsHalfOfItsAngleAtTheSameDistance) {
  const Body body = box_hand_body();
  const ShapedBody person = plain_person(body);
  const int bone = body.bone("finger3-2.R");
  const Eigen::Vector3f joint = person.joints[bone];
  BodyPose pose = rest_pose(body);
  pose.rotations[bone] = Eigen::AngleAxisf(2.0f, Eigen::Vector3f::UnitX());
  const PosedBody linear = posed_body(person, pose);
  const PosedBody rigid = posed_body(person, pose, Skinning::dual_quaternion);
  const Eigen::AngleAxisf half(1.0f, Eigen::Vector3f::UnitX());
  int ring = 0;
  for (std::size_t i = 0; i < person.vertices.size(); ++i) {
    const bool is_shared = (body.weight_bones[i][0] == bone) != (body.weight_bones[i][1] == bone);
    if (!is_shared || (person.vertices[i] - joint).norm() > 15.0f) continue;
    ++ring;  // the corners of the tube at the joint: half on the bone, half on the one before
    const Eigen::Vector3f expected = half * (person.vertices[i] - joint) + joint;
    EXPECT_LT((rigid.vertices[i] - expected).norm(), kTolerance);
    EXPECT_LT((linear.vertices[i] - joint).norm(), (expected - joint).norm() - 1.0f) << "linear thins";
  }
  EXPECT_GE(ring, 4);
}

TEST(SkinningTest, BadInputIsNamed) {
  const Body body = box_hand_body();
  const ShapedBody person = plain_person(body);
  BodyPose pose = rest_pose(body);
  EXPECT_THAT(error_of([&] { shaped_body(body, std::array{1.0}); }), HasSubstr("1 coefficients for 2"));
  EXPECT_THAT(error_of([&] { shaped_body(body, std::array{kNaN, 0.0}); }), HasSubstr("'longer'"));
  EXPECT_THAT(error_of([&] { posed_body(person, pose, 1 << 20); }), HasSubstr("vertices asked for"));
  pose.camera_from_body.translation().x() = static_cast<float>(kNaN);
  EXPECT_THAT(error_of([&] { posed_body(person, pose); }), HasSubstr("camera_from_body is not finite"));
  pose.rotations[1].w() = static_cast<float>(kNaN);
  EXPECT_THAT(error_of([&] { posed_body(person, pose); }), HasSubstr("'wrist.R'"));
  pose.rotations.pop_back();
  EXPECT_THAT(error_of([&] { posed_body(person, pose); }), HasSubstr("rotations for"));
}

}  // namespace
}  // namespace knuckle
