// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_file.h"

#include "knuckle/net/archive.h"

namespace knuckle {
namespace {

constexpr std::string_view kFormat = "knuckle-network";
constexpr int kVersion = 1;

std::vector<torch::Tensor> in_half_precision(const std::vector<torch::Tensor>& tensors) {
  std::vector<torch::Tensor> halves;
  for (const torch::Tensor& tensor : tensors) {
    halves.push_back(tensor.is_floating_point() ? tensor.detach().to(torch::kHalf) : tensor);
  }
  return halves;
}

}  // namespace

void save_network(const std::filesystem::path& path, const NetworkOptions& options,
                  const NetworkModule& network) {
  ArchiveWriter archive(kFormat, kVersion);
  archive.write("options", network_options_as_toml(options));
  archive.write("parameters", in_half_precision(network.parameters()));
  archive.write("buffers", network.buffers());  // few, and variances may be tiny
  archive.save(path);
}

LoadedNetwork load_network(const std::filesystem::path& path) {
  ArchiveReader archive(path, kFormat, kVersion);
  LoadedNetwork loaded;
  loaded.options = network_options_from_toml(archive.text("options"), path.string());
  loaded.network = with_clear_errors(path.string(), [&] { return make_network(loaded.options, 0); });
  archive.copy_into("parameters", loaded.network->parameters());
  archive.copy_into("buffers", loaded.network->buffers());
  loaded.network->eval();
  return loaded;
}

}  // namespace knuckle
