// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "knuckle/core/pose.h"
#include "knuckle/hand/skeleton_fit.h"
#include "knuckle/pipeline/tracker_options.h"
#include "knuckle/track/hands_apart.h"
#include "knuckle/track/person_hand.h"
#include "knuckle/track/pose_smoother.h"

namespace knuckle {

/// Between frames that have no times [s].
inline constexpr double kDefaultStepSeconds = 1.0 / 30.0;

/// A point of a left hand as that of a right one, or back: x is negated. One of a right hand stays.
Point3 in_mirror(const Point3& point, HandSide side);

/// Mean of the landmarks of an adult's hand in a pose.
Point3 middle_of(const SkeletonPose& pose);

/// A hand that a Tracker follows, as a right one: a left one in a mirror. Times are in s. A value.
struct HandTrack {
  /// First seen at `now_s`, not fitted yet.
  HandTrack(int number, double now_s, const TrackerOptions& options)
      : id(number), begun_s(now_s), seen_s(now_s), agreed_s(now_s), smoother(options) {}

  bool is_seen_at(double now_s) const { return seen_s == now_s && pose.has_value(); }
  HandSide side() const { return side_votes < 0 ? HandSide::left : HandSide::right; }
  /// Counts an estimate's side. False where most estimates before saw the other one.
  bool agree_on_side(HandSide seen, double now_s);
  /// Moves on to the skeleton that was fitted at `now_s`.
  void move_to(const SkeletonPose& next, double now_s);
  /// Back to before it moved: what it moved to is another hand. It then is lost.
  void take_back();

  /// How far it has moved since it was seen, by its velocity [mm].
  Eigen::Vector3d shift_until(double now_s) const { return velocity * (now_s - seen_s); }
  /// Where its skin is then, in the camera; empty where it was never fitted.
  HandSkin skin_at(double now_s) const;
  /// About where its forearm begins, in the camera: it goes on behind the wrist, where that is not bent. Of a
  /// hand that was fitted.
  HandSkin forearm() const;

  int id;           ///< from 1 on
  double begun_s;   ///< when it was first seen, as a hand of its side
  double seen_s;    ///< when it was seen last
  double agreed_s;  ///< when an estimate last agreed with how fast hands turn, and how it was turned then
  Eigen::Matrix3d agreed_turn = Eigen::Matrix3d::Identity();
  int side_votes = 0;                     ///< above 0: right
  int trust = 0;                          ///< how often searches of all of the frame found it, up to a limit
  bool is_found_again = false;            ///< by the search under way
  double score = 0.0;                     ///< [0, 1]
  std::vector<float> confidence = {};     ///< one per landmark of the 22
  std::optional<SkeletonPose> pose = {};  ///< as it was fitted
  SkeletonPose smoothed = {};             ///< as it was smoothed
  PoseSmoother smoother;                  ///< what it was smoothed by
  Point3 middle = Point3::Zero();         ///< of its landmarks, in the camera [mm]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the middle [mm/s]
  double leapt_mm = 0.0;   ///< how far its last move ended from where its velocity would have taken it
  PersonHand person = {};  ///< what is known of its size and proportions

 private:
  /// What a move, and what was learned from it, changes.
  struct Place {
    std::optional<SkeletonPose> pose = {};
    Point3 middle = Point3::Zero();
    double seen_s = 0.0;
    double agreed_s = 0.0;
    Eigen::Matrix3d agreed_turn = Eigen::Matrix3d::Identity();
    PersonHand person = {};
  };

  void begin_anew(double now_s);

  Place before_ = {};
};

}  // namespace knuckle
