// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/hand_track.h"

#include <algorithm>
#include <array>

#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/track/one_euro_filter.h"

namespace knuckle {
namespace {

constexpr double kFastestMmPerSecond = 4000.0;  // hands hardly move faster
constexpr double kVelocityCutoffHz = 5.0;
constexpr int kMostSideVotes = 10;

}  // namespace

Point3 middle_of(const SkeletonPose& pose) {
  Point3 sum = Point3::Zero();
  for (const Point3& point : landmarks(adult_skeleton(), pose)) sum += point;
  return sum / static_cast<double>(kSupersetSize);
}

Point3 in_mirror(const Point3& point, HandSide side) {
  return side == HandSide::left ? Point3(-point.x(), point.y(), point.z()) : point;
}

bool HandTrack::agree_on_side(HandSide seen, double now_s) {
  const HandSide before = side();
  side_votes = std::clamp(side_votes + (seen == HandSide::right ? 1 : -1), -kMostSideVotes, kMostSideVotes);
  if (side() != seen) return false;
  if (before != seen) begin_anew(now_s);  // it was the other hand all the time
  return true;
}

void HandTrack::begin_anew(double now_s) {
  begun_s = now_s;
  pose.reset();
  smoother.reset();
  velocity.setZero();
  person = {};
}

void HandTrack::move_to(const SkeletonPose& next, double now_s) {
  const bool is_first = !pose;
  const double seconds = is_first ? kDefaultStepSeconds : now_s - seen_s;
  const Point3 next_middle = in_mirror(middle_of(next), side());
  before_ = {pose, middle, seen_s, agreed_s, agreed_turn, person};
  leapt_mm = is_first ? 0.0 : (next_middle - middle - shift_until(now_s)).norm();
  if (!is_first) {
    Eigen::Vector3d now = (next_middle - middle) / seconds;
    if (now.norm() > kFastestMmPerSecond) now *= kFastestMmPerSecond / now.norm();
    velocity += low_pass_share(kVelocityCutoffHz, seconds) * (now - velocity);
  }
  smoothed = smoother.smooth(next, seconds);
  middle = next_middle;
  pose = next;
  seen_s = now_s;
}

void HandTrack::take_back() {
  pose = before_.pose;
  middle = before_.middle;
  seen_s = before_.seen_s;
  agreed_s = before_.agreed_s;
  agreed_turn = before_.agreed_turn;
  person = before_.person;
  velocity.setZero();
  smoother.reset();
}

HandSkin HandTrack::skin_at(double now_s) const {
  if (!pose) return {};
  auto points = landmarks(adult_skeleton(), *pose);
  for (Point3& point : points) point = in_mirror(point, side()) + shift_until(now_s);
  return hand_capsules(points);
}

HandSkin HandTrack::forearm() const {
  const auto points = landmarks(adult_skeleton(), *pose);
  const Point3 wrist = in_mirror(points[static_cast<int>(Landmark::wrist)], side());
  const Point3 middle_mcp = in_mirror(points[static_cast<int>(Landmark::middle_mcp)], side());
  const Eigen::Vector3d palm = middle_mcp - wrist;
  return {{wrist, wrist - 2.0 * palm, 0.4 * palm.norm(), HandCapsule::kPalmCapsule, 0}};
}

}  // namespace knuckle
