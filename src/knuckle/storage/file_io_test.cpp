// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/file_io.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>

#include <sys/random.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/flush_testing.h"

namespace knuckle {
namespace {

/// What the system says when it is asked for random bits; the system itself where there is none.
std::optional<std::uint64_t> g_random;

}  // namespace
}  // namespace knuckle

// This takes the place of the system's.
extern "C" ssize_t getrandom(void* bytes, std::size_t count, unsigned flags) {
  if (!knuckle::g_random) return ::syscall(SYS_getrandom, bytes, count, flags);
  std::memcpy(bytes, &*knuckle::g_random, std::min(count, sizeof(*knuckle::g_random)));
  return static_cast<ssize_t>(count);
}

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

std::size_t entries_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(FileIoTest, LinesLoseTheirEndsWhateverTheseAre) {
  const TemporaryFolder folder;
  write_text_file(folder / "lines.txt", "one\r\ntwo\n\nlast");
  EXPECT_THAT(read_lines(folder / "lines.txt"), ElementsAre("one", "two", "", "last"));
}

TEST(FileIoTest, AMissingFileIsNamed) {
  const std::string message = error_of([] { read_text_file("/nowhere/file.txt"); });
  EXPECT_THAT(message, HasSubstr("/nowhere/file.txt"));
  EXPECT_THAT(message, HasSubstr("No such file"));
}

TEST(FileIoTest, AFolderIsNoFile) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { read_text_file(folder.path()); }), HasSubstr("expected a file, found a folder"));
}

TEST(FileIoTest, AFailedWriteLeavesTheFormerFileAndNothingElse) {
  const TemporaryFolder folder;
  write_text_file(folder / "model.model", "former");
  const auto fail_half_way = [](const std::filesystem::path& temporary) {
    std::ofstream(temporary) << "half";
    fail("the writer broke");
  };
  EXPECT_THAT(error_of([&] { write_file_atomically(folder / "model.model", fail_half_way); }),
              HasSubstr("the writer broke"));
  EXPECT_EQ(read_text_file(folder / "model.model"), "former");
  EXPECT_EQ(entries_in(folder.path()), 1u);
}

TEST(FileIoTest, AnUnwritableFolderIsNamedAndNothingIsLeft) {
  EXPECT_THAT(error_of([] { write_text_file("/proc/knuckle.txt", "text"); }), HasSubstr("/proc/knuckle.txt"));
  EXPECT_THAT(error_of([] { make_folder("/proc/knuckle/out"); }), HasSubstr("/proc/knuckle/out"));
}

TEST(FileIoTest, WhetherAFileCanBeWrittenIsKnownBefore) {
  const TemporaryFolder folder;
  check_writable(folder / "new.txt");
  EXPECT_EQ(entries_in(folder.path()), 0u);
  write_text_file(folder / "old.txt", "former");
  check_writable(folder / "old.txt");
  EXPECT_EQ(read_text_file(folder / "old.txt"), "former");
  EXPECT_EQ(entries_in(folder.path()), 1u);
  EXPECT_THAT(error_of([&] { check_writable(folder.path()); }), HasSubstr("it is a folder"));
  EXPECT_THAT(error_of([&] { check_writable(folder / "none/new.txt"); }),
              HasSubstr("new.txt: cannot write: No such file or directory"));
}

TEST(FileIoTest, ADiskThatFillsUpLeavesTheFormerFileAndNothingElse) {
  const TemporaryFolder folder;
  write_text_file(folder / "file.txt", "former");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  ASSERT_NE(std::signal(SIGXFSZ, SIG_IGN), SIG_ERR);
  const rlimit tight{1000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
  const std::string message =
      error_of([&] { write_text_file(folder / "file.txt", std::string(100000, 'x')); });
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_THAT(message, HasSubstr("file.txt: cannot write: File too large"));
  EXPECT_EQ(read_text_file(folder / "file.txt"), "former");
  EXPECT_EQ(entries_in(folder.path()), 1u);
}

TEST(FileIoTest, AFullDiskIsAnErrorThatNamesTheFile) {
  const TemporaryFolder folder;
  const auto fill_the_disk = [](const std::filesystem::path& temporary) {
    std::filesystem::remove(temporary);
    std::filesystem::create_symlink("/dev/full", temporary);
    std::ofstream stream(temporary);
    stream << "text";
    stream.close();
    if (!stream) fail("report.html: cannot write: the disk is full");
  };
  EXPECT_THAT(error_of([&] { write_file_atomically(folder / "report.html", fill_the_disk); }),
              HasSubstr("report.html"));
  EXPECT_EQ(entries_in(folder.path()), 0u);
}

TEST(FileIoTest, ADiskThatDoesNotTakeTheContentLeavesTheFormerFileAndNothingElse) {
  const TemporaryFolder folder;
  write_text_file(folder / "file.txt", "former");
  testing::disk_fails = true;
  const std::string message = error_of([&] { write_text_file(folder / "file.txt", "text"); });
  testing::disk_fails = false;
  EXPECT_THAT(message, HasSubstr("file.txt: cannot write: Input/output error"));
  EXPECT_EQ(read_text_file(folder / "file.txt"), "former");
  EXPECT_EQ(entries_in(folder.path()), 1u);
}

TEST(FileIoTest, AFileTakesTheNameOfNoFolder) {
  const TemporaryFolder folder;
  make_folder(folder / "name");
  EXPECT_THAT(error_of([&] { write_text_file(folder / "name", "text"); }),
              HasSubstr("name: cannot write: Is a directory"));
  EXPECT_THAT(error_of([&] { publish_file(folder / "none", folder / "file.txt"); }),
              HasSubstr("file.txt: cannot write: No such file or directory"));
  EXPECT_EQ(entries_in(folder.path()), 1u);
}

TEST(FileIoTest, TemporaryNamesCannotBeGuessed) {
  const TemporaryFolder folder;
  std::vector<std::string> names;
  for (int i = 0; i < 2; ++i) {
    write_file_atomically(folder / "file.txt", [&](const std::filesystem::path& temporary) {
      EXPECT_TRUE(std::filesystem::is_regular_file(temporary)) << "it is ours before anybody writes";
      EXPECT_EQ(temporary.extension(), ".txt");
      names.push_back(temporary.string());
      std::ofstream(temporary) << "text";
    });
  }
  EXPECT_NE(names[0], names[1]);
  EXPECT_EQ(names[0].find(std::to_string(::getpid())), std::string::npos);
  EXPECT_EQ(entries_in(folder.path()), 1u);
}

TEST(FileIoTest, ATemporaryFileIsANewOne) {
  const TemporaryFolder folder;
  write_text_file(folder / "others.txt", "not ours");
  g_random = 5;
  const std::filesystem::path guessed = folder / ".file.0000000000000005.partial.txt";
  std::filesystem::create_symlink(folder / "others.txt", guessed);
  const std::string through_a_link = error_of([&] { write_text_file(folder / "file.txt", "text"); });
  std::filesystem::remove(guessed);
  std::filesystem::create_symlink(folder / "nothing.txt", guessed);
  const std::string to_nothing = error_of([&] { write_text_file(folder / "file.txt", "text"); });
  std::filesystem::remove(guessed);
  write_text_file(folder / "file.txt", "text");
  g_random.reset();
  EXPECT_THAT(through_a_link, HasSubstr("file.txt: cannot write: File exists"));
  EXPECT_THAT(to_nothing, HasSubstr("file.txt: cannot write: File exists"));
  EXPECT_EQ(read_text_file(folder / "others.txt"), "not ours");
  EXPECT_EQ(entries_in(folder.path()), 2u) << "the name was the one that was guessed";
}

TEST(FileIoTest, TheFileIsOnTheDiskBeforeItsNameAndTheFolderAfterIt) {
  const TemporaryFolder folder;
  const std::filesystem::path real = std::filesystem::canonical(folder.path());
  std::filesystem::path temporary;
  std::vector<std::filesystem::path> flushed;
  testing::on_flush = [&](const std::filesystem::path& path) { flushed.push_back(path); };
  write_file_atomically(real / "file.txt", [&](const std::filesystem::path& path) {
    temporary = path;
    std::ofstream(path) << "text";
  });
  testing::on_flush = nullptr;
  EXPECT_THAT(flushed, ElementsAre(temporary, real));
}

}  // namespace
}  // namespace knuckle
