// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "knuckle/camera/projection.h"
#include "knuckle/core/frame.h"
#include "knuckle/core/pose.h"
#include "knuckle/hand/landmark_definition.h"

namespace knuckle {

/// The 22 landmarks of a pose in camera coordinates [mm]; those that its convention lacks, or that are
/// missing, are NaN.
SupersetPoints superset_points(const HandPose& pose, const Projection& projection);

/// The landmarks of a definition on the hand that a pose shows. Each has the confidence of the landmark that
/// it is told from; one that cannot be told, or lies behind the camera, is missing. Throws nothing.
HandPose defined_pose(const LandmarkDefinition& definition, const HandPose& pose,
                      const Projection& projection, HandSide side);

/// Throws an Error that starts with `whose` where a convention lacks one of the 22, so that the landmarks of
/// a definition cannot be told.
void require_all_landmarks(const Convention& convention, std::string_view whose);

}  // namespace knuckle
