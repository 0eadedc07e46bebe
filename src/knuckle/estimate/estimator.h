// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "knuckle/core/landmarks.h"
#include "knuckle/patch/hand_patch.h"
#include "knuckle/patch/patch_extractor.h"

namespace knuckle {

/// The joints that a method sees in a patch.
struct PatchPose {
  std::vector<PatchPoint> joints;         ///< one per landmark of the model's convention
  std::vector<float> confidence;          ///< one per joint in [0, 1], or empty
  std::optional<double> right_hand = {};  ///< how likely it is a right hand, [0, 1]; nothing: it cannot tell
  std::optional<double> hand = {};        ///< how likely it is a hand at all; nothing: it cannot tell
  int seen_by = 0;                        ///< of several networks, which one saw the joints
  int quarter_turns = 0;                  ///< how the patch was turned when they were seen
};

/// Infers the pose of a hand from its patch. Models are for right hands.
class Estimator {
 public:
  virtual ~Estimator() = default;

  /// What the model predicts.
  virtual Convention convention() const = 0;
  /// Makes patches as those that the model was trained on: all that it wants of them is said there.
  virtual const PatchExtractor& patches() const = 0;
  /// How often a hand is looked at, at least 1: each time but the first around the mean of the joints that
  /// were found (patches of the mode "cube" only).
  virtual int passes() const { return 1; }
  /// The mean confidence of its joints from which on a pose may be taken for that of a hand, [0, 1]; 0 where
  /// the confidences do not tell hands from other things.
  virtual double sure_confidence() const { return 0.0; }
  /// `patch` is made by patches(). Safe to call from many threads.
  virtual PatchPose estimate(const HandPatch& patch) const = 0;
  /// The pose that estimate() saw in the patch, with the method's last word on whether it is a hand at all,
  /// where it has one: it may cost as much as another look. Safe to call from many threads.
  virtual PatchPose judged(const HandPatch& /*patch*/, PatchPose seen) const { return seen; }
  /// The pose that estimate() saw in the patch, with what other looks at the same patch say of the side,
  /// where the method has any. Safe to call from many threads.
  virtual PatchPose sided(const HandPatch& /*patch*/, PatchPose seen) const { return seen; }
  /// The pose that estimate() saw in the patch, made surer by other looks at the same patch, where the method
  /// has any. Safe to call from many threads.
  virtual PatchPose ascertained(const HandPatch& /*patch*/, PatchPose seen) const { return seen; }
};

}  // namespace knuckle
