// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_estimate.h"

#include <algorithm>

#include "knuckle/data/defined_pose.h"

namespace knuckle {
namespace {

std::vector<LandmarkLabel> labels_of(const HandPose& pose) {
  std::vector<LandmarkLabel> labels(pose.joints.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (!pose.joints[i].is_missing()) labels[i].at = pose.joints[i];
  }
  return labels;
}

}  // namespace

std::vector<LabelChange> estimated_changes(std::int64_t frame, const std::vector<EstimatedHand>& hands,
                                           const Convention& convention, const std::string& author,
                                           const std::string& time) {
  std::vector<LabelChange> changes;
  for (const EstimatedHand& hand : hands) {
    if (std::ranges::find(changes, hand.side, &LabelChange::side) != changes.end()) continue;
    changes.push_back({.frame = frame,
                       .side = hand.side,
                       .revision = 1,
                       .act = LabelAct::estimate,
                       .author = author,
                       .time = time,
                       .seconds = 0.0,
                       .landmarks = labels_of(converted(hand.pose, convention))});
  }
  return changes;
}

}  // namespace knuckle
