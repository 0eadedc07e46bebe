// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/makehuman/hand_anatomy.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/hand/skinning.h"
#include "knuckle/synth/makehuman/hand_weights.h"

namespace knuckle {
namespace {

constexpr int kMiddle = 2;

/// Lengths of the last, middle and first bone of thumb to little, as fractions of hand length: Buchholz et
/// al. 1992. The thumb's are its distal and proximal phalanx and its metacarpal.
constexpr std::array<std::array<double, 3>, kFingers> kBoneLengths{{{0.158, 0.196, 0.251},
                                                                    {0.097, 0.143, 0.245},
                                                                    {0.108, 0.170, 0.266},
                                                                    {0.107, 0.165, 0.244},
                                                                    {0.093, 0.117, 0.204}}};

/// How deep a finger's joints lie, from the skin of its back (0) to that of the palm's side (1): behind the
/// bone is thin skin, before it are the flexors' tendons and the pulp.
constexpr float kJointDepth = 0.4f;

/// How far a finger tip lies inside the end of the last bone, as a fraction of that bone.
constexpr float kTipInset = 0.1f;

/// (1 - share) a + share b.
VertexGroup mixed(const VertexGroup& a, const VertexGroup& b, float share) {
  std::map<std::int32_t, float> weights;
  for (std::size_t i = 0; i < a.vertices.size(); ++i) weights[a.vertices[i]] += (1.0f - share) * a.weights[i];
  for (std::size_t i = 0; i < b.vertices.size(); ++i) weights[b.vertices[i]] += share * b.weights[i];
  VertexGroup group;
  for (const auto& [vertex, weight] : weights) {
    group.vertices.push_back(vertex);
    group.weights.push_back(weight);
  }
  return group;
}

/// The point that lies `distance_mm` from the first along the line through all points.
VertexGroup along_line(const std::vector<VertexGroup>& line, double distance_mm,
                       const std::vector<Eigen::Vector3f>& vertices) {
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double length = (group_mean(line[i + 1], vertices) - group_mean(line[i], vertices)).norm();
    if (distance_mm <= length) return mixed(line[i], line[i + 1], static_cast<float>(distance_mm / length));
    distance_mm -= length;
  }
  fail("hand anatomy: a finger is {:.1f} mm too short for its bones", distance_mm);
}

/// Where a ray from `origin` leaves the skin: the weighted mean of the corners of the first triangle that it
/// meets (Moeller and Trumbore 1997).
VertexGroup skin_along(const Body& body, const std::vector<Eigen::Vector3f>& vertices,
                       const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  VertexGroup hit;
  for (const auto& face : body.faces) {
    const Eigen::Vector3d corner = vertices[face[0]].cast<double>();
    const Eigen::Vector3d edge_1 = vertices[face[1]].cast<double>() - corner;
    const Eigen::Vector3d edge_2 = vertices[face[2]].cast<double>() - corner;
    const Eigen::Vector3d p = direction.cross(edge_2);
    const double determinant = edge_1.dot(p);
    if (determinant == 0.0) continue;
    const Eigen::Vector3d from_corner = origin - corner;
    const Eigen::Vector3d q = from_corner.cross(edge_1);
    const double u = from_corner.dot(p) / determinant;
    const double v = direction.dot(q) / determinant;
    const double distance = edge_2.dot(q) / determinant;
    if (u < 0.0 || v < 0.0 || u + v > 1.0 || distance <= 0.0 || distance >= nearest) continue;
    nearest = distance;
    hit = {{face[0], face[1], face[2]},
           {static_cast<float>(1.0 - u - v), static_cast<float>(u), static_cast<float>(v)}};
  }
  if (hit.vertices.empty()) fail("hand anatomy: a joint lies outside of the skin");
  return hit;
}

/// The part of `direction` that is square to `axis`, of length 1.
Eigen::Vector3d square_to(const Eigen::Vector3d& axis, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d unit = axis.normalized();
  return (direction - direction.dot(unit) * unit).normalized();
}

/// The joint moved square to the finger to where bones lie between the skin of back and front.
VertexGroup at_depth(const Body& body, const std::vector<Eigen::Vector3f>& vertices, const VertexGroup& joint,
                     const Eigen::Vector3d& back) {
  const Eigen::Vector3d point = group_mean(joint, vertices);
  return mixed(skin_along(body, vertices, point, back), skin_along(body, vertices, point, -back),
               kJointDepth);
}

/// Where the back of each digit looks at rest: that of the fingers away from the palm, that of the thumb to
/// the side of the index finger.
std::array<Eigen::Vector3d, kFingers> back_directions(const Body& body, const HandOfBody& hand,
                                                      const std::vector<Eigen::Vector3f>& vertices) {
  const auto joint = [&](int finger, int number) {
    return group_mean(body.joint_regressor[body.bone(finger_bone(finger, number, hand.suffix))], vertices);
  };
  const Eigen::Vector3d wrist =
      group_mean(body.joint_regressor[body.bone(fmt::format("wrist{}", hand.suffix))], vertices);
  const Eigen::Vector3d to_index = joint(1, 0) - joint(4, 0);
  const double side = hand.suffix == ".R" ? 1.0 : -1.0;
  const Eigen::Vector3d back = side * (joint(kMiddle, 0) - wrist).cross(to_index);
  std::array<Eigen::Vector3d, kFingers> directions;
  for (int finger = 0; finger < kFingers; ++finger) {
    directions[finger] = square_to(joint(finger, 2) - joint(finger, 0), finger == 0 ? to_index : back);
  }
  return directions;
}

void place_joints(Body& body, const HandOfBody& hand, const std::vector<Eigen::Vector3f>& vertices) {
  const VertexGroup wrist = body.joint_regressor[body.bone(fmt::format("wrist{}", hand.suffix))];
  const double hand_length =
      (group_mean(hand.fingertip_bones[kMiddle], vertices) - group_mean(wrist, vertices)).norm();
  const auto backs = back_directions(body, hand, vertices);
  for (int finger = 0; finger < kFingers; ++finger) {
    std::array<int, 3> bones{};
    std::vector<VertexGroup> line{hand.fingertip_bones[finger]};
    for (int joint = 2; joint >= 0; --joint) {
      bones[joint] = body.bone(finger_bone(finger, joint, hand.suffix));
      line.push_back(body.joint_regressor[bones[joint]]);
    }
    const int parent = body.parents[bones[0]];
    line.push_back(body.joint_regressor[parent]);  // the wrist for the thumb, a metacarpal for the others
    double from_tip = 0.0;
    for (int joint = 2; joint >= 0; --joint) {
      from_tip += kBoneLengths[finger][2 - joint] * hand_length;
      const VertexGroup on_line = along_line(line, from_tip, vertices);
      const bool is_deep =
          finger == 0 && joint == 0;  // the thumb's saddle joint: no skin near it to measure by
      body.joint_regressor[bones[joint]] =
          is_deep ? on_line : at_depth(body, vertices, on_line, backs[finger]);
    }
  }
}

}  // namespace

std::string finger_bone(int finger, int joint, std::string_view suffix) {
  return fmt::format("finger{}-{}{}", finger + 1, joint + 1, suffix);
}

void fit_hand_to_anatomy(Body& body, const HandOfBody& hand, std::span<const double> coefficients) {
  const ShapedBody person = shaped_body(body, coefficients);
  place_joints(body, hand, person.vertices);
  spread_hand_weights(body, hand, person.vertices);
}

void set_hand_landmarks(Body& body, const HandOfBody& hand) {
  const auto set = [&](Landmark landmark, const VertexGroup& group, int bone) {
    body.landmark_regressor[static_cast<std::size_t>(landmark)] = group;
    body.landmark_bones[static_cast<std::size_t>(landmark)] = bone;
  };
  const int wrist = body.bone(fmt::format("wrist{}", hand.suffix));
  set(Landmark::wrist, body.joint_regressor[wrist], wrist);
  VertexGroup knuckles = body.joint_regressor[body.bone(finger_bone(1, 0, hand.suffix))];
  for (int finger = 0; finger < kFingers; ++finger) {
    const int first = static_cast<int>(Landmark::thumb_cmc) + 4 * finger;
    for (int joint = 0; joint < 3; ++joint) {
      const int bone = body.bone(finger_bone(finger, joint, hand.suffix));
      set(static_cast<Landmark>(first + joint), body.joint_regressor[bone], bone);
      if (finger > 1 && joint == 0) {  // a running mean: of two, three, four
        knuckles = mixed(knuckles, body.joint_regressor[bone], 1.0f / static_cast<float>(finger));
      }
    }
    const int last = body.bone(finger_bone(finger, 2, hand.suffix));
    set(static_cast<Landmark>(first + 3),
        mixed(hand.fingertip_bones[finger], body.joint_regressor[last], kTipInset), last);
  }
  set(Landmark::palm, mixed(body.joint_regressor[wrist], knuckles, 0.5f), wrist);
}

}  // namespace knuckle
