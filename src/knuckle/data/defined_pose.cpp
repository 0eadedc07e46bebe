// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/defined_pose.h"

#include "knuckle/core/error.h"
#include "knuckle/data/truth.h"

namespace knuckle {

SupersetPoints superset_points(const HandPose& pose, const Projection& projection) {
  SupersetPoints points;
  points.fill(Point3::Constant(kNaN));
  const std::vector<Point3> of_joints = points_in_camera(pose, projection);
  for (std::size_t i = 0; i < of_joints.size(); ++i) {
    const auto landmark = static_cast<std::size_t>(pose.convention.landmarks[i]);
    if (landmark < points.size()) points[landmark] = of_joints[i];
  }
  return points;
}

HandPose defined_pose(const LandmarkDefinition& definition, const HandPose& pose,
                      const Projection& projection, HandSide side) {
  const std::vector<Point3> points = definition.on(superset_points(pose, projection), side);
  HandPose defined = HandPose::missing(definition.convention);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].allFinite() && points[i].z() > 0.0) defined.joints[i] = projection.to_image(points[i]);
    if (pose.confidence.empty()) continue;
    const int source = pose.convention.index_of(definition.landmarks[i].bone);
    defined.confidence.push_back(source < 0 ? 0.0f : pose.confidence[static_cast<std::size_t>(source)]);
  }
  return defined;
}

void require_all_landmarks(const Convention& convention, std::string_view whose) {
  const ConventionMapping mapping = map_convention(convention, superset_convention());
  if (mapping.missing.empty()) return;
  fail("{}: its convention, {}, lacks '{}'; where landmarks lie is told from all of {}", whose,
       convention.name, name_of(mapping.missing.front()), superset_convention().name);
}

}  // namespace knuckle
