// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "knuckle/core/frame.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// The 22 landmarks of a hand in camera coordinates [mm]; one that is not known is NaN.
using SupersetPoints = std::array<Point3, kSupersetSize>;

/// Where one landmark of a data set lies: on the way from one of the 22 to another, and at an offset from
/// there in the axes of the first one's bone.
struct DefinedLandmark {
  Landmark bone = Landmark::wrist;        ///< one of the 22
  Eigen::Vector3d offset{0.0, 0.0, 0.0};  ///< along the bone's axes (`bone_axes`) [palm lengths]
  std::optional<Landmark> towards = {};   ///< another of the 22
  double share = 0.0;                     ///< of the way from `bone` to `towards`, [-1, 2]
  /// The offset where the finger is folded back on itself (`finger_bend` 1); in between it changes with the
  /// bend. Nothing: the offset is the same however the finger is bent.
  std::optional<Eigen::Vector3d> bent = {};
};

/// Where the landmarks of a convention lie on the hand, as those who label it place them: data sets differ by
/// more than a centimetre. It is made of the 22 landmarks alone, so it applies to any pose.
struct LandmarkDefinition {
  Convention convention;
  std::vector<DefinedLandmark> landmarks;  ///< one per landmark of the convention

  /// The landmark itself where it is one of the 22; of a data set's own that of the 22 that it lies nearest
  /// to. All offsets are 0.
  static LandmarkDefinition plain(const Convention& convention);
  /// Reads what `as_toml` writes, and what people write: with a list `landmarks` it defines a convention of
  /// one's own (`convention_from_file`), in which landmarks of the 22 need no table. Throws an Error that
  /// names file, line and key where the file is wrong: an unknown convention or bone, a landmark that is
  /// missing, an offset that is not finite or beyond 2.
  static LandmarkDefinition load(const std::filesystem::path& path);
  std::string as_toml() const;

  /// The convention's landmarks on a hand [mm]; one whose bone is not known is NaN. Mirrored hands give
  /// mirrored landmarks. Throws nothing; safe to call from many threads.
  std::vector<Point3> on(const SupersetPoints& hand, HandSide side) const;
};

/// The convention's definition that comes with Knuckle, landmarks/NAME.toml; nothing where there is none.
/// Throws an Error where the file is wrong.
std::optional<LandmarkDefinition> shipped_definition(const Convention& convention);

/// The same where the convention has landmarks that are none of the 22; nothing otherwise.
std::optional<LandmarkDefinition> definition_of_own_landmarks(const Convention& convention);

/// The file that a user means: `text` where there is such a file, else landmarks/TEXT.toml of those that come
/// with Knuckle, else `text` itself, whose reader will say that it is missing.
std::filesystem::path definition_file(const std::filesystem::path& text);

/// The point of one of the 22 from which a landmark's offset counts [mm]; NaN where it is not known.
Point3 offset_origin(const SupersetPoints& hand, const DefinedLandmark& landmark);

/// How far the finger of one of the 22 is bent: the angle between its first and its last phalanx in parts of
/// 180 degrees, [0, 1]. Of wrist and palm that of the middle finger. NaN where it is not known.
double finger_bend(const SupersetPoints& hand, Landmark landmark);

/// From the wrist to the middle finger's MCP joint [mm]; NaN where one is not known.
double palm_length(const SupersetPoints& hand);

/// The axes of the bone at one of the 22 landmarks, as columns: along the bone to the finger tip, towards the
/// thumb's side (a thumb's own: away from the little finger's tip), and out of the back of the hand. Of
/// wrist, palm, the MCP joints and the thumb's CMC joint they are the palm's; farther out those of the
/// phalanx that begins there, at a tip of the one that ends there. Nothing where the landmarks that they are
/// made of are not known or lie on a line. A left hand's are those of the right hand in a mirror (so not
/// right-handed).
std::optional<Eigen::Matrix3d> bone_axes(const SupersetPoints& hand, HandSide side, Landmark landmark);

}  // namespace knuckle
