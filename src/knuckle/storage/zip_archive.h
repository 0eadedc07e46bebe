// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// A file in a zip, as the zip's directory describes it.
struct ZipEntry {
  std::string name;
  bool is_deflated = false;
  std::uint32_t crc = 0;                 ///< CRC-32 of its content
  std::uint64_t size = 0;                ///< of its content [bytes]
  std::span<const std::uint8_t> stored;  ///< as it lies in the zip
};

/// A zip of the plainest kind: its entries end to end from the first byte on, the directory right after them,
/// then the end with a comment. No entry is split, encrypted or of another method than deflate, no two
/// overlap, nothing lies between them; names differ. What was checked of `content` stays true only as long as
/// the bytes live.
struct ZipArchive {
  std::vector<ZipEntry> entries;  ///< at most limits::kModelEntries, limits::kModelBytes in all
  std::string_view comment;
};

/// The parts of such a zip. Throws an Error that starts with `origin` where the bytes are anything else, or
/// an entry says it holds more than its bytes can.
ZipArchive parse_zip(std::span<const std::uint8_t> bytes, const std::string& origin);

/// An entry's content, whose length and sum are checked. Throws an Error that starts with `origin`.
std::vector<std::uint8_t> content_of(const ZipEntry& entry, const std::string& origin);

/// The same into memory of the entry's size, without a copy in between. Throws an Error also where the sizes
/// differ.
void read_content(const ZipEntry& entry, std::span<std::uint8_t> content, const std::string& origin);

/// Name and content of a file for a zip.
struct ZipContent {
  std::string name;
  std::span<const std::uint8_t> bytes;
  bool may_be_deflated = true;
};

/// The bytes of such a zip; an entry is deflated where it may be and that makes it smaller. The same content
/// makes the same bytes.
std::vector<std::uint8_t> zip_of(std::span<const ZipContent> contents, std::string_view comment);

}  // namespace knuckle
