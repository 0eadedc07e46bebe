// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/regular_file.h"

#include <fstream>

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "knuckle/core/limits.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/testing_memory.h"
#include "knuckle/core/text_file.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::peak_memory_kb;
using testing::TemporaryFolder;

std::string fault_of(const std::filesystem::path& path) {
  EXPECT_EQ(error_of([&] { require_regular_file(path); }), error_of([&] { read_regular_file(path, 10); }));
  return error_of([&] { require_regular_file(path); });
}

TEST(RegularFile, IsReadWhole) {
  const TemporaryFolder folder;
  for (const std::size_t size : {0, 1, 4095, 4096, 4097, 100000}) {
    const std::string text(size, 'x');
    std::ofstream(folder / "a") << text;
    EXPECT_EQ(read_regular_file(folder / "a", 100000), text);
  }
  EXPECT_GT(read_regular_file("/proc/self/status", 1 << 20).size(), 0u) << "its size is said to be 0";
}

TEST(RegularFile, LargerThanItMayBeIsRefused) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a") << "12345";
  EXPECT_EQ(read_regular_file(folder / "a", 5), "12345");
  EXPECT_THAT(error_of([&] { read_regular_file(folder / "a", 4); }), HasSubstr("expected at most 4"));
}

TEST(RegularFile, WhatIsNoneIsNamedAtOnce) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
  EXPECT_THAT(fault_of(folder / "fifo"), HasSubstr("fifo: expected a file, found a FIFO"));
  EXPECT_THAT(fault_of(folder.path()), HasSubstr("expected a file, found a folder"));
  EXPECT_THAT(fault_of("/dev/zero"), HasSubstr("/dev/zero: expected a file, found a device"));
  EXPECT_THAT(fault_of(folder / "none"), HasSubstr("none: cannot read: No such file"));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  (folder / "socket").string().copy(address.sun_path, sizeof(address.sun_path) - 1);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  EXPECT_THAT(fault_of(folder / "socket"), HasSubstr("expected a file, found a socket"));
  ::close(socket);
}

TEST(RegularFile, OneThatCannotBeReadIsNamed) {
  // A process has nothing at the address 0, where this file begins.
  EXPECT_THAT(error_of([] { read_regular_file("/proc/self/mem", 10); }),
              HasSubstr("/proc/self/mem: cannot read: "));
}

TEST(TextFile, ShowsItsLinesWithTheirNumbers) {
  const TemporaryFolder folder;
  // Lines of all lengths, so that blocks end anywhere in them.
  std::string text;
  std::vector<std::string> expected;
  for (std::size_t i = 0; i < 3000; ++i) {
    expected.emplace_back(i % 397, static_cast<char>('a' + i % 26));
    text += expected.back() + (i % 3 == 0 ? "\r\n" : "\n");
  }
  expected.emplace_back("no end");
  std::ofstream(folder / "a") << text << "no end";
  std::vector<std::string> found;
  visit_lines(folder / "a", [&](const FileLine& line) {
    found.emplace_back(line.text);
    EXPECT_EQ(line.number, found.size());
  });
  EXPECT_EQ(found, expected);
  EXPECT_EQ(read_lines(folder / "a"), expected);
}

TEST(TextFile, ShowsLinesThatSaySomething) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a") << "# head\n\n  one\n \t\n #no\ntwo\n\n";
  std::vector<std::string> found;
  visit_content_lines(folder / "a", [&](const FileLine& line) {
    found.push_back(line.where().substr(line.where().rfind('/')) + std::string(line.text));
  });
  EXPECT_THAT(found, ::testing::ElementsAre("/a:3  one", "/a:6two"));
  std::ofstream(folder / "empty");
  visit_lines(folder / "empty", [](const FileLine&) { FAIL(); });
}

TEST(TextFile, IsReadAsFarAsItIsLookedAt) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a") << "one\ntwo\n" << std::string(std::size_t{2} << 20, '1');
  EXPECT_THAT(
      error_of([&] { visit_lines(folder / "a", [](const FileLine& line) { fail("{}", line.text); }); }),
      ::testing::StrEq("one"));
}

TEST(TextFile, WithALineTooLongIsRefused) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a") << "one\n"
                              << std::string(static_cast<std::size_t>(limits::kLineLength) + 1, '1');
  EXPECT_THAT(error_of([&] { read_lines(folder / "a"); }),
              HasSubstr("a:2: the line has 1048577 characters, expected at most 1048576"));
  for (const std::size_t length : {1048577, 1048700, 3000000}) {
    std::ofstream(folder / "b") << "one\n" << std::string(length, '1') << "\nthree\n";
    EXPECT_THAT(error_of([&] { read_lines(folder / "b"); }),
                HasSubstr(fmt::format("b:2: the line has {} characters", length)));
  }
  std::ofstream(folder / "b") << std::string(static_cast<std::size_t>(limits::kLineLength), '1') << "\n2";
  EXPECT_EQ(read_lines(folder / "b").size(), 2);
  std::filesystem::resize_file(folder / "b", static_cast<std::uintmax_t>(limits::kTextFileBytes) + 1);
  EXPECT_THAT(error_of([&] { read_lines(folder / "b"); }),
              HasSubstr("b: the file has 4294967297 bytes, expected at most 4294967296"));
}

TEST(TextFile, WithALineTooLongTakesNoMemoryForIt) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a") << "one\n";
  std::filesystem::resize_file(folder / "a", 200'000'004);  // sparse, zeros
  const long before = peak_memory_kb();
  EXPECT_THAT(error_of([&] { read_lines(folder / "a"); }),
              HasSubstr("a:2: the line has 200000000 characters"));
  EXPECT_LT(peak_memory_kb() - before, 100'000);
}

}  // namespace
}  // namespace knuckle
