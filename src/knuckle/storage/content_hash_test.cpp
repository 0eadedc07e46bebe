// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/content_hash.h"

#include <string>

#include "knuckle/core/error.h"
#include "knuckle/core/testing.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

TEST(ContentHash, IsThatOfXxhsum) {
  EXPECT_EQ(text_hash(""), "99aa06d3014798d86001c324468d497f");  // xxhsum -H2 of an empty file
  const testing::TemporaryFolder folder;
  write_text_file(folder / "empty", "");
  EXPECT_EQ(content_hash(folder / "empty"), text_hash(""));
}

TEST(ContentHash, OfAFileLargerThanABlockIsThatOfItsText) {
  const testing::TemporaryFolder folder;
  std::string text(3'000'000, 'x');
  write_text_file(folder / "file", text);
  EXPECT_EQ(content_hash(folder / "file"), text_hash(text));
  text[2'000'000] = 'y';
  EXPECT_NE(content_hash(folder / "file"), text_hash(text));
}

TEST(ContentSum, DependsOnEachByteAndTheSeed) {
  const auto sum = [](std::string_view text, std::uint64_t seed) {
    return content_sum(std::as_bytes(std::span(text)), seed);
  };
  EXPECT_EQ(sum("", 0), 0x2d06800538d394c2U);  // XXH3_64bits of nothing
  EXPECT_NE(sum("ab", 0), sum("ba", 0));
  EXPECT_NE(sum("ab", 0), sum("ab", 1));
}

TEST(ContentHash, NamesAFileThatCannotBeRead) {
  // Nothing is at its beginning, the address 0.
  EXPECT_THAT(testing::error_of([] { content_hash("/proc/self/mem"); }),
              ::testing::HasSubstr("/proc/self/mem: cannot be read"));
}

TEST(ContentHash, NamesAMissingFile) {
  EXPECT_THAT(testing::error_of([] { content_hash("none.h5"); }), ::testing::HasSubstr("none.h5"));
}

}  // namespace
}  // namespace knuckle
