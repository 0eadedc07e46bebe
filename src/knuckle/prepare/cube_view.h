// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "knuckle/core/options.h"
#include "knuckle/core/pose.h"
#include "knuckle/core/random.h"
#include "knuckle/prepare/cube_samples.h"

namespace knuckle {

/// How a network's patch lies in a sample's crop.
struct CubeView {
  double centre_u = 0.0;  ///< of the patch, from the crop's centre [crop px]
  double centre_v = 0.0;
  double centre_d = 0.0;  ///< [halves of the crop cube's side]
  double rotation = 0.0;  ///< in the image plane, of the patch in the crop [rad]
  double scale = 1.0;     ///< of the cube's side: a larger cube shows a smaller hand
};

/// What happens to the pixels of a view.
struct PixelFaults {
  double noise_mm = 0.0;       ///< standard deviation of noise on the depths
  double missing_share = 0.0;  ///< of the pixels that are lost
  double erased_u = 0.0;       ///< centre [patch px] and radius of a disc that is not seen; none where 0
  double erased_v = 0.0;
  double erased_radius = 0.0;
};

/// A sample as the network sees it: joints move exactly as pixels do.
class CubeViewer {
 public:
  explicit CubeViewer(const CubeSamples& samples) : samples_(samples) {}

  /// Writes size_px x size_px depths: each the crop's nearest pixel. `random` serves noise and losses only.
  void view_pixels(const CubeSample& sample, const CubeView& view, const PixelFaults& faults, Random& random,
                   std::span<float> pixels) const;
  /// Writes J x 3 joints in patch coordinates.
  void view_joints(const CubeSample& sample, const CubeView& view, std::span<float> joints) const;

  /// The view around the mean of joints that are given in another view's patch coordinates (J x 3): the
  /// second look of an estimator.
  CubeView around_mean_joint(const CubeSample& sample, const CubeView& view,
                             std::span<const float> joints) const;
  /// The view around the mean of the sample's own joints that are known.
  CubeView around_true_joints(const CubeSample& sample) const;

  /// A joint of a view in the camera [mm]; exact where the camera is a pinhole without distortion.
  Point3 in_camera(const CubeSample& sample, const CubeView& view, std::span<const float, 3> joint) const;

 private:
  /// Crop pixels per patch pixel: a cube whose centre is farther than the crop's shows more of it.
  double crop_px_per_patch_px(const CubeSample& sample, const CubeView& view) const;

  const CubeSamples& samples_;
};

/// Random views and faults: what a network must be able to bear.
struct AugmentationOptions {
  double rotation_deg = 180.0;  ///< rotation in the image plane, uniform in +-, [0, 180] [degree]
  double shift_mm = 10.0;       ///< deviation of the cube's centre along each axis, [0, 100] [mm]
  double recentred_share =
      0.5;  ///< views around the mean of the true joints instead of the given centre, [0, 1]
  double scale_spread = 0.15;   ///< the cube's side differs by up to this part, [0, 0.5]
  double noise_mm = 2.0;        ///< largest deviation of noise on depths, [0, 50] [mm]
  double missing_share = 0.03;  ///< largest share of pixels that are lost, [0, 0.9]
  double erased_share = 0.3;    ///< views with a disc that is not seen, [0, 1]
  double erased_mm = 40.0;      ///< largest radius of the disc, [0, 200] [mm]
  double mirrored_share = 0.0;  ///< views in a mirror, for networks that tell sides, [0, 0.9]

  void visit(OptionVisitor& visitor);
};

/// A view of a sample, and what is wrong with its pixels.
struct RandomView {
  CubeView view;
  PixelFaults faults;
};

/// Draws a view for training.
RandomView random_view(const CubeSample& sample, const CubeSamples& samples,
                       const AugmentationOptions& options, Random& random);

}  // namespace knuckle
