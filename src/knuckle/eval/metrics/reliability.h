// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "knuckle/core/landmarks.h"
#include "knuckle/data/frame_record.h"
#include "knuckle/eval/metrics/true_hands.h"

namespace knuckle {

/// Joints of about the same confidence.
struct ReliabilityBin {
  std::int64_t joints = 0;
  double confidence = kNaN;  ///< their mean, [0, 1]; NaN where there is no joint
  double within = kNaN;      ///< the share of them that lies within kReliableMm of the truth, [0, 1]
};

inline constexpr int kReliabilityBins = 10;  ///< of equal width, from 0 to 1
inline constexpr double kReliableMm = 20.0;  ///< "of joints with confidence c the share within this is c"

/// How far confidences mean what they say.
struct Reliability {
  std::array<ReliabilityBin, kReliabilityBins> bins;
  std::int64_t joints = 0;  ///< in all bins; 0 where the method gives no confidences
  /// The mean distance between confidence and share, each bin weighed by its joints, [0, 1]: the expected
  /// calibration error (Naeini, Cooper and Hauskrecht 2015). NaN where there is no joint.
  double error = kNaN;
};

/// Compares each estimated hand with the true hand of its frame that is nearest, however far that is (a joint
/// in a wrong place counts as not within), in the landmarks that both know. Frames without a true hand are
/// passed over, and so are hands that were taken for the other side's: how many is another question. `truth`
/// and `records` have the same number of frames.
Reliability reliability_of(const Convention& convention, std::span<const TrueHands> truth,
                           std::span<const FrameRecord> records);

}  // namespace knuckle
