// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/mcap_file.h"

#include <algorithm>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/byte_cursor.h"
#include "knuckle/storage/deflate.h"

namespace knuckle {
namespace {

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
constexpr std::size_t kVersionAt = 5;
constexpr std::uint64_t kFooterBytes = 8 + 8 + 4;  // where summary and its offsets begin, and their sum
constexpr const char* kHowToMend = "was not closed by its recorder, or is cut short; 'mcap recover' mends it";

std::string_view as_text(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

McapFile::McapFile(std::filesystem::path path) : RecordingFile(std::move(path)) {
  require_magic();
  footer_ = size() - kMagic.size() - kFooterBytes - kMcapRecordHeadBytes;
  check_summary();
}

std::uint64_t McapFile::first_record() const {
  return kMagic.size();
}

void McapFile::require_magic() const {
  const std::string name = path().string();
  const std::vector<std::uint8_t> start = read_up_to(0, kMagic.size(), size());
  const std::string_view magic = as_text(start);
  if (!magic.starts_with(kMagic.substr(0, kVersionAt))) fail("{}: is not an MCAP file", name);
  if (magic.size() > kVersionAt && magic[kVersionAt] != kMagic[kVersionAt]) {
    fail("{}: is an MCAP file of version '{}', expected 0", name, printable(magic.substr(kVersionAt, 1)));
  }
  if (magic != kMagic) fail("{}: is not an MCAP file, or was changed by a transfer as text", name);
  constexpr std::uint64_t kLeastBytes = 2 * kMagic.size() + kMcapRecordHeadBytes + kFooterBytes;
  if (size() < kLeastBytes || as_text(read(size() - kMagic.size(), kMagic.size())) != kMagic)
    fail("{}: {}", name, kHowToMend);
}

void McapFile::check_summary() const {
  const std::vector<std::uint8_t> bytes = read(footer_, kMcapRecordHeadBytes + kFooterBytes);
  ByteCursor cursor(bytes, "");
  if (cursor.u8() != static_cast<std::uint8_t>(McapRecordKind::footer) || cursor.u64() != kFooterBytes)
    fail("{}: {}", path().string(), kHowToMend);
  const std::uint64_t summary_at = cursor.u64();
  cursor.skip(8);
  const std::uint32_t sum = cursor.u32();
  if (summary_at > footer_) fail("{}: the file is damaged: its summary lies beyond its end", place(footer_));
  if (summary_at == 0 || sum == 0) return;
  // The sum is of the footer, too, as far as to itself.
  if (!is_sum(sum_of(summary_at, footer_ + bytes.size() - 4), sum))
    fail("{}: the file is damaged: the sum of its summary is another", path().string());
}

std::uint32_t McapFile::sum_of(std::uint64_t at, std::uint64_t end) const {
  constexpr std::uint64_t kSumBlockBytes = std::uint64_t{1} << 20;
  std::uint32_t sum = 0;
  while (at < end) {
    const std::vector<std::uint8_t> block = read_up_to(at, kSumBlockBytes, end);
    sum = crc32(block, sum);
    at += block.size();
  }
  return sum;
}

McapRecord McapFile::record_at(std::uint64_t at) const {
  const std::vector<std::uint8_t> head = read_up_to(at, kMcapRecordHeadBytes, footer_);
  if (head.size() < kMcapRecordHeadBytes) fail("{}: the file is damaged: a record is cut short", place(at));
  ByteCursor cursor(head, "");
  const auto kind = static_cast<McapRecordKind>(cursor.u8());
  const std::uint64_t bytes = cursor.u64();
  const std::uint64_t data_at = at + kMcapRecordHeadBytes;
  if (bytes > footer_ - data_at) {
    fail("{}: the file is damaged: a record has {} bytes, and {} are left", place(at), bytes,
         footer_ - data_at);
  }
  return {kind, at, data_at, bytes};
}

std::vector<std::uint8_t> McapFile::start_of(const McapRecord& record, std::uint64_t most_bytes) const {
  return read(record.data_at, std::min(record.data_bytes, most_bytes));
}

std::vector<std::uint8_t> McapFile::content_of(const McapRecord& record) const {
  constexpr auto kMostBytes = static_cast<std::uint64_t>(limits::kRecordHeaderBytes);
  if (record.data_bytes > kMostBytes) {
    fail("{}: a description has {} bytes, expected at most {}", place(record.at), record.data_bytes,
         kMostBytes);
  }
  return read(record.data_at, record.data_bytes);
}

}  // namespace knuckle
