// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "knuckle/core/frame.h"

namespace knuckle {

/// Number of things that an Occluder names, `none` among them.
inline constexpr std::size_t kOccluderCount = 6;

/// The occluder's name in files: none, own_hand, other_hand, person, object, border.
std::string_view name_of(Occluder occluder);

/// How well the landmarks are found that the same kind of thing lies before.
struct OcclusionScore {
  std::int64_t joints = 0;
  double mean_3d_mm = kNaN;  ///< NaN, as the others, where there is no joint
  double within = kNaN;      ///< the share of them within kReliableMm of the truth, [0, 1]
  double confidence = kNaN;  ///< their mean confidence, [0, 1]; NaN where the method gives none
};

/// One per Occluder, in its order: what is visible comes first.
using OcclusionScores = std::array<OcclusionScore, kOccluderCount>;

/// All that is not visible, together.
OcclusionScore hidden_of(const OcclusionScores& scores);

}  // namespace knuckle
