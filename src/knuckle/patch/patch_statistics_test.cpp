// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/patch_statistics.h"

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TEST(PatchMean, IsTheMeanOfEveryPixel) {
  PatchMean mean(5);
  Random random(1);
  std::vector<double> sums(25);
  for (int i = 0; i < 1000; ++i) {
    Image<float> patch(5, 5);
    for (std::size_t k = 0; k < patch.size(); ++k) {
      patch.data()[k] = static_cast<float>(random.normal());
      sums[k] += patch.data()[k];
    }
    mean.add(patch);
  }
  EXPECT_EQ(mean.count(), 1000);
  for (std::size_t k = 0; k < sums.size(); ++k) EXPECT_FLOAT_EQ(mean.mean().data()[k], float(sums[k] / 1000));
}

TEST(PatchMean, RefusesOtherSizesAndNoPatches) {
  PatchMean mean(5);
  EXPECT_THAT(testing::error_of([&] { (void)mean.mean(); }), ::testing::HasSubstr("no patch"));
  EXPECT_THAT(testing::error_of([&] { mean.add(Image<float>(5, 6)); }), ::testing::HasSubstr("5 x 6"));
  EXPECT_THAT(testing::error_of([] {
                check(PatchStatistics{1, {}, {}});
              }),
              ::testing::HasSubstr("patch statistics: size_px is 1, expected [2, 1024]"));
  EXPECT_THAT(testing::error_of([] {
                check(PatchStatistics{1025, {}, {}});
              }),
              ::testing::HasSubstr("size_px is 1025"));
}

}  // namespace
}  // namespace knuckle
