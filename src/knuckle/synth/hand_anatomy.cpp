// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/hand_anatomy.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/synth/bone_heat.h"
#include "knuckle/synth/skinning.h"

namespace knuckle {
namespace {

constexpr int kFingers = 5;
constexpr int kMiddle = 2;

/// Lengths of the last, middle and first bone of thumb to little, as fractions of hand length: Buchholz et
/// al. 1992. The thumb's are its distal and proximal phalanx and its metacarpal.
constexpr std::array<std::array<double, 3>, kFingers> kBoneLengths{{{0.158, 0.196, 0.251},
                                                                    {0.097, 0.143, 0.245},
                                                                    {0.108, 0.170, 0.266},
                                                                    {0.107, 0.165, 0.244},
                                                                    {0.093, 0.117, 0.204}}};

/// How firmly bones hold the skin: transitions of about half the finger's radius, as in a bent finger.
constexpr double kHeat = 4.0;

/// How far a finger tip lies inside the end of the last bone, as a fraction of that bone.
constexpr float kTipInset = 0.1f;

std::string finger_bone(int finger, int joint, std::string_view suffix) {
  return fmt::format("finger{}-{}{}", finger + 1, joint + 1, suffix);
}

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

Eigen::Vector3d position(const VertexGroup& group, const std::vector<Eigen::Vector3f>& vertices) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < group.vertices.size(); ++i) {
    sum += group.weights[i] * vertices[group.vertices[i]].cast<double>();
  }
  return sum;
}

/// The point that lies `distance_mm` from the first along the line through all points.
VertexGroup along_line(const std::vector<VertexGroup>& line, double distance_mm,
                       const std::vector<Eigen::Vector3f>& vertices) {
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double length = (position(line[i + 1], vertices) - position(line[i], vertices)).norm();
    if (distance_mm <= length) return mixed(line[i], line[i + 1], static_cast<float>(distance_mm / length));
    distance_mm -= length;
  }
  fail("hand anatomy: a finger is {:.1f} mm too short for its bones", distance_mm);
}

void place_joints(Body& body, const HandOfBody& hand, const std::vector<Eigen::Vector3f>& vertices) {
  const VertexGroup wrist = body.joint_regressor[body.bone(fmt::format("wrist{}", hand.suffix))];
  const double hand_length =
      (position(hand.fingertip_bones[kMiddle], vertices) - position(wrist, vertices)).norm();
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
      body.joint_regressor[bones[joint]] = along_line(line, from_tip, vertices);
    }
  }
}

/// The bones of the hand, from the wrist on, each with where it ends.
std::vector<std::pair<int, BoneSegment>> hand_bones(const Body& body, const HandOfBody& hand,
                                                    const std::vector<Eigen::Vector3f>& vertices) {
  const auto head = [&](int bone) { return position(body.joint_regressor[bone], vertices); };
  const int wrist = body.bone(fmt::format("wrist{}", hand.suffix));
  std::vector<std::pair<int, BoneSegment>> bones;
  Eigen::Vector3d carpus = Eigen::Vector3d::Zero();
  for (int finger = 0; finger < kFingers; ++finger) {
    const int first = body.bone(finger_bone(finger, 0, hand.suffix));
    const int middle = body.bone(finger_bone(finger, 1, hand.suffix));
    const int last = body.bone(finger_bone(finger, 2, hand.suffix));
    if (body.parents[first] != wrist) {
      const int metacarpal = body.parents[first];
      carpus += 0.25 * head(metacarpal);
      bones.push_back({metacarpal, {head(metacarpal), head(first)}});
    }
    bones.push_back({first, {head(first), head(middle)}});
    bones.push_back({middle, {head(middle), head(last)}});
    bones.push_back({last, {head(last), position(hand.fingertip_bones[finger], vertices)}});
  }
  bones.push_back({wrist, {head(wrist), carpus}});
  return bones;
}

/// The strongest four of a vertex's weights, strongest first, scaled to sum to 1.
void set_weights(Body& body, std::int32_t vertex, std::vector<std::pair<double, std::int32_t>> weights) {
  weights.resize(std::max<std::size_t>(weights.size(), Body::kBonesAVertex), {0.0, 0});
  std::ranges::stable_sort(weights, [](const auto& a, const auto& b) { return a.first > b.first; });
  double sum = 0.0;
  for (std::size_t k = 0; k < Body::kBonesAVertex; ++k) sum += std::max(0.0, weights[k].first);
  for (std::size_t k = 0; k < Body::kBonesAVertex; ++k) {
    const double weight = std::max(0.0, weights[k].first) / sum;
    body.weights[vertex][k] = static_cast<float>(weight);
    body.weight_bones[vertex][k] = weight > 0.0 ? weights[k].second : 0;
  }
}

/// Spreads each vertex's share of the hand anew over the hand's bones; what the arm holds stays.
void spread_weights(Body& body, const HandOfBody& hand, const std::vector<Eigen::Vector3f>& vertices) {
  const auto bones = hand_bones(body, hand, vertices);
  const auto is_hand_bone = [&](std::int32_t bone) {
    return std::ranges::any_of(bones, [&](const auto& entry) { return entry.first == bone; });
  };
  std::vector<double> share(body.v_template.size(), 0.0);
  for (std::size_t i = 0; i < share.size(); ++i) {
    for (std::size_t k = 0; k < Body::kBonesAVertex; ++k) {
      if (is_hand_bone(body.weight_bones[i][k])) share[i] += body.weights[i][k];
    }
  }
  std::vector<std::int32_t> place(body.v_template.size(), -1);  // in the mesh of the hand alone
  std::vector<std::int32_t> members;
  std::vector<std::array<std::int32_t, 3>> faces;
  for (const auto& face : body.faces) {
    if (std::ranges::any_of(face, [&](std::int32_t vertex) { return share[vertex] == 0.0; })) continue;
    for (const std::int32_t vertex : face) {
      if (place[vertex] >= 0) continue;
      place[vertex] = static_cast<std::int32_t>(members.size());
      members.push_back(vertex);
    }
    faces.push_back({place[face[0]], place[face[1]], place[face[2]]});
  }
  std::vector<Eigen::Vector3d> points;
  for (const std::int32_t vertex : members) points.push_back(vertices[vertex].cast<double>());
  std::vector<BoneSegment> segments;
  for (const auto& [bone, segment] : bones) segments.push_back(segment);
  const Eigen::MatrixXd heat = bone_heat_weights(points, faces, segments, kHeat);
  for (std::size_t i = 0; i < members.size(); ++i) {
    const std::int32_t vertex = members[i];
    std::vector<std::pair<double, std::int32_t>> weights;
    for (std::size_t k = 0; k < Body::kBonesAVertex; ++k) {
      const std::int32_t bone = body.weight_bones[vertex][k];
      if (body.weights[vertex][k] > 0.0f && !is_hand_bone(bone))
        weights.push_back({body.weights[vertex][k], bone});
    }
    for (std::size_t b = 0; b < bones.size(); ++b) {
      weights.push_back(
          {share[vertex] * heat(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(b)), bones[b].first});
    }
    set_weights(body, vertex, std::move(weights));
  }
}

}  // namespace

void fit_hand_to_anatomy(Body& body, const HandOfBody& hand, std::span<const double> coefficients) {
  const ShapedBody person = shaped_body(body, coefficients);
  place_joints(body, hand, person.vertices);
  spread_weights(body, hand, person.vertices);
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
