// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_journal.h"

#include <csignal>
#include <fstream>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/label/label_testing.h"
#include "knuckle/storage/flush_testing.h"

namespace knuckle {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

LabelChange change_at(std::int64_t frame, std::int64_t revision, double u) {
  LabelChange change{.frame = frame, .revision = revision, .author = "ann", .time = "now"};
  change.landmarks.resize(kSupersetSize);
  change.landmarks[0] = {.at = {u, 1, 500}, .state = LabelState::corrected};
  return change;
}

class LabelJournalTest : public ::testing::Test {
 protected:
  LabelHead head_ = testing::closing_hand_head(4);
  testing::TemporaryFolder folder_;
  fs::path path_ = folder_ / "labels.jsonl";
};

TEST_F(LabelJournalTest, EveryChangeIsOnTheDiskAtOnceAndReadAgain) {
  {
    LabelJournal journal(path_, head_);
    journal.add(change_at(1, 1, 1.23456789));
    EXPECT_EQ(read_label_file(path_).find({1})->newest().landmarks[0].at.u, 1.2346);
    EXPECT_EQ(journal.book().find({1})->newest().landmarks[0].at.u, 1.2346) << "memory and file are the same";
    journal.add_all({change_at(1, 2, 2), change_at(3, 1, 3)});
    EXPECT_EQ(journal.waiting(), 0U);
  }
  const LabelJournal again(path_, head_);
  EXPECT_EQ(again.book().hands().size(), 2U);
  EXPECT_EQ(again.book().find({1})->revision(), 2);
}

TEST_F(LabelJournalTest, EveryChangeIsHandedToTheDiskAndSoIsTheNameOfANewFile) {
  std::vector<fs::path> flushed;
  testing::on_flush = [&](const fs::path& path) { flushed.push_back(path); };
  {
    LabelJournal journal(path_, head_);
    journal.add(change_at(1, 1, 1));
  }
  testing::on_flush = nullptr;
  const fs::path real = fs::canonical(folder_.path());
  EXPECT_THAT(flushed, ::testing::ElementsAre(real / "labels.jsonl", real, real / "labels.jsonl"));
}

TEST_F(LabelJournalTest, AKillAtAnyMomentLosesNoChangeThatWasTold) {
  Random random(5);
  std::int64_t told = 0;
  for (int round = 0; round < 12; ++round) {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      LabelJournal journal(path_, head_);
      const HandHistory* const history = journal.book().find({1});
      for (std::int64_t revision = history == nullptr ? 1 : history->revision() + 1;; ++revision) {
        journal.add(change_at(1, revision, static_cast<double>(revision)));
        if (::write(ends[1], &revision, sizeof(revision)) < 0) std::_Exit(1);
      }
    }
    ::close(ends[1]);
    const auto another_is_told = [&] {
      std::int64_t revision = 0;
      if (::read(ends[0], &revision, sizeof(revision)) != sizeof(revision)) return false;
      told = std::max(told, revision);
      return true;
    };
    EXPECT_TRUE(round % 2 == 0 || another_is_told());  // on a slow machine none may be in time
    ::usleep(static_cast<useconds_t>(2000 + random.below(20000)));
    ::kill(child, SIGKILL);
    while (another_is_told()) continue;
    ::close(ends[0]);
    ::waitpid(child, nullptr, 0);
    const LabelJournal journal(path_, head_);
    const HandHistory* const history = journal.book().find({1});
    const std::int64_t found = history == nullptr ? 0 : history->revision();
    EXPECT_GE(found, told);
    EXPECT_LE(found, told + 1) << "at most one was on its way";
    told = found;
  }
  EXPECT_GT(told, 0);
}

TEST_F(LabelJournalTest, ATornLineIsCutAndWorkGoesOn) {
  { LabelJournal(path_, head_).add(change_at(1, 1, 1)); }
  std::ofstream(path_, std::ios::app) << R"({"frame":1,"side":"ri)";
  LabelJournal journal(path_, head_);
  journal.add(change_at(1, 2, 2));
  EXPECT_EQ(read_label_file(path_).find({1})->revision(), 2);
}

TEST_F(LabelJournalTest, OnAFullDiskWorkWaitsInMemoryUntilThereIsRoom) {
  LabelJournal journal(path_, head_);
  journal.add(change_at(1, 1, 1));
  const auto before = fs::file_size(path_);
  rlimit usual{};
  ::getrlimit(RLIMIT_FSIZE, &usual);
  const auto handler = ::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{before + 100, usual.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &full);
  journal.add(change_at(1, 2, 2));
  journal.add(change_at(2, 1, 3));
  EXPECT_EQ(journal.waiting(), 2U);
  EXPECT_THAT(journal.fault(), HasSubstr("labels.jsonl: cannot write"));
  EXPECT_EQ(fs::file_size(path_), before) << "nothing half-written";
  EXPECT_EQ(journal.book().find({1})->revision(), 2) << "in memory it counts";
  ::setrlimit(RLIMIT_FSIZE, &usual);
  ::signal(SIGXFSZ, handler);
  EXPECT_TRUE(journal.flush());
  EXPECT_EQ(journal.fault(), "");
  EXPECT_EQ(read_label_file(path_).hands().size(), 2U);
}

TEST_F(LabelJournalTest, AFileThatVanishedIsSaid) {
  LabelJournal journal(path_, head_);
  fs::remove(path_);
  journal.add(change_at(1, 1, 1));
  EXPECT_THAT(journal.fault(), HasSubstr("cannot write"));
}

TEST_F(LabelJournalTest, AFolderThatCannotBeWrittenIsNamedAtTheStart) {
  EXPECT_THAT(testing::error_of([&] { LabelJournal("/proc/labels.jsonl", head_); }),
              HasSubstr("/proc/labels.jsonl: cannot write"));
}

TEST_F(LabelJournalTest, LabelsOfAnotherSourceAreRefused) {
  { LabelJournal(path_, head_).add(change_at(1, 1, 1)); }
  LabelHead other = head_;
  other.frames = 7;
  EXPECT_THAT(testing::error_of([&] { LabelJournal(path_, other); }), HasSubstr("with 4 frames"));
  other = head_;
  other.convention = convention_from_name("icg20");
  EXPECT_THAT(testing::error_of([&] { LabelJournal(path_, other); }), HasSubstr("--convention knuckle22"));
  other = head_;
  other.fingerprint = "changed";
  EXPECT_THAT(testing::error_of([&] { LabelJournal(path_, other); }), HasSubstr("--accept-changed-source"));
  { LabelJournal(path_, other, ChangedSource::accept).add(change_at(1, 2, 1)); }
  EXPECT_EQ(LabelJournal(path_, other).book().find({1})->revision(), 2);
  EXPECT_THAT(testing::error_of([&] { LabelJournal(path_, head_); }), HasSubstr("have changed"));
}

TEST_F(LabelJournalTest, TwoProgramsDoNotWriteTheSameFile) {
  const LabelJournal first(path_, head_);
  EXPECT_THAT(testing::error_of([&] { LabelJournal(path_, head_); }), HasSubstr("another program"));
}

TEST_F(LabelJournalTest, AuthorsHaveFilesOfTheirOwn) {
  EXPECT_EQ(label_file("d", ""), fs::path("d/labels.jsonl"));
  EXPECT_EQ(label_file("d", "ann"), fs::path("d/labels.ann.jsonl"));
  EXPECT_THAT(testing::error_of([] { (void)label_file("d", "../x"); }), HasSubstr("author '../x'"));
  EXPECT_THAT(testing::error_of([&] { (void)label_files(folder_.path()); }), HasSubstr("holds no labels"));
  { const LabelJournal one(label_file(folder_.path(), "bea"), head_); }
  { const LabelJournal two(label_file(folder_.path(), ""), head_); }
  EXPECT_EQ(label_files(folder_.path()).size(), 2U);
  EXPECT_THAT(testing::error_of([&] { (void)label_files(folder_ / "none"); }),
              HasSubstr("none: cannot be read: No such file"));
}

TEST_F(LabelJournalTest, AFileWithoutAWholeLineHoldsNoLabels) {
  std::ofstream(path_) << to_json_line(head_);  // its end is missing
  EXPECT_THAT(testing::error_of([&] { (void)read_label_file(path_); }),
              HasSubstr("labels.jsonl: holds no labels: it has not one whole line"));
}

}  // namespace
}  // namespace knuckle
