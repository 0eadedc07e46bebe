// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/zip_archive.h"

#include <algorithm>

#include "knuckle/core/limits.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

using Bytes = std::vector<std::uint8_t>;

Bytes zip_bytes() {
  const Bytes zeros(5000, 0);
  const Bytes few{1, 2, 3};
  return zip_of(
      std::vector<ZipContent>{{"zeros", zeros}, {"few", few}, {"empty", {}}, {"plain", zeros, false}},
      "a comment");
}

void set_u16(Bytes& bytes, std::size_t at, std::uint64_t value) {
  for (std::size_t i = 0; i < 2; ++i) bytes.at(at + i) = static_cast<std::uint8_t>(value >> (8 * i));
}

void set_u32(Bytes& bytes, std::size_t at, std::uint64_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes.at(at + i) = static_cast<std::uint8_t>(value >> (8 * i));
}

/// Where the n-th of these four bytes lies.
std::size_t place_of(const Bytes& bytes, std::uint32_t signature, int n) {
  Bytes pattern(4);
  set_u32(pattern, 0, signature);
  auto found = std::ranges::search(bytes, pattern).begin();
  for (; n > 0; --n)
    found = std::ranges::search(found + 1, bytes.end(), pattern.begin(), pattern.end()).begin();
  return static_cast<std::size_t>(found - bytes.begin());
}

std::string archive_fault_of(const Bytes& bytes) {
  return error_of([&] {
    for (const ZipEntry& entry : parse_zip(bytes, "a.zip").entries) content_of(entry, "a.zip");
  });
}

TEST(ZipArchive, GivesBackWhatWasPutIn) {
  const Bytes bytes = zip_bytes();
  const ZipArchive archive = parse_zip(bytes, "a.zip");
  ASSERT_EQ(archive.entries.size(), 4u);
  EXPECT_EQ(archive.comment, "a comment");
  EXPECT_EQ(archive.entries[0].name, "zeros");
  EXPECT_TRUE(archive.entries[0].is_deflated);
  EXPECT_FALSE(archive.entries[3].is_deflated);
  EXPECT_EQ(content_of(archive.entries[0], "a.zip"), Bytes(5000, 0));
  EXPECT_EQ(content_of(archive.entries[1], "a.zip"), (Bytes{1, 2, 3}));
  EXPECT_EQ(content_of(archive.entries[2], "a.zip"), Bytes());
  EXPECT_EQ(content_of(archive.entries[3], "a.zip"), Bytes(5000, 0));
}

TEST(ZipArchive, CutShortAtAnyLengthIsRefused) {
  const Bytes bytes = zip_bytes();
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_THAT(archive_fault_of({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)}),
                HasSubstr("a.zip"))
        << length;
  }
}

TEST(ZipArchive, AnyBytesAreReadOrRefused) {
  const Bytes bytes = zip_bytes();
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    Bytes changed = bytes;
    for (int k = 0; k < 4; ++k) changed[random() % changed.size()] = static_cast<std::uint8_t>(random());
    try {
      for (const ZipEntry& entry : parse_zip(changed, "a.zip").entries) content_of(entry, "a.zip");
    } catch (const Error&) {
    }
  }
}

TEST(ZipArchive, OfTooManyEntriesIsRefused) {
  Bytes bytes = zip_bytes();
  const std::size_t end = place_of(bytes, 0x06054b50, 0);
  set_u16(bytes, end + 8, 65535);
  set_u16(bytes, end + 10, 65535);
  EXPECT_THAT(archive_fault_of(bytes), HasSubstr("it lists 65535 entries, expected at most"));
  const auto of_entries = [](std::size_t count) {
    return zip_of(std::vector<ZipContent>(count, ZipContent{"a", {}}), "");
  };
  EXPECT_THAT(archive_fault_of(of_entries(static_cast<std::size_t>(limits::kModelEntries) + 1)),
              HasSubstr("it lists 257 entries, expected at most"));
  EXPECT_THAT(archive_fault_of(of_entries(100'000)), HasSubstr("entries, expected at most"));
  // Their number has 16 bits: of so many it says 1.
  EXPECT_THAT(archive_fault_of(of_entries(65'537)), HasSubstr("something lies between its entries"));
}

TEST(ZipArchive, WhoseEntriesOverlapOrLeaveGapsIsRefused) {
  Bytes overlapping = zip_bytes();
  const std::size_t second = place_of(overlapping, 0x02014b50, 1);
  set_u32(overlapping, second + 42, 0);  // where the second entry begins
  EXPECT_THAT(archive_fault_of(overlapping), HasSubstr("where an entry begins is 0"));
  const Bytes twice = zip_of(std::vector<ZipContent>{{"a", {}}, {"a", {}}}, "");
  EXPECT_THAT(archive_fault_of(twice), HasSubstr("two of its entries have one name"));
  Bytes behind = zip_bytes();
  behind.push_back(0);
  EXPECT_THAT(archive_fault_of(behind), HasSubstr("something follows its end"));
}

TEST(ZipArchive, ThatSaysItHoldsMoreThanItCanIsRefusedBeforeMemoryIsTaken) {
  for (const std::uint64_t size : {std::uint64_t{5001}, std::uint64_t{60000}, std::uint64_t{4000000000}}) {
    Bytes bytes = zip_bytes();
    set_u32(bytes, 22, size);  // of the first entry, and in the directory
    set_u32(bytes, place_of(bytes, 0x02014b50, 0) + 24, size);
    EXPECT_THAT(archive_fault_of(bytes),
                HasSubstr(size < 20000 ? "cannot be inflated" : "says that it holds"));
  }
}

TEST(ZipArchive, OfAThousandTimesItsSizeIsRefused) {
  const Bytes zeros(std::size_t{300} << 20, 0);  // two of these are more than a model may hold
  const Bytes bomb = zip_of(std::vector<ZipContent>{{"a", zeros}, {"b", zeros}}, "");
  ASSERT_LT(bomb.size(), std::size_t{1} << 20);
  EXPECT_THAT(error_of([&] { parse_zip(bomb, "a.zip"); }),
              HasSubstr("it says that it holds 629145600 bytes"));
}

TEST(ZipArchive, WithAnotherMethodOrASumThatDoesNotFitIsRefused) {
  Bytes encrypted = zip_bytes();
  set_u16(encrypted, 6, 1);
  EXPECT_THAT(archive_fault_of(encrypted), HasSubstr("flags"));
  Bytes summed = zip_bytes();
  set_u32(summed, 14, 5);
  set_u32(summed, place_of(summed, 0x02014b50, 0) + 16, 5);
  EXPECT_THAT(archive_fault_of(summed), HasSubstr("the sum of zeros is another"));
  Bytes of_another_method = zip_bytes();
  set_u16(of_another_method, 8, 12);
  set_u16(of_another_method, place_of(of_another_method, 0x02014b50, 0) + 10, 12);
  EXPECT_THAT(archive_fault_of(of_another_method), HasSubstr("an entry has method 12, expected 0 or 8"));
}

TEST(ZipArchive, WhoseDirectorySaysOtherThanTheEntryIsRefused) {
  Bytes summed = zip_bytes();
  set_u32(summed, 14, 5);
  EXPECT_THAT(archive_fault_of(summed),
              HasSubstr("a.zip: no sound zip: an entry and the directory disagree"));
  Bytes renamed = zip_bytes();
  renamed[30] = 'Z';
  EXPECT_THAT(archive_fault_of(renamed), HasSubstr("an entry and the directory disagree"));
}

TEST(ZipArchive, WhoseEndIsMissingOrElsewhereIsRefused) {
  Bytes bytes = zip_bytes();
  const std::size_t end = place_of(bytes, 0x06054b50, 0);
  set_u32(bytes, end + 16, 7);  // where the directory begins
  EXPECT_THAT(archive_fault_of(bytes), HasSubstr("its directory does not lie right before its end"));
  bytes.resize(end);
  EXPECT_THAT(archive_fault_of(bytes), HasSubstr("a.zip: no zip, or cut short: its end is missing"));
}

TEST(ZipArchive, WhoseEntryReachesBeyondTheOthersIsRefused) {
  Bytes bytes = zip_bytes();
  set_u32(bytes, 18, 4'000'000);  // the stored bytes of the first entry, and in the directory
  set_u32(bytes, place_of(bytes, 0x02014b50, 0) + 20, 4'000'000);
  EXPECT_THAT(archive_fault_of(bytes), HasSubstr("a.zip: no sound zip: it ends too early"));
}

TEST(ZipArchive, AnEntryIsReadToAsManyBytesAsItHas) {
  const Bytes bytes = zip_bytes();
  const ZipArchive archive = parse_zip(bytes, "a.zip");
  Bytes content(4999);
  EXPECT_THAT(error_of([&] { read_content(archive.entries[0], content, "a.zip"); }),
              HasSubstr("a.zip: zeros has 5000 bytes, expected 4999"));
}

}  // namespace
}  // namespace knuckle
