// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/body.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <unordered_set>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"

namespace knuckle {
namespace {

/// How far weights may sum from 1: the rounding of files that keep four decimals.
constexpr double kWeightSumTolerance = 1e-3;

void check_size(std::string_view what, std::string_view name, std::size_t size, std::size_t expected) {
  if (size != expected) fail("{}: {} has {} entries, expected {}", what, name, size, expected);
}

void check_group(std::string_view what, std::string_view owner, const VertexGroup& group,
                 std::size_t vertex_count) {
  check_size(what, owner, group.weights.size(), group.vertices.size());
  if (group.vertices.empty()) fail("{}: {} has no vertices", what, owner);
  double sum = 0.0;
  for (std::size_t i = 0; i < group.vertices.size(); ++i) {
    const std::int32_t vertex = group.vertices[i];
    if (vertex < 0 || vertex >= static_cast<std::int64_t>(vertex_count)) {
      fail("{}: {} names vertex {}, the body has {}", what, owner, vertex, vertex_count);
    }
    if (!std::isfinite(group.weights[i])) fail("{}: {} has a weight that is not a number", what, owner);
    sum += group.weights[i];
  }
  if (!(std::abs(sum - 1.0) <= kWeightSumTolerance)) {
    fail("{}: weights of {} sum to {:.4g}, expected 1", what, owner, sum);
  }
}

void check_mesh(const Body& body, std::string_view what) {
  if (body.v_template.empty()) fail("{}: v_template is empty", what);
  for (std::size_t i = 0; i < body.v_template.size(); ++i) {
    if (!body.v_template[i].allFinite()) fail("{}: v_template of vertex {} is not finite", what, i);
  }
  const auto vertex_count = static_cast<std::int64_t>(body.v_template.size());
  for (std::size_t i = 0; i < body.faces.size(); ++i) {
    for (const std::int32_t vertex : body.faces[i]) {
      if (vertex < 0 || vertex >= vertex_count) {
        fail("{}: face {} names vertex {}, the body has {}", what, i, vertex, vertex_count);
      }
    }
  }
  check_size(what, "is_hand", body.is_hand.size(), body.faces.size());
  for (std::size_t i = 0; i < body.is_hand.size(); ++i) {
    if (body.is_hand[i] > 1) fail("{}: is_hand of face {} is {}, expected 0 or 1", what, i, body.is_hand[i]);
  }
}

void check_sections(const Body& body, std::string_view what) {
  for (const BodySection& section : body.sections) {
    if (section.vertices < 0 || section.vertices > std::ssize(body.v_template) || section.faces < 0 ||
        section.faces > std::ssize(body.faces)) {
      fail("{}: a section of {} vertices and {} faces, the body has {} and {}", what, section.vertices,
           section.faces, body.v_template.size(), body.faces.size());
    }
    for (std::int32_t i = 0; i < section.faces; ++i) {
      if (std::ranges::max(body.faces[i]) >= section.vertices) {
        fail("{}: face {} reaches out of its section of {} vertices", what, i, section.vertices);
      }
    }
  }
}

void check_bones(const Body& body, std::string_view what) {
  if (body.names.empty()) fail("{}: the body has no bones", what);
  if (body.names.size() > static_cast<std::size_t>(limits::kBones))
    fail("{}: the body has {} bones, expected at most {}", what, body.names.size(), limits::kBones);
  check_size(what, "parents", body.parents.size(), body.names.size());
  std::unordered_set<std::string_view> seen;
  for (std::size_t i = 0; i < body.names.size(); ++i) {
    if (!seen.insert(body.names[i]).second) fail("{}: two bones are named '{}'", what, body.names[i]);
    if (body.parents[i] < -1 || body.parents[i] >= static_cast<std::int64_t>(i)) {
      fail("{}: parents of bone {} ('{}') is {}, expected -1 or a bone before it; a cycle is not a skeleton",
           what, i, body.names[i], body.parents[i]);
    }
  }
}

void check_weights(const Body& body, std::string_view what) {
  check_size(what, "weights", body.weights.size(), body.v_template.size());
  check_size(what, "weight_bones", body.weight_bones.size(), body.v_template.size());
  const auto bone_count = static_cast<std::int64_t>(body.names.size());
  for (std::size_t i = 0; i < body.weights.size(); ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
      const std::int32_t bone = body.weight_bones[i][k];
      const float weight = body.weights[i][k];
      if (bone < 0 || bone >= bone_count) {
        fail("{}: weights of vertex {} name bone {}, the body has {}", what, i, bone, bone_count);
      }
      if (!(weight >= 0.0f)) fail("{}: a weight of vertex {} is {}, expected at least 0", what, i, weight);
      sum += weight;
    }
    if (!(std::abs(sum - 1.0) <= kWeightSumTolerance)) {
      fail("{}: weights of vertex {} sum to {:.4g}, expected 1", what, i, sum);
    }
  }
}

void check_shapedirs(const Body& body, std::string_view what) {
  const auto vertex_count = static_cast<std::int64_t>(body.v_template.size());
  std::unordered_set<std::string_view> seen;
  for (const ShapeDirection& direction : body.shapedirs) {
    if (!seen.insert(direction.name).second) {
      fail("{}: two shape directions are named '{}'", what, direction.name);
    }
    check_size(what, direction.name, direction.offsets_mm.size(), direction.vertices.size());
    for (std::size_t i = 0; i < direction.vertices.size(); ++i) {
      const std::int32_t vertex = direction.vertices[i];
      if (vertex < 0 || vertex >= vertex_count) {
        fail("{}: shape direction '{}' names vertex {}, the body has {}", what, direction.name, vertex,
             vertex_count);
      }
      if (!direction.offsets_mm[i].allFinite()) {
        fail("{}: shape direction '{}' has an offset that is not finite", what, direction.name);
      }
    }
  }
}

void check_regressors(const Body& body, std::string_view what) {
  const std::size_t vertex_count = body.v_template.size();
  check_size(what, "joint_regressor", body.joint_regressor.size(), body.names.size());
  for (std::size_t i = 0; i < body.joint_regressor.size(); ++i) {
    check_group(what, "joint_regressor of " + body.names[i], body.joint_regressor[i], vertex_count);
  }
  for (int i = 0; i < kSupersetSize; ++i) {
    const std::string name(name_of(static_cast<Landmark>(i)));
    check_group(what, "landmark_regressor of " + name, body.landmark_regressor[i], vertex_count);
    const std::int32_t bone = body.landmark_bones[i];
    if (bone < 0 || bone >= static_cast<std::int64_t>(body.names.size())) {
      fail("{}: landmark_bones of {} is {}, the body has {} bones", what, name, bone, body.names.size());
    }
  }
}

}  // namespace

int Body::bone(std::string_view name) const {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) fail("the body has no bone '{}'", name);
  return static_cast<int>(found - names.begin());
}

void check(const Body& body, std::string_view what) {
  check_mesh(body, what);
  check_sections(body, what);
  check_bones(body, what);
  check_weights(body, what);
  check_shapedirs(body, what);
  check_regressors(body, what);
}

}  // namespace knuckle
