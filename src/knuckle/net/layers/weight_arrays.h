// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "knuckle/net/layers/half.h"

namespace knuckle {

/// One of the arrays that a network consists of: weights and biases in half precision, statistics of batch
/// norms, whose variances may be tiny, in single.
struct NetworkArray {
  enum class Precision { half, single };
  std::string name;  ///< the parameter's (or buffer's) in LibTorch
  std::vector<int> shape;
  Precision precision;

  std::int64_t count() const;
};

/// Adds the arrays of a batch norm.
void add_norm(std::vector<NetworkArray>& arrays, const std::string& name, int channels);

/// How many numbers they have in all.
struct ArraySizes {
  std::int64_t halves = 0;
  std::int64_t singles = 0;
};
/// The sums over these arrays.
ArraySizes total_sizes(const std::vector<NetworkArray>& arrays);

/// All numbers of a network, array by array.
class WeightArrays {
 public:
  /// All zero.
  explicit WeightArrays(std::vector<NetworkArray> arrays);

  const std::vector<NetworkArray>& arrays() const { return arrays_; }

  /// Of all arrays, one after another.
  std::span<Half> halves() { return halves_; }
  std::span<const Half> halves() const { return halves_; }
  std::span<float> singles() { return singles_; }
  std::span<const float> singles() const { return singles_; }

  /// Of one array. The name is one of the architecture's.
  std::span<Half> halves(const std::string& name);
  std::span<const Half> halves(const std::string& name) const;
  std::span<float> singles(const std::string& name);
  std::span<const float> singles(const std::string& name) const;
  /// The array of halves in single precision.
  std::vector<float> floats(const std::string& name) const;

  /// Numbers of a network that has learned nothing: weights are uniform with the deviation that keeps
  /// activations alike from layer to layer (He et al. 2015), those of the last layer with 0.01; norms change
  /// nothing. They depend on `seed` alone.
  void fill_randomly(std::uint64_t seed);

 private:
  struct Place {
    std::size_t first;
    std::size_t count;
  };

  std::vector<NetworkArray> arrays_;
  std::map<std::string, Place> places_;
  std::vector<Half> halves_;
  std::vector<float> singles_;
};

}  // namespace knuckle
