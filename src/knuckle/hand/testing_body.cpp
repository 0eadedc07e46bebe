// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/testing_body.h"

#include <string>

namespace knuckle::testing {
namespace {

/// A square tube along joints: a ring of four vertices at each joint, closed at both ends. A ring moves with
/// the bones before and behind it, half each.
class Builder {
 public:
  std::int32_t add_bone(const std::string& name, std::int32_t parent, const Eigen::Vector3f& head) {
    body_.names.push_back(name);
    body_.parents.push_back(parent);
    heads_.push_back(head);
    return static_cast<std::int32_t>(body_.names.size()) - 1;
  }

  void add_tube(const std::vector<Eigen::Vector3f>& joints, const std::vector<std::int32_t>& bones,
                const Eigen::Vector2f& half_size, std::uint8_t is_hand) {
    const auto first = static_cast<std::int32_t>(body_.v_template.size());
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const std::int32_t before = bones[i == 0 ? 0 : i - 1];
      const std::int32_t behind = bones[std::min(i, bones.size() - 1)];
      for (const auto& [x, z] : {std::pair{-1, 1}, {-1, -1}, {1, -1}, {1, 1}}) {
        add_vertex(joints[i] + Eigen::Vector3f(x * half_size.x(), 0, z * half_size.y()), before, behind);
      }
    }
    const auto last = static_cast<std::int32_t>(body_.v_template.size()) - 4;
    for (std::int32_t ring = first; ring < last; ring += 4) {
      for (std::int32_t k = 0; k < 4; ++k) {
        const std::int32_t next = (k + 1) % 4;
        add_quad({ring + k, ring + next, ring + 4 + next, ring + 4 + k}, is_hand);
      }
    }
    add_quad({first + 3, first + 2, first + 1, first}, is_hand);
    add_quad({last, last + 1, last + 2, last + 3}, is_hand);
  }

  /// The point as a vertex of its own, without faces, that moves with `bone`.
  VertexGroup marker(const Eigen::Vector3f& point, std::int32_t bone) {
    add_vertex(point, bone, bone);
    return {{static_cast<std::int32_t>(body_.v_template.size()) - 1}, {1.0f}};
  }

  void set_landmark(Landmark landmark, const Eigen::Vector3f& point, std::int32_t bone) {
    body_.landmark_regressor[static_cast<std::size_t>(landmark)] = marker(point, bone);
    body_.landmark_bones[static_cast<std::size_t>(landmark)] = bone;
  }

  Body finish() {
    for (std::size_t i = 0; i < heads_.size(); ++i) {
      body_.joint_regressor.push_back(marker(heads_[i], static_cast<std::int32_t>(i)));
    }
    ShapeDirection longer{"longer", {}, {}};
    ShapeDirection thumb{"thumb", {}, {}};
    for (std::size_t i = 0; i < body_.v_template.size(); ++i) {
      const Eigen::Vector3f& vertex = body_.v_template[i];
      longer.vertices.push_back(static_cast<std::int32_t>(i));
      longer.offsets_mm.emplace_back(0.0f, 0.1f * vertex.y(), 0.0f);
      if (vertex.x() < -45.0f) {
        thumb.vertices.push_back(static_cast<std::int32_t>(i));
        thumb.offsets_mm.emplace_back(-3.0f, 0.0f, 1.0f);
      }
    }
    body_.shapedirs = {longer, thumb};
    body_.sections = {
        {static_cast<std::int32_t>(body_.v_template.size()), static_cast<std::int32_t>(body_.faces.size())}};
    return std::move(body_);
  }

 private:
  void add_vertex(const Eigen::Vector3f& position, std::int32_t bone_a, std::int32_t bone_b) {
    body_.v_template.push_back(position);
    body_.weight_bones.push_back({bone_a, bone_b, 0, 0});
    body_.weights.push_back({0.5f, 0.5f, 0.0f, 0.0f});
  }
  void add_quad(const std::array<std::int32_t, 4>& quad, std::uint8_t is_hand) {
    body_.faces.push_back({quad[0], quad[1], quad[2]});
    body_.faces.push_back({quad[0], quad[2], quad[3]});
    body_.is_hand.insert(body_.is_hand.end(), 2, is_hand);
  }

  Body body_;
  std::vector<Eigen::Vector3f> heads_;
};

const Eigen::Vector3f kElbow(0, 250, 0);
const Eigen::Vector3f kWrist(0, 0, 0);

/// The hand, which hangs from the bone `forearm`.
void add_hand(Builder& builder, std::int32_t forearm) {
  const Eigen::Vector3f wrist = kWrist;
  const std::int32_t wrist_bone = builder.add_bone("wrist.R", forearm, wrist);
  builder.add_tube({wrist, {0, -80, 0}}, {wrist_bone}, {40, 13}, 1);
  builder.set_landmark(Landmark::wrist, wrist, wrist_bone);
  builder.set_landmark(Landmark::palm, {0, -45, 0}, wrist_bone);
  for (int finger = 1; finger <= 5; ++finger) {
    const bool is_thumb = finger == 1;
    const float x = is_thumb ? -50.0f : -30.0f + 20.0f * static_cast<float>(finger - 2);
    std::vector<Eigen::Vector3f> joints;
    if (is_thumb) {
      joints = {{x, -20, 5}, {x, -65, 5}, {x, -97, 5}, {x, -125, 5}};
    } else {
      joints = {{x, -85, 0}, {x, -130, 0}, {x, -160, 0}, {x, -185, 0}};
    }
    std::int32_t parent = wrist_bone;
    if (!is_thumb) {
      const std::string name = "metacarpal" + std::to_string(finger - 1) + ".R";
      parent = builder.add_bone(name, wrist_bone, {0.5f * x, -20, 0});
    }
    std::vector<std::int32_t> bones;
    for (int k = 0; k < 3; ++k) {
      const std::string name = "finger" + std::to_string(finger) + "-" + std::to_string(k + 1) + ".R";
      bones.push_back(builder.add_bone(name, k == 0 ? parent : bones.back(), joints[k]));
    }
    builder.add_tube(joints, bones, {8, 7}, 1);
    const int first = static_cast<int>(Landmark::thumb_cmc) + 4 * (finger - 1);
    for (int k = 0; k < 4; ++k) {
      builder.set_landmark(static_cast<Landmark>(first + k), joints[k], bones[std::min(k, 2)]);
    }
  }
}

}  // namespace

Body box_hand_body() {
  Builder builder;
  const std::int32_t forearm = builder.add_bone("lowerarm02.R", -1, kElbow);
  builder.add_tube({kElbow, kWrist}, {forearm}, {25, 20}, 0);
  add_hand(builder, forearm);
  return builder.finish();
}

Body box_arm_body() {
  Builder builder;
  const Eigen::Vector3f shoulder(0, 530, 40);
  const Eigen::Vector3f middle(0, 125, 0);
  const std::int32_t upper_arm = builder.add_bone("upperarm01.R", -1, shoulder);
  const std::int32_t elbow = builder.add_bone("lowerarm01.R", upper_arm, kElbow);
  const std::int32_t forearm = builder.add_bone("lowerarm02.R", elbow, middle);
  builder.add_tube({shoulder, kElbow, middle, kWrist}, {upper_arm, elbow, forearm}, {25, 20}, 0);
  add_hand(builder, forearm);
  return builder.finish();
}

}  // namespace knuckle::testing
