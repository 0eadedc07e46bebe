// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/render/view_culling.h"

#include <algorithm>
#include <array>
#include <map>

namespace knuckle {
namespace {

/// A point with normal . x + offset below 0 is not seen. Normals have length 1.
struct Side {
  Eigen::Vector3f normal;
  float offset;
};

/// The sides of what the camera sees, a pixel wider than the image.
std::array<Side, 5> sides_of_view(const Camera& camera) {
  constexpr double kMargin = 1.0;
  const double left = -kMargin - camera.cx;
  const double right = camera.width - 1 + kMargin - camera.cx;
  const double top = -kMargin - camera.cy;
  const double bottom = camera.height - 1 + kMargin - camera.cy;
  const bool projective = camera.model == CameraModel::projective;
  // f x - edge z >= 0 (projective) or f x - edge >= 0 (orthographic), and the other way round.
  const auto side = [&](int axis, double focal, double edge, double sign) {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    normal[axis] = sign * focal;
    if (projective) normal.z() = -sign * edge;
    const double length = normal.norm();
    return Side{(normal / length).cast<float>(),
                projective ? 0.0f : static_cast<float>(-sign * edge / length)};
  };
  return {side(0, camera.fx, left, 1.0), side(0, camera.fx, right, -1.0), side(1, camera.fy, top, 1.0),
          side(1, camera.fy, bottom, -1.0), Side{Eigen::Vector3f::UnitZ(), 0.0f}};
}

}  // namespace

ViewCulling::ViewCulling(const ShapedBody& person)
    : whole_{static_cast<std::int32_t>(person.vertices.size()),
             static_cast<std::int32_t>(person.body->faces.size())},
      limb_(whole_) {
  const Body& body = *person.body;
  const std::size_t sections = body.sections.size();
  if (sections < 2 || body.sections.back().faces != whole_.faces) return;
  limb_ = body.sections[sections - 2];
  std::map<std::int32_t, Eigen::AlignedBox3f> boxes;
  for (std::int32_t f = limb_.faces; f < whole_.faces; ++f) {
    for (const std::int32_t vertex : body.faces[f]) {
      for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
        if (body.weights[vertex][k] > 0.0f)
          boxes[body.weight_bones[vertex][k]].extend(person.vertices[vertex]);
      }
    }
  }
  constexpr float kRoundingMm = 0.1f;
  for (const auto& [bone, box] : boxes) {
    trunk_.push_back({bone, box.center(), 0.5f * box.diagonal().norm() + kRoundingMm});
  }
}

BodySection ViewCulling::visible_section(const std::vector<Eigen::Matrix4f>& transforms,
                                         const Camera& camera) const {
  if (camera.is_distorted() || trunk_.empty()) return whole_;
  // A vertex lies between the places that its bones give it, and a face between its vertices: a trunk whose
  // balls all lie on the outer side of one and the same plane cannot be seen.
  const auto is_unseen = [&](const Side& side) {
    return std::ranges::all_of(trunk_, [&](const Ball& ball) {
      const Eigen::Vector4f centre = transforms[ball.bone] * ball.centre.homogeneous();
      return side.normal.dot(centre.head<3>()) + side.offset < -ball.radius;
    });
  };
  return std::ranges::any_of(sides_of_view(camera), is_unseen) ? limb_ : whole_;
}

}  // namespace knuckle
