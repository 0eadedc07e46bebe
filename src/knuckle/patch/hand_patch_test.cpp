// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/hand_patch.h"

#include <gtest/gtest.h>

#include "knuckle/core/random.h"
#include "knuckle/patch/patch_extractor.h"

namespace knuckle {
namespace {

TEST(PatchGeometry, MapsFromImageToPatchAndBack) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Box box{static_cast<int>(random.below(600)) - 20, static_cast<int>(random.below(450)) - 20,
                  1 + static_cast<int>(random.below(300)), 1 + static_cast<int>(random.below(300))};
    PatchGeometry geometry = patch_geometry(box, 2 + static_cast<int>(random.below(200)));
    geometry.mean_depth_mm = random.uniform(200, 2000);
    geometry.depth_deviation_mm = random.uniform(1, 60);
    for (double v = -50; v < 530; v += 37.3) {
      for (double u = -50; u < 690; u += 41.7) {
        const ImagePoint point{u, v, random.uniform(200, 2000)};
        const ImagePoint back = geometry.to_image(geometry.to_patch(point));
        EXPECT_NEAR(back.u, point.u, 1e-9);
        EXPECT_NEAR(back.v, point.v, 1e-9);
        EXPECT_NEAR(back.depth_mm, point.depth_mm, 1e-9);
      }
    }
  }
}

TEST(PatchGeometry, PutsTheFirstAndTheLastPixelAtMinusOneAndOne) {
  // A box as large as the patch: patch pixels are image pixels.
  const PatchGeometry geometry = patch_geometry(Box{100, 50, 96, 96}, 96);
  EXPECT_NEAR(geometry.to_patch({100, 50, 0}).u, -1.0, 1e-12);
  EXPECT_NEAR(geometry.to_patch({100, 50, 0}).v, -1.0, 1e-12);
  EXPECT_NEAR(geometry.to_patch({195, 145, 0}).u, 1.0, 1e-12);
  EXPECT_NEAR(geometry.to_image({1, 1, 0}).v, 145.0, 1e-12);
}

TEST(PatchGeometry, KeepsTheAspectAndCentresTheBox) {
  const PatchGeometry geometry = patch_geometry(Box{10, 20, 40, 80}, 20);
  EXPECT_EQ(geometry.image_px_per_patch_px, 4.0);
  const PatchPoint centre = geometry.to_patch({29.5, 59.5, 0});
  EXPECT_NEAR(centre.u, 0.0, 1e-12);
  EXPECT_NEAR(centre.v, 0.0, 1e-12);
  const PatchPoint a = geometry.to_patch({0, 0, 0});
  const PatchPoint b = geometry.to_patch({10, 10, 0});
  EXPECT_NEAR(b.u - a.u, b.v - a.v, 1e-12);
}

TEST(PatchGeometry, KeepsMissingPointsMissing) {
  const PatchGeometry geometry = patch_geometry(Box{0, 0, 10, 10}, 8);
  EXPECT_TRUE(std::isnan(geometry.to_patch(ImagePoint{}).u));
  EXPECT_TRUE(geometry.to_image(PatchPoint{}).is_missing());
}

}  // namespace
}  // namespace knuckle
