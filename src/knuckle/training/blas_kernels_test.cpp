// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/blas_kernels.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TEST(BlasKernels, AreThoseOfTheProcessorWhereOpenBlasDoesNotKnowIt) {
  EXPECT_EQ(better_blas_kernels("Prescott", true, true), "SkylakeX");
  EXPECT_EQ(better_blas_kernels("Prescott", true, false), "Haswell");
  EXPECT_EQ(better_blas_kernels("Sandybridge", true, false), "Haswell");
}

TEST(BlasKernels, StayAsOpenBlasHasChosenThemElse) {
  EXPECT_EQ(better_blas_kernels("Prescott", false, false), "") << "an old processor";
  for (const char* const chosen :
       {"Haswell", "Zen", "SkylakeX", "Cooperlake", "SapphireRapids", "Neoversen1", ""})
    EXPECT_EQ(better_blas_kernels(chosen, true, true), "") << chosen;
}

}  // namespace
}  // namespace knuckle
