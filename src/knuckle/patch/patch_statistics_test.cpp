// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/patch_statistics.h"

#include <cmath>
#include <utility>

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

TEST(PatchStatistics, AreCheckedBeforeUse) {
  using ::testing::HasSubstr;
  const auto fault = [](int size_px, Image<float> mean, std::vector<float> whitening) {
    return testing::error_of([&] { check(PatchStatistics{size_px, std::move(mean), std::move(whitening)}); });
  };
  EXPECT_THAT(fault(1, {}, {}), HasSubstr("size_px is 1, expected [2, 1024]"));
  EXPECT_THAT(fault(1025, {}, {}), HasSubstr("size_px is 1025"));
  EXPECT_THAT(fault(4, Image<float>(4, 5), {}), HasSubstr("the mean patch is 4 x 5 pixels"));
  EXPECT_THAT(fault(4, Image<float>(4, 4, INFINITY), {}), HasSubstr("the mean patch"));
  EXPECT_THAT(fault(4, {}, std::vector<float>(255)), HasSubstr("has 255 values, expected 256"));
}

}  // namespace
}  // namespace knuckle
