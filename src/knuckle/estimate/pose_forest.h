// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/estimate/estimator.h"
#include "knuckle/forest/regression_forest.h"

namespace knuckle {

/// What a unit of d (a standard deviation of the hand's depth) counts against a unit of u or v (half the
/// patch). A hand has a deviation of some 25 mm, half a patch some 100 mm.
inline constexpr double kDepthWeight = 0.25;
inline constexpr int kTargetsPerLandmark = 3;  ///< What a leaf holds of each landmark: u, v, d.

/// A pose forest with all that is needed to use it. Its features are the pixels of a patch, row by row; its
/// targets are u, v, d of the convention's first landmark, then of the second, ... in patch coordinates.
struct PoseForestModel {
  Convention convention;
  PatchStatistics statistics;  ///< without whitening
  RegressionForest forest;
};

/// Writes the model as a file (storage/model_file.h) of format "knuckle-forest", version 2; it appears only
/// when whole.
void save_pose_forest(const std::filesystem::path& path, const PoseForestModel& model);
/// The same in less room: leaves in steps of `leaf_step` (above 0; in units of u and v, half the patch) along
/// their principal components, see LeafCoding.
void save_pose_forest(const std::filesystem::path& path, const PoseForestModel& model, float leaf_step);

/// Reads it back. Throws an Error that names the file where it is missing, cut short, foreign, of another
/// version or kind, or where its parts do not fit together or are not finite.
PoseForestModel load_pose_forest(const std::filesystem::path& path);
/// The same of a file that is open.
PoseForestModel read_pose_forest(const ModelFile& file);

/// The model with at most `most_leaves` leaves (or one per tree): smaller, and a little less accurate. A unit
/// of d counts kDepthWeight against one of u or v, as it does in training by default.
PoseForestModel pruned(const PoseForestModel& model, std::size_t most_leaves);

/// Pose by a regression forest (Riegler et al. 2015, equation 3): the mean of the leaves that the patch
/// reaches.
///
/// The confidence of a joint says how well the trees agree on its place: exp(-s / 0.1), where s is the
/// standard deviation of (u, v) over the trees (root mean square of both, 0.1 = 5% of the patch). A single
/// tree always agrees with itself, so a forest of one gives none.
class PoseForestEstimator final : public Estimator {
 public:
  explicit PoseForestEstimator(PoseForestModel model);

  Convention convention() const override { return model_.convention; }
  const PatchExtractor& patches() const override { return patches_; }
  /// Throws an Error where the patch has another size or a pixel is not finite.
  PatchPose estimate(const HandPatch& patch) const override;

 private:
  PoseForestModel model_;
  PatchExtractor patches_;
};

}  // namespace knuckle
