// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>

namespace knuckle {

/// Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", 2011): four random words from
/// a counter and a key, without state.
std::array<std::uint32_t, 4> philox(const std::array<std::uint32_t, 4>& counter,
                                    const std::array<std::uint32_t, 2>& key);

/// A stream of random numbers, named by a seed and a stream number. Streams are independent: give every
/// frame, tree or node its own, and the result does not depend on threads. Same bits on every machine.
class Random {
 public:
  using result_type = std::uint32_t;

  explicit Random(std::uint64_t seed, std::uint64_t stream = 0);

  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }
  result_type operator()();

  /// Uniform in [0, 1), with 53 random bits.
  double uniform();
  /// Uniform in [low, high).
  double uniform(double low, double high);
  /// Uniform over 0, ..., count - 1 without bias; `count` is at least 1.
  std::uint32_t below(std::uint32_t count);
  /// Normal with mean 0 and standard deviation 1 (Box-Muller).
  double normal();

 private:
  std::array<std::uint32_t, 2> key_;
  std::uint64_t stream_;
  std::uint64_t block_ = 0;
  std::array<std::uint32_t, 4> words_{};
  int next_word_ = 4;
  double spare_normal_ = 0.0;
  bool has_spare_normal_ = false;
};

/// A seed derived from a seed and a number: use it to give a part of the work its own family of streams.
std::uint64_t derived_seed(std::uint64_t seed, std::uint64_t number);

}  // namespace knuckle
