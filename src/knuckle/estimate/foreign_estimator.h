// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/estimate/estimator.h"
#include "knuckle/net/onnx_network.h"

namespace knuckle {

/// What somebody else's network wants and gives: keys of the `[estimator]` table beside `convention`, where
/// the file is not of `knuckle export` (docs/onnx.md). The patch's size is that of the file's input.
struct ForeignNetworkOptions {
  std::string patch = "cube";  ///< cube: a metric cube around the hand | hand: the segmented hand, normalised
  double cube_mm = 250.0;      ///< side of the cube, [10, 2000] [mm]
  double near_value =
      -1.0;  ///< of a pixel at the cube's near end (of a hand: 3 deviations nearer than its mean)
  double far_value = 1.0;         ///< of one at the far end, and of what is no hand
  std::string gives = "uvd";      ///< uvd | xyz | heat_maps
  std::string landmarks_output;   ///< name of the output that gives them; needed where there are several
  std::string confidence_output;  ///< name of the output that gives a number in [0, 1] per landmark, or empty
  std::vector<std::string> order{};  ///< landmarks in the order in which the network gives them; empty: the
                                     ///< convention's
  double first_pixel = -1.0;         ///< uvd: what u and v are in the patch's first column and row
  double last_pixel = 1.0;           ///< uvd: what they are in the last ones
  double near_depth = -1.0;          ///< uvd: what d is where a pixel has near_value
  double far_depth = 1.0;            ///< uvd: what d is where a pixel has far_value
  double xyz_mm = 1.0;               ///< xyz: millimetres per unit, from the patch's centre, (0, 10000]
  std::string axes = "right_down_far";  ///< xyz: | right_up_far | right_up_near
  std::string peak = "gaussian";        ///< heat_maps: gaussian | mean_shift

  void visit(OptionVisitor& visitor);
};

/// Those of a network that sees such a patch and says nothing else: its values and depths are as they are.
ForeignNetworkOptions foreign_defaults(const std::string& patch);

/// Pose by a network that somebody else has made.
class ForeignEstimator final : public Estimator {
 public:
  /// Looks at each hand `passes` times. Throws an Error that names the file where its input is no square
  /// patch of one channel, or its outputs do not fit what the options say of them, and where an option is out
  /// of range or contradicts another.
  ForeignEstimator(OnnxNetwork file, const Convention& convention, ForeignNetworkOptions options, int passes);

  Convention convention() const override { return convention_; }
  const PatchExtractor& patches() const override { return patches_; }
  int passes() const override { return passes_; }
  /// Throws an Error where the patch has another size or the network gives a number that is not finite.
  PatchPose estimate(const HandPatch& patch) const override;

 private:
  int output_for_landmarks() const;
  void check_landmarks_output();
  void find_places();
  std::vector<float> input_of(const HandPatch& patch) const;
  std::vector<PatchPoint> joints_in(const std::vector<float>& numbers, const HandPatch& patch) const;
  PatchPose peaks_in(const std::vector<float>& maps, const HandPatch& patch) const;
  PatchPoint point_of(const Point3& given, const HandPatch& patch) const;

  OnnxNetwork file_;
  Convention convention_;
  ForeignNetworkOptions options_;
  int passes_;
  PatchExtractor patches_;
  std::size_t landmarks_ = 0;        // output
  int confidence_ = -1;              // output
  std::vector<std::size_t> places_;  // of each of the convention's landmarks in what the network gives
  std::size_t given_ = 0;            // landmarks that the network gives
  bool is_planar_ = false;           // all u, then all v, then all d
  int map_cells_ = 0;                // along a side of a heat map
};

}  // namespace knuckle
