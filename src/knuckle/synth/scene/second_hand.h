// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/core/transform.h"
#include "knuckle/hand/body_rig.h"
#include "knuckle/synth/pose/motion.h"

namespace knuckle {

/// Where a person's other hand is to the first.
enum class HandMeeting : std::uint8_t {
  near,      ///< beside it, 130 to 380 mm away
  crossed,   ///< before or behind it, as the camera sees them
  touching,  ///< their skin meets
};

/// Where a hand that goes to and fro is, beside its place [mm].
struct HandPath {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Vector3d reach = Eigen::Vector3d::Zero();  ///< from the middle to where it is at phase 0

  /// `phase`: of one way and back, [0, 1].
  Eigen::Vector3d shift(double phase) const;
};

/// The left hand of a person whose right hand is in the picture.
struct SecondHand {
  Posture posture;                              ///< of a right hand that is then reflected
  std::array<Point3, kSupersetSize> landmarks;  ///< in place [mm]
  RigidTransform camera_from_mirrored_body;     ///< takes the reflected body (x of the other sign) there
  HandPath path;                                ///< no way at all where it stands still

  /// The same hand somewhere on its path.
  SecondHand at(double phase) const;
};

/// The first hand of a scene, and where it will be.
struct FirstHand {
  PlacedPosture posture;
  std::array<Point3, kSupersetSize> landmarks;
  std::vector<std::array<Point3, kSupersetSize>>
      moments;  ///< of a second hand that passes by: kept clear of, too
};

/// A second hand where `meeting` says, in a pose of its own: of random arms the one that has to be moved
/// least, then moved there, so that its shoulder is near the person's. Hands do not run into one another.
/// Where `passes` it comes from aside, meets the first hand half of the way, and goes on to the other side;
/// one that touches comes from aside and goes back. Nothing where 4 random poses fail.
std::optional<SecondHand> sampled_second_hand(const BodyRig& rig, const FirstHand& first,
                                              const PostureOptions& options, HandMeeting meeting, bool passes,
                                              Random& random);

/// Its hand and arm in place: the first `vertex_count` vertices of the body. Their faces are inside out.
std::vector<Eigen::Vector3f> skin_of(const SecondHand& hand, const BodyRig& rig, std::size_t vertex_count,
                                     Skinning skinning);

}  // namespace knuckle
