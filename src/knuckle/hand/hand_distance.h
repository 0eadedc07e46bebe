// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "knuckle/core/pose.h"

namespace knuckle {

/// The joints of a hand that shapes are compared by: the landmarks of `mediapipe21`, in its order (wrist;
/// thumb CMC, MCP, IP, tip; then MCP, PIP, DIP, tip of index to little).
inline constexpr int kHandJoints = 21;
using HandJoints = std::array<Point3, kHandJoints>;

/// Those of the 22 landmarks: all but the palm's centre.
HandJoints hand_joints(const std::array<Point3, kSupersetSize>& landmarks);

/// `hand` after the rotation, translation and scale that bring it nearest to `target` in the mean of squares
/// (Umeyama, "Least-squares estimation of transformation parameters between two point patterns", 1991).
HandJoints aligned_to(const HandJoints& target, const HandJoints& hand);

/// Mean distance of corresponding joints [mm].
double mean_distance_mm(const HandJoints& a, const HandJoints& b);

/// One hand of a set, and how far it is.
struct NearestHand {
  double distance_mm = 0.0;  ///< mean over the joints, after alignment
  std::int64_t index = -1;   ///< in the set
};

/// Many hand shapes, laid out for fast comparison with one: without place and size, turned to the axes of
/// their palms, eight beside one another.
class HandSet {
 public:
  static constexpr int kLanes = 8;
  /// One number of each of eight hands.
  using Lanes = Eigen::Array<float, kLanes, 1>;
  using LanePoint = std::array<Lanes, 3>;

  explicit HandSet(std::span<const HandJoints> hands);

  std::size_t size() const { return size_; }

  /// The hand with the least mean distance to `target` once it is aligned to it, as
  /// mean_distance_mm(target, aligned_to(target, hand)) in single precision; about 20 ns per hand.
  NearestHand nearest(const HandJoints& target) const;

 private:
  struct Block {
    std::array<LanePoint, kHandJoints> joints;
  };
  struct Target;

  static Lanes distances(const Block& block, const Target& target);

  std::size_t size_ = 0;
  std::vector<Block> blocks_;
};

}  // namespace knuckle
