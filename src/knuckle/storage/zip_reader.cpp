// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/zip_reader.h"

#include <algorithm>

#include <zip.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

struct CloseRecord {
  void operator()(zip_file* record) const { zip_fclose(record); }
};

/// Fills as much of `to` as the record has; the number of bytes, or -1 where they cannot be read.
std::int64_t read_bytes(zip* archive, std::uint64_t index, std::span<std::byte> to) {
  const std::unique_ptr<zip_file, CloseRecord> record(zip_fopen_index(archive, index, 0));
  if (!record) return -1;
  std::size_t done = 0;
  while (done < to.size()) {
    const zip_int64_t count = zip_fread(record.get(), to.data() + done, to.size() - done);
    if (count < 0) return -1;
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  // Its end is where the sum of a record that was read from end to end is compared.
  std::byte beyond{};
  if (zip_fread(record.get(), &beyond, 1) < 0) return -1;
  return static_cast<std::int64_t>(done);
}

}  // namespace

void ZipReader::Close::operator()(zip* archive) const {
  zip_discard(archive);
}

ZipReader::ZipReader(const std::filesystem::path& path) : path_(path.string()) {
  if (!std::filesystem::is_regular_file(path)) fail("{}: cannot read: no such file", path_);
  archive_.reset(zip_open(path_.c_str(), ZIP_RDONLY, nullptr));
  if (!archive_) return;
  const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    zip_stat_t found;
    if (zip_stat_index(archive_.get(), static_cast<zip_uint64_t>(i), 0, &found) != 0) continue;
    constexpr zip_uint64_t kNeeded = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_METHOD;
    if ((found.valid & kNeeded) != kNeeded || found.comp_method != ZIP_CM_STORE) continue;
    records_.push_back({found.name, static_cast<std::uint64_t>(i), found.size});
  }
}

ZipReader::~ZipReader() = default;

std::string ZipReader::read_start(const Record& record, std::size_t most) const {
  std::string text(std::min<std::uint64_t>(record.bytes, most), '\0');
  const std::int64_t count =
      read_bytes(archive_.get(), record.index, std::as_writable_bytes(std::span(text)));
  if (count != static_cast<std::int64_t>(text.size())) {
    fail("{}: damaged: its record {} cannot be read", path_, record.name);
  }
  return text;
}

void ZipReader::read(const Record& record, std::span<std::byte> to) const {
  if (read_bytes(archive_.get(), record.index, to) != static_cast<std::int64_t>(to.size())) {
    fail("{}: damaged: its record {} cannot be read", path_, record.name);
  }
}

}  // namespace knuckle
