// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "knuckle/core/error.h"
#include "knuckle/storage/zip_reader.h"

namespace knuckle {
namespace {

constexpr std::size_t kLongestHeader = 1 << 20;  // that of a network of any options is shorter [bytes]
constexpr std::string_view kOptionsMark = "options\n";
constexpr std::string_view kFolder = "/data/";

std::string line_of(const NetworkArray& array) {
  const bool is_half = array.precision == NetworkArray::Precision::half;
  return fmt::format("{} {} {}\n", is_half ? "half" : "single", array.name, fmt::join(array.shape, " "));
}

std::string array_lines(const NetworkOptions& options) {
  std::string lines;
  for (const NetworkArray& array : network_arrays(options)) lines += line_of(array);
  return lines;
}

/// The number N of a record NAME/data/N; none for other records.
std::optional<int> tensor_number(const std::string& record) {
  const std::size_t folder = record.find(kFolder);
  if (folder == std::string::npos) return std::nullopt;
  const char* const first = record.data() + folder + kFolder.size();
  const char* const end = record.data() + record.size();
  int number = 0;
  const auto [stop, fault] = std::from_chars(first, end, number);
  if (first == end || stop != end || fault != std::errc{}) return std::nullopt;
  return number;
}

/// The records of tensors, in the order of their numbers.
std::vector<ZipReader::Record> tensors_of(const ZipReader& archive) {
  std::vector<ZipReader::Record> tensors;
  for (const ZipReader::Record& record : archive.records()) {
    if (tensor_number(record.name)) tensors.push_back(record);
  }
  std::ranges::sort(tensors, {}, [](const ZipReader::Record& record) { return *tensor_number(record.name); });
  return tensors;
}

/// Says what a file without a header is. A version before this one and a training's checkpoint have the
/// format's name in the archive's own list of contents.
[[noreturn]] void fail_without_header(const std::string& path, const ZipReader& archive) {
  for (const ZipReader::Record& record : archive.records()) {
    if (!record.name.ends_with("/data.pkl")) continue;
    const std::string contents = archive.read_start(record, kLongestHeader);
    if (contents.find("knuckle-network-checkpoint") != std::string::npos) {
      fail("{}: a training's checkpoint, expected the network beside it", path);
    }
    if (contents.find(kNetworkFormat) != std::string::npos) {
      fail("{}: version 1 of the format {}, expected {}: train it anew (or go on from its checkpoint)", path,
           kNetworkFormat, kNetworkVersion);
    }
    fail("{}: a LibTorch archive, but none of the format {}", path, kNetworkFormat);
  }
  fail("{}: no {} file, or cut short: it is no LibTorch archive that is whole", path, kNetworkFormat);
}

/// Takes `start` from the front of a text; false where it does not begin so.
bool take(std::string_view& text, std::string_view start) {
  if (!text.starts_with(start)) return false;
  text.remove_prefix(start.size());
  return true;
}

/// The options of a header after its first line, whose arrays must be theirs.
NetworkOptions options_of(std::string_view header, const std::string& path) {
  const std::size_t line_end = header.find('\n');
  if (line_end == std::string_view::npos || !take(header, "version ")) {
    fail("{}: damaged: its header has no version", path);
  }
  const std::string_view version = header.substr(0, header.find('\n'));
  if (version != std::to_string(kNetworkVersion)) {
    fail("{}: version {} of the format {}, expected {}", path, version, kNetworkFormat, kNetworkVersion);
  }
  header.remove_prefix(version.size() + 1);
  const std::size_t mark = header.find(kOptionsMark);
  if (mark == std::string_view::npos) fail("{}: options is missing", path);
  NetworkOptions options = network_options_from_toml(header.substr(mark + kOptionsMark.size()), path);
  if (header.substr(0, mark) != array_lines(options)) {
    fail("{}: its arrays have another shape than its options ask for", path);
  }
  return options;
}

/// Reads a tensor that has to be so long.
template <class Number>
void read_tensor(const ZipReader& archive, const ZipReader::Record& record, std::span<Number> to) {
  archive.read(record, std::as_writable_bytes(to));
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

std::string network_header(const NetworkOptions& options) {
  return fmt::format("{}\nversion {}\n{}{}{}", kNetworkFormat, kNetworkVersion, array_lines(options),
                     kOptionsMark, network_options_as_toml(options));
}

NetworkWeights load_network_weights(const std::filesystem::path& file) {
  const std::string path = file.string();
  const ZipReader archive(file);
  const std::vector<ZipReader::Record> tensors = tensors_of(archive);
  const std::string first_line = std::string(kNetworkFormat) + "\n";
  const bool has_header = !tensors.empty() && tensors[0].bytes <= kLongestHeader &&
                          archive.read_start(tensors[0], kLongestHeader).starts_with(first_line);
  if (!has_header) fail_without_header(path, archive);
  const std::string header = archive.read_start(tensors[0], kLongestHeader);
  const NetworkOptions options = options_of(std::string_view(header).substr(first_line.size()), path);

  // Before there is room for them: a file may ask for more than there is.
  const ArraySizes sizes = total_sizes(network_arrays(options));
  std::vector<std::uint64_t> expected = {sizes.halves * sizeof(Half)};
  if (sizes.singles > 0) expected.push_back(sizes.singles * sizeof(float));
  const std::span<const ZipReader::Record> found = std::span(tensors).subspan(1);
  std::vector<std::uint64_t> bytes;
  for (const ZipReader::Record& tensor : found) bytes.push_back(tensor.bytes);
  if (bytes != expected) {
    fail("{}: tensors of {} bytes, expected {}", path, fmt::join(bytes, " and "),
         fmt::join(expected, " and "));
  }
  NetworkWeights weights(options);
  read_tensor(archive, found[0], weights.halves());
  if (sizes.singles > 0) read_tensor(archive, found[1], weights.singles());
  check_numbers(weights, path);
  return weights;
}

}  // namespace knuckle
