// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_file_testing.h"

#include <span>

#include <zip.h>

#include "knuckle/core/error.h"
#include "knuckle/net/network_file.h"

namespace knuckle::testing {
namespace {

template <class Number>
std::string bytes_of(std::span<const Number> numbers) {
  const std::span<const std::byte> bytes = std::as_bytes(numbers);
  std::string text;
  for (const std::byte byte : bytes) text.push_back(static_cast<char>(byte));
  return text;
}

}  // namespace

void write_zip(const std::filesystem::path& path, const ZipRecords& records) {
  zip_t* const archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  if (archive == nullptr) fail("{}: cannot write", path.string());
  for (const auto& [name, bytes] : records) {
    zip_source_t* const source = zip_source_buffer(archive, bytes.data(), bytes.size(), 0);
    const zip_int64_t index = zip_file_add(archive, name.c_str(), source, ZIP_FL_OVERWRITE);
    zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0);
  }
  if (zip_close(archive) != 0) fail("{}: cannot write", path.string());
}

ZipRecords network_records(const NetworkWeights& weights) {
  ZipRecords records = {{"net/data.pkl", "contents"},
                        {"net/data/0", network_header(weights.options())},
                        {"net/data/1", bytes_of(weights.halves())}};
  if (!weights.singles().empty()) records.emplace_back("net/data/2", bytes_of(weights.singles()));
  return records;
}

void write_network(const std::filesystem::path& path, const NetworkWeights& weights) {
  write_zip(path, network_records(weights));
}

}  // namespace knuckle::testing
