// SPDX-License-Identifier: Apache-2.0
// For tests alone.
#pragma once

#include "knuckle/data/frame_record.h"
#include "knuckle/hand/adult_skeleton.h"

namespace knuckle::testing {

/// The record of a straight right hand of an adult whose wrist is at `wrist_mm`, as a hand model leaves it.
inline HandRecord fitted_hand(const Point3& wrist_mm) {
  const auto points =
      landmarks(adult_skeleton(), HandAngles{}, RigidTransform(Eigen::Translation3d(wrist_mm)));
  HandRecord hand;
  hand.convention = superset_convention();
  hand.landmarks_mm.assign(points.begin(), points.end());
  hand.landmarks_px.resize(points.size());
  hand.skeleton = "adult";
  return hand;
}

}  // namespace knuckle::testing
