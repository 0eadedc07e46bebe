// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/line_index.h"

#include "knuckle/core/testing.h"
#include "knuckle/data/readers/data_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::put_file;

TEST(LineIndex, FindsEveryLineAndSkipsBlanksAndRemarks) {
  const testing::TemporaryFolder folder;
  put_file(folder / "a.txt", "# remark\n1 2\n\n  \r\n  3 4\r\n# another\n5");
  const LineIndex lines(folder / "a.txt");
  ASSERT_EQ(lines.size(), 3);
  EXPECT_EQ(lines.line(0), "1 2");
  EXPECT_EQ(lines.line(1), "  3 4");
  EXPECT_EQ(lines.line(2), "5");
  EXPECT_THAT(lines.where(1), HasSubstr("a.txt:5"));
  EXPECT_THAT(lines.where(2), HasSubstr("a.txt:7"));
  EXPECT_THAT(lines.where(3), ::testing::EndsWith("a.txt"));
  EXPECT_THAT(error_of([&] { lines.line(3); }), HasSubstr("a.txt: has 3 entries, asked for entry 4"));
}

TEST(LineIndex, FindsLinesThatCrossItsBlocks) {
  const testing::TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 300000; ++i) text += fmt::format("{} {}\n", i, 7 * i);
  ASSERT_GT(text.size(), std::size_t{3} << 20);
  put_file(folder / "long.txt", text);
  const LineIndex lines(folder / "long.txt");
  ASSERT_EQ(lines.size(), 300000);
  for (int i = 0; i < 300000; i += 997) ASSERT_EQ(lines.line(i), fmt::format("{} {}", i, 7 * i));
}

TEST(LineIndex, NamesAMissingFile) {
  EXPECT_THAT(error_of([] { LineIndex("/no/such/file.txt"); }), HasSubstr("/no/such/file.txt"));
  EXPECT_THAT(error_of([] { LineIndex("/tmp"); }), HasSubstr("/tmp"));
}

TEST(LineIndex, NoticesThatTheFileWasChanged) {
  const testing::TemporaryFolder folder;
  put_file(folder / "a.txt", "11\n22\n33\n");
  const LineIndex lines(folder / "a.txt");
  put_file(folder / "a.txt", "111\n22\n33\n");
  EXPECT_THAT(error_of([&] { lines.line(1); }), HasSubstr("a.txt:2: cannot be read"));
  put_file(folder / "a.txt", "11\n22\n");
  EXPECT_EQ(lines.line(1), "22");
  EXPECT_THAT(error_of([&] { lines.line(2); }), HasSubstr("a.txt:3: cannot be read"));
}

TEST(LineIndex, AnEmptyFileHasNoLines) {
  const testing::TemporaryFolder folder;
  put_file(folder / "empty.txt", "");
  EXPECT_EQ(LineIndex(folder / "empty.txt").size(), 0);
}

TEST(LineIndex, ALineThatIsTooLongIsRefused) {
  const testing::TemporaryFolder folder;
  put_file(folder / "a.txt", "1\n" + std::string((std::size_t{1} << 20) + 2, '1') + "\n");
  EXPECT_THAT(error_of([&] { LineIndex(folder / "a.txt"); }), HasSubstr("a.txt:2: the line has more than"));
}

}  // namespace
}  // namespace knuckle
