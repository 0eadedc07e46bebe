// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/makehuman/hand_weights.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/hand/skinning.h"
#include "knuckle/synth/makehuman/bone_heat.h"

namespace knuckle {
namespace {

/// How firmly bones hold the skin: transitions of about half the finger's radius, as in a bent finger.
constexpr double kHeat = 4.0;

/// The bones of the hand, from the wrist on, each with where it ends.
std::vector<std::pair<int, BoneSegment>> hand_bones(const Body& body, const HandOfBody& hand,
                                                    const std::vector<Eigen::Vector3f>& vertices) {
  const auto head = [&](int bone) { return group_mean(body.joint_regressor[bone], vertices); };
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
    bones.push_back({last, {head(last), group_mean(hand.fingertip_bones[finger], vertices)}});
  }
  bones.push_back({wrist, {head(wrist), carpus}});
  return bones;
}

/// The strongest four of a vertex's weights, strongest first, scaled to sum to 1.
void set_weights(Body& body, std::int32_t vertex, std::vector<std::pair<double, std::int32_t>> weights) {
  weights.resize(std::max<std::size_t>(weights.size(), Body::kBonesPerVertex), {0.0, 0});
  std::ranges::stable_sort(weights, [](const auto& a, const auto& b) { return a.first > b.first; });
  double sum = 0.0;
  for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) sum += std::max(0.0, weights[k].first);
  for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
    const double weight = std::max(0.0, weights[k].first) / sum;
    body.weights[vertex][k] = static_cast<float>(weight);
    body.weight_bones[vertex][k] = weight > 0.0 ? weights[k].second : 0;
  }
}

}  // namespace

void spread_hand_weights(Body& body, const HandOfBody& hand, const std::vector<Eigen::Vector3f>& vertices) {
  const auto bones = hand_bones(body, hand, vertices);
  const auto is_hand_bone = [&](std::int32_t bone) {
    return std::ranges::any_of(bones, [&](const auto& entry) { return entry.first == bone; });
  };
  std::vector<double> share(body.v_template.size(), 0.0);
  for (std::size_t i = 0; i < share.size(); ++i) {
    for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
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
  points.reserve(members.size());
  for (const std::int32_t vertex : members) points.push_back(vertices[vertex].cast<double>());
  std::vector<BoneSegment> segments;
  segments.reserve(bones.size());
  for (const auto& [bone, segment] : bones) segments.push_back(segment);
  const Eigen::MatrixXd heat = bone_heat_weights(points, faces, segments, kHeat);
  for (std::size_t i = 0; i < members.size(); ++i) {
    const std::int32_t vertex = members[i];
    std::vector<std::pair<double, std::int32_t>> weights;
    for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
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

}  // namespace knuckle
