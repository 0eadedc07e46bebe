// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/growing_files.h"

#include <fstream>

#include <sys/wait.h>
#include <unistd.h>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/flush_testing.h"

namespace knuckle {
namespace {

namespace fs = std::filesystem;
using Begin = GrowingFiles::Begin;
using ::testing::HasSubstr;

class GrowingFilesTest : public ::testing::Test {
 protected:
  fs::path path(const std::string& name) const { return folder_ / name; }

  GrowingFiles open(Begin begin, const RunIdentity& identity = {{"version", "1"}, {"source", "x"}}) const {
    return {path("journal"), {{path("a"), "# head\n"}, {path("b"), ""}}, identity, begin};
  }

  static std::vector<std::string> pieces_of(std::int64_t i) {
    return {fmt::format("a{}\n", i), i % 3 == 0 ? "" : fmt::format("b{} {}\n", i, std::string(i % 7, '.'))};
  }

  static void grow(GrowingFiles& files, std::int64_t count) {
    while (files.size() < count) {
      files.append(pieces_of(files.size()), fmt::format("note {}", files.size()));
    }
  }

  static std::string expected(std::size_t file, std::int64_t count) {
    std::string text = file == 0 ? "# head\n" : "";
    for (std::int64_t i = 0; i < count; ++i) text += pieces_of(i)[file];
    return text;
  }

  void expect_published(std::int64_t count) const {
    EXPECT_EQ(read_text_file(path("a")), expected(0, count));
    EXPECT_EQ(read_text_file(path("b")), expected(1, count));
    for (const char* left : {"journal", "a.partial", "b.partial"}) EXPECT_FALSE(fs::exists(path(left)));
  }

  testing::TemporaryFolder folder_;
};

TEST_F(GrowingFilesTest, WhatIsWrittenIsOnTheDiskAtOnceAndGetsItsNameInTheEnd) {
  GrowingFiles files = open(Begin::anew);
  EXPECT_EQ(read_text_file(path("a.partial")), "# head\n");
  grow(files, 5);
  EXPECT_EQ(read_text_file(path("a.partial")), expected(0, 5));
  EXPECT_EQ(read_text_file(path("b.partial")), expected(1, 5));
  EXPECT_FALSE(fs::exists(path("a")));
  std::vector<std::string> notes;
  files.for_each_note([&](std::string_view note) { notes.emplace_back(note); });
  EXPECT_THAT(notes, ::testing::ElementsAre("note 0", "note 1", "note 2", "note 3", "note 4"));
  files.publish();
  expect_published(5);
}

TEST_F(GrowingFilesTest, RecordsAreOnTheDiskBeforeTheirNamesAndNamesBeforeTheJournalGoes) {
  GrowingFiles files = open(Begin::anew);
  grow(files, 2);
  std::vector<fs::path> flushed;
  testing::on_flush = [&](const fs::path& path) {
    flushed.push_back(path);
    EXPECT_TRUE(fs::exists(folder_ / "journal"));
    EXPECT_EQ(fs::exists(folder_ / "a"), flushed.size() > 3);
    EXPECT_EQ(fs::exists(folder_ / "b"), flushed.size() > 4);
  };
  files.publish();
  testing::on_flush = nullptr;
  const fs::path real = fs::canonical(folder_.path());
  EXPECT_THAT(flushed,
              ::testing::ElementsAre(real / "a.partial", real / "b.partial", real / "journal", real, real));
}

TEST_F(GrowingFilesTest, ADiskThatTakesNothingLeavesTheRunAsItWas) {
  GrowingFiles files = open(Begin::anew);
  grow(files, 2);
  testing::disk_fails = true;
  const std::string fault = testing::error_of([&] { files.publish(); });
  testing::disk_fails = false;
  EXPECT_THAT(fault, ::testing::HasSubstr("a.partial: cannot write: Input/output error"));
  EXPECT_FALSE(fs::exists(path("a")));
  files.publish();
  expect_published(2);
}

TEST_F(GrowingFilesTest, FilesCutAnywhereGoOnFromTheLastRecordThatIsWholeInAll) {
  constexpr std::int64_t kRecords = 12;
  {
    GrowingFiles files = open(Begin::anew);
    grow(files, kRecords);
  }
  for (const char* name : {"journal", "a.partial", "b.partial"})
    fs::copy(path(name), path(std::string(name) + ".kept"));
  Random random(7, 0);
  for (const std::string cut : {"journal", "a.partial", "b.partial"}) {
    for (int i = 0; i < 15; ++i) {
      for (const char* name : {"journal", "a.partial", "b.partial"}) {
        fs::copy(path(std::string(name) + ".kept"), path(name), fs::copy_options::overwrite_existing);
      }
      const auto size = static_cast<std::uint32_t>(fs::file_size(path(cut)));
      fs::resize_file(path(cut), random.below(size + 1));
      GrowingFiles files = open(Begin::where_it_stopped);
      std::int64_t notes = 0;
      files.for_each_note([&](std::string_view note) { EXPECT_EQ(note, fmt::format("note {}", notes++)); });
      EXPECT_EQ(notes, files.size());
      EXPECT_EQ(read_text_file(path("a.partial")), expected(0, files.size())) << cut;
      EXPECT_EQ(read_text_file(path("b.partial")), expected(1, files.size())) << cut;
      grow(files, kRecords);
      files.publish();
      expect_published(kRecords);
    }
  }
}

TEST_F(GrowingFilesTest, AProcessThatIsKilledAtAnyTimeLosesNoWholeRecord) {
  constexpr std::int64_t kRecords = 3000;
  Random random(11, 0);
  for (int kill = 0; kill < 6; ++kill) {
    const pid_t child = ::fork();
    if (child == 0) {
      GrowingFiles files = open(Begin::where_it_stopped);
      grow(files, kRecords);
      files.publish();
      std::_Exit(0);
    }
    ::usleep(random.below(20000));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    if (fs::exists(path("a")) && !fs::exists(path("journal"))) break;
  }
  if (!fs::exists(path("a")) || fs::exists(path("journal"))) {
    GrowingFiles files = open(Begin::where_it_stopped);
    if (files.size() < kRecords) grow(files, kRecords);
    files.publish();
  }
  expect_published(kRecords);
}

TEST_F(GrowingFilesTest, ARunThatWasStoppedBetweenTwoNamesGivesTheOthers) {
  {
    GrowingFiles files = open(Begin::anew);
    grow(files, 4);
    make_folder(path("b"));  // no file can be named so
    EXPECT_THAT(testing::error_of([&] { files.publish(); }), HasSubstr("/b: cannot write"));
  }
  EXPECT_TRUE(fs::exists(path("a")));
  fs::remove(path("b"));
  {
    GrowingFiles files = open(Begin::where_it_stopped);
    EXPECT_EQ(files.size(), 4);
    files.publish();
  }
  expect_published(4);
}

TEST_F(GrowingFilesTest, AFileThatWasChangedAfterItGotItsNameIsRefused) {
  {
    GrowingFiles files = open(Begin::anew);
    grow(files, 4);
    make_folder(path("b"));
    EXPECT_THAT(testing::error_of([&] { files.publish(); }), HasSubstr("/b: cannot write"));
  }
  fs::remove(path("b"));
  std::ofstream(path("a"), std::ios::app) << "one line more\n";
  EXPECT_THAT(testing::error_of([&] { open(Begin::where_it_stopped); }),
              HasSubstr("/a: is missing or was changed after the run that wrote it"));
}

TEST_F(GrowingFilesTest, AnotherIdentityIsRefusedAndNamed) {
  {
    GrowingFiles files = open(Begin::anew);
    grow(files, 3);
  }
  const std::string fault = testing::error_of([&] {
    open(Begin::where_it_stopped, {{"version", "2"}, {"source", "x"}});
  });
  EXPECT_THAT(fault, HasSubstr("journal: the run was begun with another version: '1', now it is '2'"));
  EXPECT_THAT(testing::error_of([&] {
                open(Begin::where_it_stopped, {{"version", "1"}});
              }),
              HasSubstr("another source: 'x', now it is ''"));
  GrowingFiles files = open(Begin::where_it_stopped);
  EXPECT_EQ(files.size(), 3) << "the refusals did no harm";
}

TEST_F(GrowingFilesTest, BegunAnewItReplacesWhatAnEarlierRunLeft) {
  {
    GrowingFiles files = open(Begin::anew);
    grow(files, 3);
  }
  GrowingFiles files = open(Begin::anew, {{"version", "2"}});
  EXPECT_EQ(files.size(), 0);
  EXPECT_EQ(read_text_file(path("a.partial")), "# head\n");
}

TEST_F(GrowingFilesTest, TwoRunsCannotWriteTheSameFiles) {
  const GrowingFiles files = open(Begin::anew);
  EXPECT_THAT(testing::error_of([&] { open(Begin::where_it_stopped); }),
              HasSubstr("another run is writing it"));
}

TEST_F(GrowingFilesTest, AFileThatVanishesIsNoticedAtOnce) {
  GrowingFiles files = open(Begin::anew);
  grow(files, 2);
  fs::remove(path("b.partial"));
  EXPECT_THAT(testing::error_of([&] { grow(files, 3); }), HasSubstr("b.partial: cannot write: it vanished"));
  std::ofstream(path("b.partial")) << "of somebody else";
  EXPECT_THAT(testing::error_of([&] { grow(files, 3); }), HasSubstr("b.partial: cannot write: it vanished"));
}

TEST_F(GrowingFilesTest, WhereAFileCannotBeWrittenNothingStays) {
  const std::string fault = testing::error_of([&] {
    GrowingFiles(path("journal"), {{path("a"), ""}, {path("none/b"), ""}}, {}, Begin::anew);
  });
  EXPECT_THAT(fault, HasSubstr("none/b.partial: cannot write"));
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(GrowingFilesTest, ARecordHasAPieceForEachFileAndANoteOfOneLine) {
  constexpr const char* kExpected = "journal: expected one piece per file and a note of one line";
  GrowingFiles files = open(Begin::anew);
  const std::vector<std::string> pieces = pieces_of(1);
  EXPECT_THAT(testing::error_of([&] { files.append(std::span(pieces).first(1), "note"); }),
              HasSubstr(kExpected));
  EXPECT_THAT(testing::error_of([&] { files.append(pieces, "two\nlines"); }), HasSubstr(kExpected));
  files.append(pieces, "note");
  files.publish();
  EXPECT_THAT(testing::error_of([&] { files.append(pieces, "note"); }), HasSubstr(kExpected));
}

TEST_F(GrowingFilesTest, NotesThatAreGoneAreNotReadBack) {
  GrowingFiles files = open(Begin::anew);
  grow(files, 3);
  fs::resize_file(path("journal"), fs::file_size(path("journal")) - 10);
  EXPECT_THAT(testing::error_of([&] { files.for_each_note([](std::string_view) {}); }),
              HasSubstr("journal: cannot be read back"));
}

TEST_F(GrowingFilesTest, AFolderInPlaceOfAFileIsNamed) {
  fs::create_directory(path("journal"));
  EXPECT_THAT(testing::error_of([&] { open(Begin::anew); }),
              HasSubstr("journal: cannot write: Is a directory"));
  fs::remove(path("journal"));
  {
    GrowingFiles files = open(Begin::anew);
    grow(files, 1);
  }
  fs::remove(path("b.partial"));
  fs::create_directory(path("b.partial"));
  EXPECT_THAT(testing::error_of([&] { open(Begin::where_it_stopped); }),
              HasSubstr("b.partial: cannot write: Is a directory"));
  EXPECT_TRUE(fs::exists(path("journal"))) << "what was written is still there to go on from";
}

}  // namespace
}  // namespace knuckle
