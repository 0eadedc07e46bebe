// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/estimate/estimator.h"

namespace knuckle {

/// How the surest of several estimators is chosen: keys of the `[estimator]` table.
struct SurestEstimatorOptions {
  std::vector<std::string> models =
      {};                ///< files of networks, the one that is asked first first; at least two
  int passes = 2;        ///< looks at each hand, [1, 5]
  double enough = 0.65;  ///< a pose of such a mean confidence is taken without asking the others, [0, 1]
  double lead = 0.05;    ///< by how much a later one has to be surer, [0, 1]
  /// Looks of the last one at a patch of which nobody is sure enough, [1, 4]: the second upside down, the
  /// third and fourth by a quarter turn.
  int views = 1;
  /// A pose that is kept is the mean of two looks, of which one is turned in the image plane by so much, in
  /// degrees, [-90, 90]; 0: a single look counts.
  double second_look_deg = 0.0;
  /// The file of a network that tells hands from other things, and is asked for nothing else; empty: the last
  /// of `models` is asked.
  std::string judge = {};

  void visit(OptionVisitor& visitor);
};

/// Several estimators for one hand: each knows what it has learned, and its confidences say what it has not.
/// The first, which is asked always, may know free hands very well; where it is not sure, the next is asked,
/// which knows hands among things, and the pose with the highest mean confidence counts. Where none is sure,
/// the last may be shown the patch turned in its plane (`views`): what it has learned of hands that point up
/// helps with those that point down; what is surely no hand is not turned. The errors of a network depend on
/// how the hand lies in the patch, so the mean of two looks is nearer to the truth than either
/// (`second_look_deg`). Whether it is a hand may be left to one that learned that above all (`judge`).
class SurestEstimator final : public Estimator {
 public:
  /// Throws an Error where there are fewer than two estimators, they differ in patches or convention, or one
  /// gives no confidences, and where an option is out of range. `judge` may be null.
  SurestEstimator(std::vector<std::unique_ptr<Estimator>> estimators, const SurestEstimatorOptions& options,
                  std::unique_ptr<Estimator> judge = nullptr);

  Convention convention() const override { return estimators_.front()->convention(); }
  const PatchExtractor& patches() const override { return estimators_.front()->patches(); }
  int passes() const override { return options_.passes; }
  double sure_confidence() const override;
  /// The side, and whether it is a hand, are what the surest says, or else the surest of those asked that can
  /// tell.
  PatchPose estimate(const HandPatch& patch) const override;
  /// Asks the judge, whose word counts; without one the last, unless somebody said already whether it is a
  /// hand. The pose stays.
  PatchPose judged(const HandPatch& patch, PatchPose seen) const override;
  /// The side is what the last one says of three looks at the patch, straight and turned by 30 degrees to
  /// both sides: the mean of the logarithms of their odds. The straight look alone where that is sure
  /// (0.995). Where it cannot tell, the side stays as it is.
  PatchPose sided(const HandPatch& patch, PatchPose seen) const override;
  /// The mean of the pose and of that which the same network sees in the patch turned by `second_look_deg`,
  /// each joint weighted by its confidence; confidences are plain means.
  PatchPose ascertained(const HandPatch& patch, PatchPose seen) const override;

 private:
  struct Choice {
    PatchPose pose;  ///< no joints: none so far
    double confidence = 0.0;
  };

  void consider(PatchPose other, Choice& choice) const;

  std::vector<std::unique_ptr<Estimator>> estimators_;
  std::unique_ptr<Estimator> judge_;  ///< null: the last of them judges too
  SurestEstimatorOptions options_;
};

}  // namespace knuckle
