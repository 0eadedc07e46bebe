// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "knuckle/core/error.h"
#include "knuckle/storage/model_file.h"

namespace knuckle {
namespace {

constexpr std::string_view kOptions = "options";
constexpr std::string_view kWeights = "weights";
constexpr std::string_view kNorms = "norms";

/// Throws where the file has another number of numbers than the options ask for; before there is room for
/// them: a file may ask for more than there is.
void check_size(const ModelFile& file, std::string_view name, std::int64_t expected) {
  const std::vector<std::uint64_t>& shape = file.shape(name);
  if (shape.size() != 1 || shape[0] != static_cast<std::uint64_t>(expected)) {
    fail("{}: {} has {} numbers, expected the {} that its options ask for", file.origin(), name,
         shape.empty() ? 1 : shape[0], expected);
  }
}

template <class Number>
void read_numbers(const ModelFile& file, std::string_view name, std::span<Number> to) {
  std::ranges::copy(file.read<Number>(name).values, to.begin());
}

void check_numbers(const NetworkWeights& weights, const std::string& path) {
  for (const NetworkArray& array : weights.arrays()) {
    const bool is_half = array.precision == NetworkArray::Precision::half;
    const bool is_sound =
        is_half ? std::ranges::all_of(weights.halves(array.name), is_finite)
                : std::ranges::all_of(weights.singles(array.name), [](float x) { return std::isfinite(x); });
    if (!is_sound) fail("{}: a value of {} is not finite", path, array.name);
    const bool is_variance = array.name.ends_with(".running_var");
    if (is_variance && std::ranges::any_of(weights.singles(array.name), [](float x) { return x < 0.0f; })) {
      fail("{}: a variance of {} is negative", path, array.name);
    }
  }
}

}  // namespace

void save_network_weights(const std::filesystem::path& path, const NetworkWeights& weights) {
  ModelWriter file(kNetworkFormat, kNetworkVersion);
  file.set(kOptions, network_options_as_toml(weights.options()));
  // As they are: deflate gains little on weights and costs time at each start.
  file.add<Half>(kWeights, {weights.halves().size()}, weights.halves(), ModelWriter::Storage::plain);
  if (!weights.singles().empty()) {
    file.add<float>(kNorms, {weights.singles().size()}, weights.singles(), ModelWriter::Storage::plain);
  }
  file.save(path);
}

NetworkWeights load_network_weights(const std::filesystem::path& path) {
  return read_network_weights(ModelFile::open(path));
}

NetworkWeights read_network_weights(const ModelFile& file) {
  file.require_format(kNetworkFormat, kNetworkVersion);
  const NetworkOptions options = network_options_from_toml(file.text(kOptions), file.origin());
  const ArraySizes sizes = total_sizes(network_arrays(options));
  check_size(file, kWeights, sizes.halves);
  if (sizes.singles > 0) check_size(file, kNorms, sizes.singles);
  NetworkWeights weights(options);
  read_numbers(file, kWeights, weights.halves());
  if (sizes.singles > 0) read_numbers(file, kNorms, weights.singles());
  check_numbers(weights, file.origin());
  return weights;
}

}  // namespace knuckle
