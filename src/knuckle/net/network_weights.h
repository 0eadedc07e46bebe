// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "knuckle/net/half.h"
#include "knuckle/net/network_options.h"

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

/// Adds the four arrays of a batch norm.
void add_norm(std::vector<NetworkArray>& arrays, const std::string& name, int channels);

/// All arrays of an architecture, in the order in which they are stored.
std::vector<NetworkArray> network_arrays(const NetworkOptions& options);

/// How many numbers they have in all.
struct ArraySizes {
  std::int64_t halves = 0;
  std::int64_t singles = 0;
};
/// The sums over these arrays.
ArraySizes total_sizes(const std::vector<NetworkArray>& arrays);

/// A network and all its numbers.
class NetworkWeights {
 public:
  /// All zero.
  explicit NetworkWeights(NetworkOptions options);

  const NetworkOptions& options() const { return options_; }
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

 private:
  struct Place {
    std::size_t first;
    std::size_t count;
  };

  NetworkOptions options_;
  std::vector<NetworkArray> arrays_;
  std::map<std::string, Place> places_;
  std::vector<Half> halves_;
  std::vector<float> singles_;
};

/// Weights of a network that has learned nothing: uniform with the deviation that keeps activations alike
/// from layer to layer (He et al. 2015), those of the last layer with 0.01. They depend on `seed` alone.
/// Throws an Error where an option is out of range.
NetworkWeights random_weights(const NetworkOptions& options, std::uint64_t seed);

}  // namespace knuckle
