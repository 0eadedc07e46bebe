// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/body.h"

#include "knuckle/core/pose.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/testing_body.h"

namespace knuckle {
namespace {

using ::knuckle::testing::box_hand_body;
using ::knuckle::testing::error_of;
using ::testing::HasSubstr;

/// The message that `check` has for the box hand after `spoil`.
std::string error_after(const std::function<void(Body&)>& spoil) {
  Body body = box_hand_body();
  spoil(body);
  return error_of([&] { check(body, "a.model"); });
}

TEST(BodyTest, GoodBodyPasses) {
  EXPECT_NO_THROW(check(box_hand_body(), "box hand"));
}

TEST(BodyTest, BoxHandLooksOutwards) {
  const Body body = box_hand_body();
  double six_volumes = 0.0;  // of the tetrahedra between the faces and the origin
  for (const auto& [a, b, c] : body.faces) {
    six_volumes += body.v_template[a].dot(body.v_template[b].cross(body.v_template[c]));
  }
  const double expected = 250.0 * 50 * 40 + 80.0 * 80 * 26 + 105.0 * 16 * 14 + 4 * 100.0 * 16 * 14;
  EXPECT_NEAR(six_volumes / 6.0, expected, 1.0);
}

TEST(BodyTest, BoneIsFoundByName) {
  const Body body = box_hand_body();
  EXPECT_EQ(body.names[body.bone("finger3-2.R")], "finger3-2.R");
  EXPECT_THAT(error_of([&] { body.bone("tail"); }), HasSubstr("tail"));
}

TEST(BodyTest, MessagesNameTheFileAndTheFault) {
  EXPECT_THAT(error_after([](Body& body) { body.v_template.clear(); }),
              HasSubstr("a.model: v_template is empty"));
  EXPECT_THAT(error_after([](Body& body) { body.v_template[7].y() = static_cast<float>(kNaN); }),
              HasSubstr("a.model: v_template of vertex 7 is not finite"));
  EXPECT_THAT(error_after([](Body& body) { body.weights[3][0] = 0.9f; }),
              HasSubstr("weights of vertex 3 sum to 1.4"));
  EXPECT_THAT(error_after([](Body& body) {
                body.weights[3] = {1.5f, -0.5f, 0, 0};
              }),
              HasSubstr("at least 0"));
  EXPECT_THAT(error_after([](Body& body) { body.weights[3][1] = static_cast<float>(kNaN); }),
              HasSubstr("weight of vertex 3"));
  EXPECT_THAT(error_after([](Body& body) { body.weights.pop_back(); }), HasSubstr("weights has"));
  EXPECT_THAT(error_after([](Body& body) { body.weight_bones[5][1] = 999; }), HasSubstr("bone 999"));
  EXPECT_THAT(error_after([](Body& body) { body.faces[0][2] = -1; }), HasSubstr("face 0 names vertex -1"));
  EXPECT_THAT(error_after([](Body& body) { body.names.resize(4097, "another"); }),
              HasSubstr("a.model: the body has 4097 bones, expected at most 4096"));
  EXPECT_THAT(error_after([](Body& body) { body.is_hand.pop_back(); }), HasSubstr("is_hand"));
  EXPECT_THAT(error_after([](Body& body) { body.is_hand[0] = 2; }), HasSubstr("is_hand of face 0 is 2"));
  EXPECT_THAT(error_after([](Body& body) { body.shapedirs[0].vertices[0] = 1 << 20; }),
              HasSubstr("'longer'"));
  EXPECT_THAT(error_after([](Body& body) { body.shapedirs[1].offsets_mm.pop_back(); }), HasSubstr("thumb"));
  EXPECT_THAT(error_after([](Body& body) { body.shapedirs[1].name = "longer"; }), HasSubstr("two shape"));
  EXPECT_THAT(error_after([](Body& body) { body.shapedirs[0].offsets_mm[2].x() = static_cast<float>(kNaN); }),
              HasSubstr("shape direction 'longer' has an offset that is not finite"));
  EXPECT_THAT(error_after([](Body& body) { body.joint_regressor[1].weights[0] = 0.5f; }),
              HasSubstr("wrist.R"));
  EXPECT_THAT(error_after([](Body& body) { body.landmark_regressor[1].vertices.clear(); }),
              HasSubstr("landmark_regressor of palm has 1 entries, expected 0"));
  EXPECT_THAT(error_after([](Body& body) { body.landmark_regressor[1] = {}; }),
              HasSubstr("landmark_regressor of palm has no vertices"));
  EXPECT_THAT(error_after([](Body& body) { body.joint_regressor[1].weights[0] = static_cast<float>(kNaN); }),
              HasSubstr("wrist.R has a weight that is not a number"));
  EXPECT_THAT(error_after([](Body& body) { body.joint_regressor[1].vertices[0] = 1 << 20; }),
              HasSubstr("wrist.R names vertex 1048576"));
  EXPECT_THAT(error_after([](Body& body) { body.landmark_bones[0] = 77; }), HasSubstr("wrist is 77"));
  EXPECT_THAT(error_after([](Body& body) { body.names[2] = body.names[1]; }), HasSubstr("two bones"));
  EXPECT_THAT(error_after([](Body& body) { body.sections[0].vertices = 3; }), HasSubstr("section"));
  EXPECT_THAT(error_after([](Body& body) { body.sections[0].faces = -1; }), HasSubstr("-1 faces"));
  EXPECT_THAT(error_after([](Body& body) { body.shapedirs[0].offsets_mm[0].x() = INFINITY; }),
              HasSubstr("'longer'"));
  EXPECT_THAT(error_after([](Body& body) { body.joint_regressor[1].vertices[0] = -1; }),
              HasSubstr("names vertex -1"));
  EXPECT_THAT(error_after([](Body& body) { body.joint_regressor[1].weights[0] = NAN; }),
              HasSubstr("a weight that is not a number"));
  EXPECT_THAT(error_after([](Body& body) { body.parents.pop_back(); }), HasSubstr("parents has"));
  EXPECT_THAT(error_after([](Body& body) { body.sections[0].vertices = 3; }),
              HasSubstr("reaches out of its section of 3 vertices"));
  EXPECT_THAT(error_after([](Body& body) { body.sections[0].vertices = 1 << 20; }),
              HasSubstr("a section of 1048576 vertices"));
  EXPECT_THAT(error_after([](Body& body) {
                body.sections[0] = {1, -1};
              }),
              HasSubstr("a section of 1 vertices and -1 faces"));
  EXPECT_THAT(error_after([](Body& body) {
                body.names.clear();
                body.parents.clear();
              }),
              HasSubstr("a.model: the body has no bones"));
}

TEST(BodyTest, CycleInParentsIsRefused) {
  EXPECT_THAT(error_after([](Body& body) { body.parents[1] = 1; }), HasSubstr("cycle"));
  EXPECT_THAT(error_after([](Body& body) { body.parents[1] = 2; }), HasSubstr("'wrist.R'"));
  EXPECT_THAT(error_after([](Body& body) { body.parents[0] = -2; }), HasSubstr("is -2"));
}

}  // namespace
}  // namespace knuckle
