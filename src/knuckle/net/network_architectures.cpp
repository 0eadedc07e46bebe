// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_architectures.h"

#include <array>

#include "knuckle/core/error.h"
#include "knuckle/core/named_table.h"
#include "knuckle/net/dense_architecture.h"
#include "knuckle/net/dense_inference.h"
#include "knuckle/net/paper_architecture.h"
#include "knuckle/net/paper_inference.h"

namespace knuckle {
namespace {

constexpr int kSmallestPaperPatch = 32;  // on which the smallest bank still has a pixel left

template <class Inference>
std::unique_ptr<NetworkInference> make_inference(const NetworkWeights& weights) {
  return std::make_unique<Inference>(weights);
}

constexpr NetworkArchitecture dense_network() {
  return {"dense", kNetworkStride,
          [](NetworkOptions& options, OptionVisitor& visitor) { options.dense.visit(visitor); }, dense_arrays,
          make_inference<DenseInference>};
}

constexpr NetworkArchitecture paper_network(std::string_view name) {
  return {name, kSmallestPaperPatch,
          [](NetworkOptions& options, OptionVisitor& visitor) { options.paper.visit(visitor); }, paper_arrays,
          make_inference<PaperInference>};
}

constexpr std::array kArchitectures{
    dense_network(),
    paper_network("heatmap2d"),
    paper_network("heatmap25d"),
    paper_network("regression"),
    paper_network("pca"),
    paper_network("autoencoder"),
};

constexpr auto kNames = names_of(kArchitectures);

}  // namespace

std::span<const std::string_view> network_architectures() {
  return kNames;
}

const NetworkArchitecture& architecture_of(const NetworkOptions& options) {
  const NetworkArchitecture* const row = row_named(kArchitectures, options.architecture);
  if (row == nullptr) fail("{}", unknown_name("network", options.architecture, kNames));
  return *row;
}

}  // namespace knuckle
