// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/weight_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::string_view kOptions = "options";
constexpr std::string_view kWeights = "weights";
constexpr std::string_view kNorms = "norms";

/// Throws where the file has another number of numbers than the options ask for.
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

void check_numbers(const WeightArrays& weights, const std::string& path) {
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

void save_weights(const std::filesystem::path& path, const WeightFormat& format,
                  const std::string& options_toml, const WeightArrays& weights) {
  ModelWriter file(format.name, format.version);
  file.set(kOptions, options_toml);
  // As they are: deflate gains little on weights and costs time at each start.
  file.add<Half>(kWeights, {weights.halves().size()}, weights.halves(), ModelWriter::Storage::plain);
  if (!weights.singles().empty()) {
    file.add<float>(kNorms, {weights.singles().size()}, weights.singles(), ModelWriter::Storage::plain);
  }
  file.save(path);
}

WeightFile::WeightFile(ModelFile file, const WeightFormat& format) : file_(std::move(file)) {
  file_.require_format(format.name, format.version);
}

std::string WeightFile::options_toml() const {
  return file_.text(kOptions);
}

void WeightFile::require(const std::vector<NetworkArray>& arrays) const {
  const ArraySizes sizes = total_sizes(arrays);
  check_size(file_, kWeights, sizes.halves);
  if (sizes.singles > 0) check_size(file_, kNorms, sizes.singles);
}

void WeightFile::read(WeightArrays& weights) const {
  read_numbers(file_, kWeights, weights.halves());
  if (!weights.singles().empty()) read_numbers(file_, kNorms, weights.singles());
  check_numbers(weights, file_.origin());
}

}  // namespace knuckle
