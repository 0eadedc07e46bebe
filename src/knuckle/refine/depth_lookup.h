// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/options.h"
#include "knuckle/refine/refiner.h"

namespace knuckle {

/// Options of `DepthLookup`.
struct DepthLookupOptions {
  double surface_offset_mm =
      0.0;  ///< How far a joint lies behind the skin above it, [0, 50] [mm]; the paper has none

  void visit(OptionVisitor& visitor);
};

/// Takes each joint's depth from the depth map at its place in the image (Riegler et al. 2015, section 3,
/// postprocessing), for methods that infer no depth themselves.
///
/// The pixel is the nearest one to (u, v). Where it lies outside of the image or of the hand's mask, or has
/// no measurement, it is background: the joint gets the median of the other joints' looked-up depths (the
/// mean of the two in the middle of an even number). Where no joint lies on the hand, the pose comes back
/// unchanged. u and v never change; a joint without them stays missing.
class DepthLookup final : public Refiner {
 public:
  explicit DepthLookup(const DepthLookupOptions& options);
  RefinedHand refine(const Frame& frame, const HandRegion& hand, HandPose pose) const override;

 private:
  DepthLookupOptions options_;
};

}  // namespace knuckle
