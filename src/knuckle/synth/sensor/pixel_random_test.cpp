// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/pixel_random.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TEST(PixelRandom, AllNormalValuesTogetherAreNormal) {
  double sum = 0.0;
  double squares = 0.0;
  double fourth_powers = 0.0;
  int beyond_two = 0;
  for (int bits = 0; bits < 65536; ++bits) {
    const double x = normal_from_bits(static_cast<std::uint16_t>(bits));
    sum += x;
    squares += x * x;
    fourth_powers += x * x * x * x;
    beyond_two += std::abs(x) > 2.0 ? 1 : 0;
    EXPECT_GE(x, normal_from_bits(static_cast<std::uint16_t>(std::max(bits - 1, 0))));
  }
  EXPECT_NEAR(sum / 65536, 0.0, 1e-6);
  EXPECT_NEAR(squares / 65536, 1.0, 1e-3);
  EXPECT_NEAR(fourth_powers / 65536, 3.0, 0.02);
  EXPECT_NEAR(beyond_two / 65536.0, 0.0455, 1e-4);
}

TEST(PixelRandom, SeedUseAndPlaceEachChangeTheBits) {
  const auto bits = block_bits(7, PixelUse::range_noise, 3);
  EXPECT_EQ(bits, block_bits(7, PixelUse::range_noise, 3));
  EXPECT_NE(bits, block_bits(8, PixelUse::range_noise, 3));
  EXPECT_NE(bits, block_bits(7, PixelUse::hole, 3));
  EXPECT_NE(bits, block_bits(7, PixelUse::range_noise, 4));
  const auto words = pixel_words(7, PixelUse::flying, 3);
  EXPECT_EQ(words, pixel_words(7, PixelUse::flying, 3));
  EXPECT_NE(words, pixel_words(7, PixelUse::flying, 4));
  EXPECT_NE(words, pixel_words(7, PixelUse::infrared, 3));
}

TEST(PixelRandom, UniformNumbersStayBelowOne) {
  EXPECT_EQ(uniform_from_bits(0), 0.0f);
  EXPECT_LT(uniform_from_bits(0xffffffffu), 1.0f);
  EXPECT_NEAR(uniform_from_bits(0x80000000u), 0.5f, 1e-6f);
}

}  // namespace
}  // namespace knuckle
