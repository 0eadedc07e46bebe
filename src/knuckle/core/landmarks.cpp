// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/landmarks.h"

#include <algorithm>
#include <array>

#include "knuckle/core/error.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/core/suggestion.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

/// Where a landmark sits: on which digit, and how far along it from the wrist.
enum class Digit : std::uint8_t { none, thumb, index, middle, ring, little };

struct LandmarkRow {
  std::string_view name;
  Digit digit;
  int rank;
};

// In the order of the enumeration. Ranks along a digit: base joint 1, then outwards; NYU's "base" of a finger
// lies behind the PIP joint.
constexpr std::array kLandmarkRows = {
    LandmarkRow{"wrist", Digit::none, 0},
    LandmarkRow{"palm", Digit::none, 0},
    LandmarkRow{"thumb_cmc", Digit::thumb, 1},
    LandmarkRow{"thumb_mcp", Digit::thumb, 2},
    LandmarkRow{"thumb_ip", Digit::thumb, 3},
    LandmarkRow{"thumb_tip", Digit::thumb, 4},
    LandmarkRow{"index_mcp", Digit::index, 1},
    LandmarkRow{"index_pip", Digit::index, 2},
    LandmarkRow{"index_dip", Digit::index, 3},
    LandmarkRow{"index_tip", Digit::index, 4},
    LandmarkRow{"middle_mcp", Digit::middle, 1},
    LandmarkRow{"middle_pip", Digit::middle, 2},
    LandmarkRow{"middle_dip", Digit::middle, 3},
    LandmarkRow{"middle_tip", Digit::middle, 4},
    LandmarkRow{"ring_mcp", Digit::ring, 1},
    LandmarkRow{"ring_pip", Digit::ring, 2},
    LandmarkRow{"ring_dip", Digit::ring, 3},
    LandmarkRow{"ring_tip", Digit::ring, 4},
    LandmarkRow{"little_mcp", Digit::little, 1},
    LandmarkRow{"little_pip", Digit::little, 2},
    LandmarkRow{"little_dip", Digit::little, 3},
    LandmarkRow{"little_tip", Digit::little, 4},
    LandmarkRow{"icvl_thumb_root", Digit::thumb, 1},
    LandmarkRow{"icvl_thumb_mid", Digit::thumb, 2},
    LandmarkRow{"icvl_thumb_tip", Digit::thumb, 3},
    LandmarkRow{"icvl_index_root", Digit::index, 1},
    LandmarkRow{"icvl_index_mid", Digit::index, 2},
    LandmarkRow{"icvl_index_tip", Digit::index, 3},
    LandmarkRow{"icvl_middle_root", Digit::middle, 1},
    LandmarkRow{"icvl_middle_mid", Digit::middle, 2},
    LandmarkRow{"icvl_middle_tip", Digit::middle, 3},
    LandmarkRow{"icvl_ring_root", Digit::ring, 1},
    LandmarkRow{"icvl_ring_mid", Digit::ring, 2},
    LandmarkRow{"icvl_ring_tip", Digit::ring, 3},
    LandmarkRow{"icvl_little_root", Digit::little, 1},
    LandmarkRow{"icvl_little_mid", Digit::little, 2},
    LandmarkRow{"icvl_little_tip", Digit::little, 3},
    LandmarkRow{"nyu_little_base", Digit::little, 2},
    LandmarkRow{"nyu_ring_base", Digit::ring, 2},
    LandmarkRow{"nyu_middle_base", Digit::middle, 2},
    LandmarkRow{"nyu_index_base", Digit::index, 2},
    LandmarkRow{"nyu_thumb_mid", Digit::thumb, 3},
    LandmarkRow{"nyu_thumb_base", Digit::thumb, 2},
    LandmarkRow{"nyu_wrist_1", Digit::none, 0},
    LandmarkRow{"nyu_wrist_2", Digit::none, 0},
};

/// The row of one of one's own is that of the landmark that it lies near to, under its own name.
LandmarkRow row_of(Landmark landmark) {
  if (is_own(landmark)) {
    const LandmarkRow& near = kLandmarkRows[static_cast<std::size_t>(own_landmark_is_near(landmark))];
    return {name_of(landmark), near.digit, near.rank};
  }
  return kLandmarkRows[static_cast<std::size_t>(landmark)];
}

constexpr std::array<Landmark, kSupersetSize> all_of_superset() {
  std::array<Landmark, kSupersetSize> all{};
  for (int i = 0; i < kSupersetSize; ++i) all[i] = static_cast<Landmark>(i);
  return all;
}

using enum Landmark;

constexpr std::array kKnuckle22 = all_of_superset();
constexpr std::array kIcg20 = {
    palm,      thumb_mcp,  thumb_ip,   thumb_tip,  index_mcp,  index_pip,  index_dip,
    index_tip, middle_mcp, middle_pip, middle_dip, middle_tip, ring_mcp,   ring_pip,
    ring_dip,  ring_tip,   little_mcp, little_pip, little_dip, little_tip,
};
constexpr std::array kMediapipe21 = {
    wrist,     thumb_cmc, thumb_mcp,  thumb_ip,   thumb_tip,  index_mcp,  index_pip,
    index_dip, index_tip, middle_mcp, middle_pip, middle_dip, middle_tip, ring_mcp,
    ring_pip,  ring_dip,  ring_tip,   little_mcp, little_pip, little_dip, little_tip,
};
constexpr std::array kMsra21 = {
    wrist,      index_mcp,  index_pip,  index_dip, index_tip, middle_mcp, middle_pip,
    middle_dip, middle_tip, ring_mcp,   ring_pip,  ring_dip,  ring_tip,   little_mcp,
    little_pip, little_dip, little_tip, thumb_cmc, thumb_mcp, thumb_ip,   thumb_tip,
};
constexpr std::array kHands21 = {
    wrist,      thumb_cmc, index_mcp, middle_mcp, ring_mcp,   little_mcp, thumb_mcp,
    thumb_ip,   thumb_tip, index_pip, index_dip,  index_tip,  middle_pip, middle_dip,
    middle_tip, ring_pip,  ring_dip,  ring_tip,   little_pip, little_dip, little_tip,
};
constexpr std::array kIcvl16 = {
    palm,           icvl_thumb_root,  icvl_thumb_mid,  icvl_thumb_tip,  icvl_index_root, icvl_index_mid,
    icvl_index_tip, icvl_middle_root, icvl_middle_mid, icvl_middle_tip, icvl_ring_root,  icvl_ring_mid,
    icvl_ring_tip,  icvl_little_root, icvl_little_mid, icvl_little_tip,
};
constexpr std::array kNyu14 = {
    little_tip,     nyu_little_base, ring_tip,      nyu_ring_base,  middle_tip,  nyu_middle_base, index_tip,
    nyu_index_base, thumb_tip,       nyu_thumb_mid, nyu_thumb_base, nyu_wrist_1, nyu_wrist_2,     palm,
};

const std::array kConventions = {
    Convention{"knuckle22", kKnuckle22},
    Convention{"icg20", kIcg20},
    Convention{"mediapipe21", kMediapipe21},
    Convention{"msra21", kMsra21},
    Convention{"hands21", kHands21},
    Convention{"icvl16", kIcvl16},
    Convention{"nyu14", kNyu14},
};

bool holds(const Convention& convention, Landmark landmark) {
  return convention.index_of(landmark) >= 0;
}

/// Places of a digit's landmarks in the convention, from the hand outwards.
std::vector<int> digit_chain(const Convention& convention, Digit digit) {
  std::vector<int> chain;
  for (int i = 0; i < convention.size(); ++i) {
    if (row_of(convention.landmarks[i]).digit == digit) chain.push_back(i);
  }
  std::ranges::sort(chain, {}, [&](int i) { return row_of(convention.landmarks[i]).rank; });
  return chain;
}

}  // namespace

static_assert(kLandmarkRows.size() == kKnownLandmarks);

std::string_view name_of(Landmark landmark) {
  if (is_own(landmark)) return own_landmark_name(landmark);
  return kLandmarkRows[static_cast<std::size_t>(landmark)].name;
}

int Convention::index_of(Landmark landmark) const {
  const auto found = std::ranges::find(landmarks, landmark);
  return found == landmarks.end() ? -1 : static_cast<int>(found - landmarks.begin());
}

std::span<const Convention> conventions() {
  return kConventions;
}

const Convention& convention_from_name(std::string_view name) {
  const auto found = std::ranges::find(kConventions, name, &Convention::name);
  if (found != kConventions.end()) return *found;
  std::vector<std::string> known;
  for (const Convention& convention : kConventions) known.emplace_back(convention.name);
  for (const Convention& convention : own_conventions()) {
    if (convention.name == name) return registered_convention(name);
    known.emplace_back(convention.name);
  }
  fail("unknown convention '{}'{}; known are {}, and one's own by its file (NAME.toml)", name,
       suggestion(name, known), joined(known));
}

const Convention& superset_convention() {
  return kConventions.front();
}

ConventionMapping map_convention(const Convention& source, const Convention& target) {
  ConventionMapping mapping;
  for (const Landmark landmark : target.landmarks) {
    mapping.source_index.push_back(source.index_of(landmark));
    (holds(source, landmark) ? mapping.shared : mapping.missing).push_back(landmark);
  }
  for (const Landmark landmark : source.landmarks) {
    if (!holds(target, landmark)) mapping.dropped.push_back(landmark);
  }
  return mapping;
}

std::vector<Bone> skeleton_of(const Convention& convention) {
  const int wrist_index = convention.index_of(wrist);
  const int palm_index = convention.index_of(palm);
  const int root = wrist_index >= 0 ? wrist_index : palm_index;
  std::vector<Bone> bones;
  for (int i = 0; i < convention.size(); ++i) {
    if (row_of(convention.landmarks[i]).digit == Digit::none && i != root && root >= 0)
      bones.push_back({root, i});
  }
  for (const Digit digit : {Digit::thumb, Digit::index, Digit::middle, Digit::ring, Digit::little}) {
    int previous = root;
    for (const int i : digit_chain(convention, digit)) {
      if (previous >= 0) bones.push_back({previous, i});
      previous = i;
    }
  }
  return bones;
}

}  // namespace knuckle
