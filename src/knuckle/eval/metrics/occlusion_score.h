// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "knuckle/core/frame.h"
#include "knuckle/core/statistics.h"
#include "knuckle/data/frame_record.h"
#include "knuckle/eval/metrics/true_hands.h"

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

/// Gathers the landmarks of found hands by what lies before them.
class OcclusionCount {
 public:
  /// `places`: of the truth's landmarks in the estimate's list, -1 where it lacks one. Nothing is counted
  /// where it is not known what hides the landmarks.
  void add(const TrueHand& truth, const HandRecord& estimate, std::span<const int> places);

  OcclusionScores scores() const;

 private:
  struct Sums {
    RunningMean error_mm;
    RunningMean within;
    RunningMean confidence;
  };
  std::array<Sums, kOccluderCount> sums_;
};

}  // namespace knuckle
