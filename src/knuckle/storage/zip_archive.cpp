// SPDX-License-Identifier: Apache-2.0
// PKWARE's APPNOTE 6.3.9: local headers (4.3.7), directory (4.3.12) and its end (4.3.16).
#include "knuckle/storage/zip_archive.h"

#include <algorithm>
#include <limits>
#include <unordered_set>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/storage/deflate.h"

namespace knuckle {
namespace {

constexpr std::uint32_t kLocalSignature = 0x04034b50;
constexpr std::uint32_t kDirectorySignature = 0x02014b50;
constexpr std::uint32_t kEndSignature = 0x06054b50;
constexpr std::size_t kLocalBytes = 30;
constexpr std::size_t kDirectoryBytes = 46;
constexpr std::size_t kEndBytes = 22;
constexpr std::uint16_t kStored = 0;
constexpr std::uint16_t kDeflated = 8;
constexpr std::uint16_t kUtf8Names = 0x0800;
constexpr std::uint16_t kVersionNeeded = 20;
constexpr std::uint16_t kFirstDay = 0x0021;  // 1 January 1980: no time of writing
constexpr std::uint64_t kDeflatesLimit = 1032;

/// Reads little-endian numbers from the front of bytes.
class ZipCursor {
 public:
  ZipCursor(std::span<const std::uint8_t> bytes, const std::string& origin)
      : bytes_(bytes), origin_(origin) {}

  std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  std::span<const std::uint8_t> take(std::uint64_t count) {
    if (count > bytes_.size()) damaged("it ends too early");
    const auto taken = bytes_.first(static_cast<std::size_t>(count));
    bytes_ = bytes_.subspan(static_cast<std::size_t>(count));
    return taken;
  }
  std::string text(std::uint64_t count) {
    const auto taken = take(count);
    return {taken.begin(), taken.end()};
  }
  void expect(std::uint64_t found, std::uint64_t expected, std::string_view what) const {
    if (found != expected) damaged(fmt::format("{} is {}, expected {}", what, found, expected));
  }
  bool is_at_end() const { return bytes_.empty(); }
  [[noreturn]] void damaged(std::string_view why) const { fail("{}: no sound zip: {}", origin_, why); }

 private:
  std::uint64_t number(std::size_t count) {
    std::uint64_t value = 0;
    const auto taken = take(count);
    for (std::size_t i = 0; i < count; ++i) value |= std::uint64_t{taken[i]} << (8 * i);
    return value;
  }

  std::span<const std::uint8_t> bytes_;
  const std::string& origin_;
};

/// What local header and directory say alike.
struct ZipDescription {
  std::uint16_t method = 0;
  std::uint32_t crc = 0;
  std::uint32_t stored_bytes = 0;
  std::uint32_t bytes = 0;
  std::uint16_t name_length = 0;
  bool operator==(const ZipDescription&) const = default;
};

ZipDescription read_description(ZipCursor& cursor) {
  cursor.expect(cursor.u16(), kVersionNeeded, "the version that an entry needs");
  cursor.expect(cursor.u16() & ~kUtf8Names, 0, "an entry's flags");
  ZipDescription description;
  description.method = cursor.u16();
  cursor.take(4);  // time and date
  description.crc = cursor.u32();
  description.stored_bytes = cursor.u32();
  description.bytes = cursor.u32();
  description.name_length = cursor.u16();
  cursor.expect(cursor.u16(), 0, "the length of an entry's extra field");
  return description;
}

void check_description(const ZipDescription& entry, const ZipCursor& cursor) {
  if (entry.method != kStored && entry.method != kDeflated) {
    cursor.damaged(fmt::format("an entry has method {}, expected 0 or 8", entry.method));
  }
  const std::uint64_t most =
      entry.stored_bytes * (entry.method == kStored ? std::uint64_t{1} : kDeflatesLimit);
  if (entry.bytes > most || (entry.method == kStored && entry.bytes != entry.stored_bytes)) {
    cursor.damaged(
        fmt::format("an entry of {} bytes says that it holds {}", entry.stored_bytes, entry.bytes));
  }
}

/// Reads the next entry of the directory, which has to be the next one of the file, too.
ZipEntry read_entry(ZipCursor& directory, ZipCursor& file, std::uint64_t& offset) {
  directory.expect(directory.u32(), kDirectorySignature, "the signature of an entry of the directory");
  directory.u16();  // the version that made it
  const ZipDescription listed = read_description(directory);
  directory.expect(directory.u16(), 0, "the length of an entry's comment");
  directory.expect(directory.u16(), 0, "the disk of an entry");
  directory.take(6);  // attributes
  directory.expect(directory.u32(), offset, "where an entry begins");
  const std::string name = directory.text(listed.name_length);

  file.expect(file.u32(), kLocalSignature, "the signature of an entry");
  const ZipDescription local = read_description(file);
  if (local != listed || file.text(local.name_length) != name) {
    file.damaged("an entry and the directory disagree");
  }
  check_description(listed, file);
  offset += kLocalBytes + listed.name_length + listed.stored_bytes;
  return {name, listed.method == kDeflated, listed.crc, listed.bytes, file.take(listed.stored_bytes)};
}

/// The end of a zip: where and how long the directory is, and a comment.
struct ZipEnd {
  std::uint16_t entries = 0;
  std::uint32_t directory_bytes = 0;
  std::uint32_t directory_offset = 0;
  std::string_view comment;
};

std::size_t end_offset(std::span<const std::uint8_t> bytes, const std::string& origin) {
  const std::size_t farthest = kEndBytes + std::numeric_limits<std::uint16_t>::max();
  for (std::size_t length = kEndBytes; length <= std::min(farthest, bytes.size()); ++length) {
    ZipCursor cursor(bytes.last(length), origin);
    if (cursor.u32() == kEndSignature) return bytes.size() - length;
  }
  fail("{}: no zip, or cut short: its end is missing", origin);
}

ZipEnd read_end(std::span<const std::uint8_t> bytes, const std::string& origin) {
  const std::size_t offset = end_offset(bytes, origin);
  ZipCursor cursor(bytes.subspan(offset), origin);
  cursor.u32();
  cursor.expect(cursor.u32(), 0, "the number of its disk");
  ZipEnd end;
  end.entries = cursor.u16();
  cursor.expect(cursor.u16(), end.entries, "the number of entries in all");
  end.directory_bytes = cursor.u32();
  end.directory_offset = cursor.u32();
  const auto comment = cursor.take(cursor.u16());
  end.comment = {reinterpret_cast<const char*>(comment.data()), comment.size()};
  if (!cursor.is_at_end()) cursor.damaged("something follows its end");
  if (std::uint64_t{end.directory_offset} + end.directory_bytes != offset) {
    cursor.damaged("its directory does not lie right before its end");
  }
  return end;
}

void append_u16(std::vector<std::uint8_t>& bytes, std::uint64_t value) {
  for (int shift = 0; shift < 16; shift += 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

void append_u32(std::vector<std::uint8_t>& bytes, std::uint64_t value) {
  append_u16(bytes, value & 0xffff);
  append_u16(bytes, value >> 16);
}

void append_text(std::vector<std::uint8_t>& bytes, std::string_view text) {
  bytes.insert(bytes.end(), text.begin(), text.end());
}

void append_description(std::vector<std::uint8_t>& bytes, const ZipDescription& entry) {
  append_u16(bytes, kVersionNeeded);
  append_u16(bytes, 0);
  append_u16(bytes, entry.method);
  append_u16(bytes, 0);
  append_u16(bytes, kFirstDay);
  append_u32(bytes, entry.crc);
  append_u32(bytes, entry.stored_bytes);
  append_u32(bytes, entry.bytes);
  append_u16(bytes, entry.name_length);
  append_u16(bytes, 0);
}

void append_to_directory(std::vector<std::uint8_t>& directory, const ZipDescription& entry,
                         const std::string& name, std::uint64_t offset) {
  append_u32(directory, kDirectorySignature);
  append_u16(directory, kVersionNeeded);
  append_description(directory, entry);
  append_u32(directory, 0);  // no comment, disk 0
  append_u32(directory, 0);  // no attributes
  append_u16(directory, 0);
  append_u32(directory, offset);
  append_text(directory, name);
}

}  // namespace

ZipArchive parse_zip(std::span<const std::uint8_t> bytes, const std::string& origin) {
  const ZipEnd end = read_end(bytes, origin);
  if (end.entries > limits::kModelEntries ||
      std::uint64_t{end.entries} * kDirectoryBytes > end.directory_bytes) {
    fail("{}: no sound zip: it lists {} entries, expected at most {} that fit into its directory", origin,
         end.entries, limits::kModelEntries);
  }
  ZipArchive archive{{}, end.comment};
  ZipCursor file(bytes.first(end.directory_offset), origin);
  ZipCursor directory(bytes.subspan(end.directory_offset, end.directory_bytes), origin);
  std::unordered_set<std::string> names;
  std::uint64_t offset = 0;
  std::uint64_t content = 0;
  for (int i = 0; i < end.entries; ++i) {
    archive.entries.push_back(read_entry(directory, file, offset));
    content += archive.entries.back().size;
    if (!names.insert(archive.entries.back().name).second) file.damaged("two of its entries have one name");
  }
  if (!file.is_at_end() || !directory.is_at_end()) file.damaged("something lies between its entries");
  if (content > static_cast<std::uint64_t>(limits::kModelBytes)) {
    fail("{}: it says that it holds {} bytes, expected at most {}", origin, content, limits::kModelBytes);
  }
  return archive;
}

std::vector<std::uint8_t> content_of(const ZipEntry& entry, const std::string& origin) {
  std::vector<std::uint8_t> content(static_cast<std::size_t>(entry.size));
  read_content(entry, content, origin);
  return content;
}

void read_content(const ZipEntry& entry, std::span<std::uint8_t> content, const std::string& origin) {
  if (content.size() != entry.size) {
    fail("{}: {} has {} bytes, expected {}", origin, entry.name, entry.size, content.size());
  }
  if (!entry.is_deflated) {
    std::ranges::copy(entry.stored, content.begin());
  } else if (!inflate_raw(entry.stored, content)) {
    fail("{}: damaged: {} cannot be inflated to {} bytes", origin, entry.name, entry.size);
  }
  if (!is_sum(crc32(content), entry.crc)) fail("{}: damaged: the sum of {} is another", origin, entry.name);
}

std::vector<std::uint8_t> zip_of(std::span<const ZipContent> contents, std::string_view comment) {
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint8_t> directory;
  for (const auto& [name, content, may_be_deflated] : contents) {
    std::vector<std::uint8_t> stored;
    if (may_be_deflated) stored = deflated_raw(content);
    const bool is_smaller = may_be_deflated && stored.size() < content.size();
    if (!is_smaller) stored.assign(content.begin(), content.end());
    const ZipDescription entry{
        is_smaller ? kDeflated : kStored, crc32(content), static_cast<std::uint32_t>(stored.size()),
        static_cast<std::uint32_t>(content.size()), static_cast<std::uint16_t>(name.size())};
    append_to_directory(directory, entry, name, bytes.size());
    append_u32(bytes, kLocalSignature);
    append_description(bytes, entry);
    append_text(bytes, name);
    bytes.insert(bytes.end(), stored.begin(), stored.end());
  }
  const std::size_t directory_offset = bytes.size();
  bytes.insert(bytes.end(), directory.begin(), directory.end());
  append_u32(bytes, kEndSignature);
  append_u32(bytes, 0);  // disk 0
  append_u16(bytes, contents.size());
  append_u16(bytes, contents.size());
  append_u32(bytes, directory.size());
  append_u32(bytes, directory_offset);
  append_u16(bytes, comment.size());
  append_text(bytes, comment);
  return bytes;
}

}  // namespace knuckle
