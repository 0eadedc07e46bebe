// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// A named point of the hand. The first 22 are Knuckle's superset: joints of the skeleton, the finger tips,
/// and the centre of the palm. The others belong to one data set each and coincide with none of the 22.
/// Values beyond the last one are landmarks of one's own (`own_landmark`).
enum class Landmark : std::uint16_t {
  wrist,
  palm,
  thumb_cmc,
  thumb_mcp,
  thumb_ip,
  thumb_tip,
  index_mcp,
  index_pip,
  index_dip,
  index_tip,
  middle_mcp,
  middle_pip,
  middle_dip,
  middle_tip,
  ring_mcp,
  ring_pip,
  ring_dip,
  ring_tip,
  little_mcp,
  little_pip,
  little_dip,
  little_tip,
  // ICVL: centres of bones, three a digit (root, mid, tip as its labels call them).
  icvl_thumb_root,
  icvl_thumb_mid,
  icvl_thumb_tip,
  icvl_index_root,
  icvl_index_mid,
  icvl_index_tip,
  icvl_middle_root,
  icvl_middle_mid,
  icvl_middle_tip,
  icvl_ring_root,
  icvl_ring_mid,
  icvl_ring_tip,
  icvl_little_root,
  icvl_little_mid,
  icvl_little_tip,
  // NYU: points of its hand model that lie between joints, and two at the wrist.
  nyu_little_base,
  nyu_ring_base,
  nyu_middle_base,
  nyu_index_base,
  nyu_thumb_mid,
  nyu_thumb_base,
  nyu_wrist_1,
  nyu_wrist_2,
};

/// Number of landmarks of the superset: `wrist` to `little_tip`.
inline constexpr int kSupersetSize = 22;

/// The landmark's name, for example "index_pip".
std::string_view name_of(Landmark landmark);

/// A named, ordered selection of landmarks: what a data set labels or a model predicts. Cheap to copy; the
/// landmarks live as long as the program.
struct Convention {
  std::string_view name;
  std::span<const Landmark> landmarks;

  int size() const { return static_cast<int>(landmarks.size()); }
  /// Position of `landmark`, -1 where the convention lacks it.
  int index_of(Landmark landmark) const;
  bool operator==(const Convention& other) const { return name == other.name; }
};

/// All conventions: knuckle22 (the superset in its own order), icg20, mediapipe21, msra21, hands21, icvl16,
/// nyu14.
std::span<const Convention> conventions();

/// The convention of that name: one of `conventions`, or one's own that was read from a file before
/// (`convention_from_file`). Throws an Error that lists the known ones.
const Convention& convention_from_name(std::string_view name);

/// knuckle22: all landmarks of the superset, in the order of the enumeration.
const Convention& superset_convention();

/// How the joints of one convention are found in another.
struct ConventionMapping {
  std::vector<int> source_index;  ///< for each landmark of the target its place in the source, or -1
  std::vector<Landmark> shared;   ///< in both, in the target's order
  std::vector<Landmark> dropped;  ///< in the source only
  std::vector<Landmark> missing;  ///< in the target only
};

/// Which landmarks the two share, and where each lies in the source.
ConventionMapping map_convention(const Convention& source, const Convention& target);

/// Two landmarks joined by a bone: what a drawing of the hand connects. Only pairs that the convention holds;
/// a gap (a landmark that it lacks) is bridged to the next one towards the wrist or palm.
struct Bone {
  int from;  ///< index into the convention, nearer to the wrist
  int to;    ///< index into the convention, nearer to the tip
};

/// The bones of a convention, from the wrist or palm outwards.
std::vector<Bone> skeleton_of(const Convention& convention);

}  // namespace knuckle
