// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/batch_norm.h"

#include <cmath>

#include <gmock/gmock.h>

#include "knuckle/net/layers/encoder_decoder_shape.h"

namespace knuckle {
namespace {

// y = (x - mean) / sqrt(variance + 1e-5) * weight + bias, as Ioffe and Szegedy 2015 and LibTorch's default
// have it.
TEST(FoldedNorm, IsTheDefinition) {
  WeightArrays weights(encoder_decoder_arrays({}));
  weights.halves("stem.norm.weight")[0] = half_of_float(2.0f);
  weights.halves("stem.norm.bias")[0] = half_of_float(0.5f);
  weights.singles("stem.norm.running_mean")[0] = 3.0f;
  weights.singles("stem.norm.running_var")[0] = 0.0f;
  weights.halves("stem.norm.weight")[1] = half_of_float(-1.0f);
  weights.singles("stem.norm.running_mean")[1] = -2.0f;
  weights.singles("stem.norm.running_var")[1] = 4.0f;
  const FoldedNorm norm = folded_norm(weights, "stem.norm");
  EXPECT_NEAR(norm.scales[0], 632.4555f, 1e-2f);  // 2 / sqrt(1e-5)
  EXPECT_NEAR(norm.shifts[0], 0.5f - 3.0f * 632.4555f, 5e-2f);
  EXPECT_NEAR(norm.scales[1], -0.5f, 1e-5f);
  EXPECT_NEAR(norm.shifts[1], -1.0f, 1e-5f);
  // Nothing is rounded to single precision yet.
  const double exact = 2.0 / std::sqrt(double{kNormEpsilon});
  EXPECT_NEAR(norm.scales[0], exact, 1e-12 * exact);
  EXPECT_NEAR(norm.shifts[0], 0.5 - 3.0 * exact, 1e-12 * exact);
}

}  // namespace
}  // namespace knuckle
