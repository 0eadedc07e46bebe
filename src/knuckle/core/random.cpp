// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/random.h"

#include <cmath>
#include <numbers>

#include "knuckle/core/portable_math.h"

namespace knuckle {
namespace {

struct HighLow {
  std::uint32_t high;
  std::uint32_t low;
};

HighLow multiply(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t product = std::uint64_t{a} * b;
  return {static_cast<std::uint32_t>(product >> 32), static_cast<std::uint32_t>(product)};
}

}  // namespace

std::array<std::uint32_t, 4> philox(const std::array<std::uint32_t, 4>& counter,
                                    const std::array<std::uint32_t, 2>& key) {
  constexpr std::uint32_t kMultiplier0 = 0xD2511F53;
  constexpr std::uint32_t kMultiplier1 = 0xCD9E8D57;
  constexpr std::uint32_t kWeyl0 = 0x9E3779B9;
  constexpr std::uint32_t kWeyl1 = 0xBB67AE85;
  constexpr int kRounds = 10;
  auto [c0, c1, c2, c3] = counter;
  auto [k0, k1] = key;
  for (int round = 0; round < kRounds; ++round) {
    const HighLow product0 = multiply(kMultiplier0, c0);
    const HighLow product1 = multiply(kMultiplier1, c2);
    c0 = product1.high ^ c1 ^ k0;
    c1 = product1.low;
    c2 = product0.high ^ c3 ^ k1;
    c3 = product0.low;
    k0 += kWeyl0;
    k1 += kWeyl1;
  }
  return {c0, c1, c2, c3};
}

Random::Random(std::uint64_t seed, std::uint64_t stream)
    : key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}, stream_(stream) {}

Random::result_type Random::operator()() {
  if (next_word_ == 4) {
    words_ = philox({static_cast<std::uint32_t>(block_), static_cast<std::uint32_t>(block_ >> 32),
                     static_cast<std::uint32_t>(stream_), static_cast<std::uint32_t>(stream_ >> 32)},
                    key_);
    ++block_;
    next_word_ = 0;
  }
  return words_[next_word_++];
}

double Random::uniform() {
  const std::uint64_t high = (*this)();
  const std::uint64_t low = (*this)();
  return static_cast<double>((high << 32 | low) >> 11) * 0x1.0p-53;
}

double Random::uniform(double low, double high) {
  return low + (high - low) * uniform();
}

std::uint32_t Random::below(std::uint32_t count) {
  // Lemire 2019, "Fast random integer generation in an interval": a rejected word keeps the answer without
  // bias.
  const std::uint32_t threshold = -count % count;
  while (true) {
    const HighLow product = multiply((*this)(), count);
    if (product.low >= threshold) return product.high;
  }
}

double Random::normal() {
  if (has_spare_normal_) {
    has_spare_normal_ = false;
    return spare_normal_;
  }
  const double radius = std::sqrt(-2.0 * portable_log(1.0 - uniform()));
  const double angle = 2.0 * std::numbers::pi * uniform();
  spare_normal_ = radius * portable_sin(angle);
  has_spare_normal_ = true;
  return radius * portable_cos(angle);
}

std::uint64_t derived_seed(std::uint64_t seed, std::uint64_t number) {
  // A counter word that no stream of `Random` uses for its own blocks in practice.
  constexpr std::uint32_t kDerivation = 0xFFFFFFFF;
  const auto words = philox({static_cast<std::uint32_t>(number), static_cast<std::uint32_t>(number >> 32),
                             kDerivation, kDerivation},
                            {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
  return std::uint64_t{words[1]} << 32 | words[0];
}

}  // namespace knuckle
