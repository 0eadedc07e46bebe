// SPDX-License-Identifier: Apache-2.0
// `knuckle record` and `knuckle live --record`: raw frames, all of them, whatever ends the run.
#include "program.h"

#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

class RecordTest : public ::testing::Test {
 protected:
  /// A set of 12 frames with times in `made.h5`.
  void SetUp() override {
    ASSERT_THAT(run_program({"render", "--manifest", "manifests/demo.toml", "--count", "12", "--out",
                             path("made.h5")}),
                Succeeded());
    fs::remove(path("made.h5.options.toml"));
  }

  std::string path(const std::string& name) const { return folder_ / name; }
  std::string made(const std::string& settings = "?rate=100") const {
    return "h5:" + path("made.h5") + settings;
  }

  /// Frame by frame the same depth, infrared and camera.
  void expect_same_frames(const std::string& source, std::int64_t count) const {
    const auto expected = open_source("h5:" + path("made.h5"));
    const auto recorded = open_source(source);
    ASSERT_EQ(recorded->size(), count);
    for (std::int64_t i = 0; i < count; ++i) {
      const Frame a = expected->read(i % expected->size());
      const Frame b = recorded->read(i);
      ASSERT_EQ(a.depth_mm, b.depth_mm) << i;
      ASSERT_EQ(a.infrared, b.infrared) << i;
      ASSERT_EQ(a.camera, b.camera) << i;
      ASSERT_FALSE(b.truth.has_value());
    }
  }

  TemporaryFolder folder_;
};

TEST_F(RecordTest, KeepsEveryFrameToTheBit) {
  const ProgramRun run = run_program({"record", "--source", made(), "--out", path("a.h5")});
  ASSERT_THAT(run, Succeeded());
  EXPECT_THAT(run.out, HasSubstr("a.h5: 12 of 12 frames in "));
  EXPECT_EQ(run.error, "");
  expect_same_frames("h5:" + path("a.h5"), 12);
  ASSERT_THAT(run_program({"record", "--source", made(), "--out", path("b")}), Succeeded());
  expect_same_frames("folder:" + path("b"), 12);
  EXPECT_THAT(entries_of(folder_.path()), ElementsAre("a.h5", "b", "made.h5"));
  const auto recorded = open_source("h5:" + path("a.h5"));
  EXPECT_EQ(recorded->read(0).time_s, 0.0);
  EXPECT_EQ(recorded->read(3).time_s, 0.03);
}

TEST_F(RecordTest, ALoopIsRecordedAsSequences) {
  ASSERT_THAT(
      run_program({"record", "--source", made("?rate=200&loop=1"), "--out", path("a.h5"), "--frames", "30"}),
      Succeeded());
  expect_same_frames("h5:" + path("a.h5"), 30);
  const auto recorded = open_source("h5:" + path("a.h5"));
  EXPECT_EQ(recorded->read(11).sequence, recorded->read(0).sequence);
  EXPECT_GT(recorded->read(12).sequence, recorded->read(11).sequence);
}

TEST_F(RecordTest, CtrlCEndsItWithAWholeSet) {
  for (const std::string out : {"a.h5", "b"}) {
    const std::string log = path(out == "b" ? "b.recording.h5.partial" : out + ".partial");
    const ProgramRun run =
        run_program_until([&] { return fs::exists(log) && fs::file_size(log) > 100000; },
                          {"record", "--source", made("?rate=50&loop=1"), "--out", path(out)}, SIGINT);
    ASSERT_THAT(run, Succeeded());
    EXPECT_FALSE(fs::exists(log));
    const auto recorded = open_source((out == "b" ? "folder:" : "h5:") + path(out));
    EXPECT_GE(recorded->size(), 1);
    expect_same_frames((out == "b" ? "folder:" : "h5:") + path(out), recorded->size());
  }
}

TEST_F(RecordTest, WhatAKillLeftIsFinished) {
  const std::string log = path("a.h5.partial");
  const ProgramRun run =
      run_program_until([&] { return fs::exists(log) && fs::file_size(log) > 100000; },
                        {"record", "--source", made("?rate=50&loop=1"), "--out", path("a.h5")});
  EXPECT_EQ(run.status, 128 + SIGKILL);
  EXPECT_THAT(entries_of(folder_.path()), ElementsAre("a.h5.partial", "made.h5"));
  EXPECT_THAT(run_program({"record", "--source", made(), "--out", path("a.h5")}),
              FailedWith("is left of a recording that was cut short; `knuckle record --finish"));
  const ProgramRun finish = run_program({"record", "--finish", path("a.h5")});
  ASSERT_THAT(finish, Succeeded());
  const auto recorded = open_source("h5:" + path("a.h5"));
  EXPECT_THAT(finish.out, HasSubstr(fmt::format("a.h5: {} frames", recorded->size())));
  expect_same_frames("h5:" + path("a.h5"), recorded->size());
  EXPECT_THAT(run_program({"record", "--finish", path("a.h5")}), FailedWith("no such recording"));
}

TEST_F(RecordTest, AFullDiskIsOneLineAndKeepsWhatIsReadable) {
  for (const std::string verb : {"record", "live"}) {
    const std::string name = verb + ".h5";
    const ProgramRun run = run_program_on_full_disk(
        80, {verb, "--source", made("?rate=50&loop=1"), verb == "live" ? "--record" : "--out", path(name)});
    EXPECT_THAT(run, FailedWith(name + ".partial: cannot write"));
    EXPECT_THAT(run.error, HasSubstr("knuckle record --finish"));
    EXPECT_FALSE(fs::exists(path(name)));
    ASSERT_THAT(run_program({"record", "--finish", path(name)}), Succeeded());
    const auto recorded = open_source("h5:" + path(name));
    expect_same_frames("h5:" + path(name), recorded->size());
  }
}

TEST_F(RecordTest, ADiskThatFillsUpLosesNothingThatWasWritten) {
  const SmallDisk disk(path("disk"));
  if (!disk.mount(300)) GTEST_SKIP() << "this machine allows no disk of a test's own";
  const std::string out = path("disk/a.h5");
  const ProgramRun run = run_program({"record", "--source", made("?rate=50&loop=1"), "--out", out});
  EXPECT_THAT(run, FailedWith("a.h5"));
  EXPECT_THAT(entries_of(path("disk")), ElementsAre("a.h5.partial"));
  EXPECT_THAT(run_program({"record", "--finish", out}), FailedWith("a.h5"));
  ASSERT_TRUE(disk.resize(3000));
  ASSERT_THAT(run_program({"record", "--finish", out}), Succeeded());
  EXPECT_THAT(entries_of(path("disk")), ElementsAre("a.h5"));
  expect_same_frames("h5:" + out, open_source("h5:" + out)->size());
}

TEST_F(RecordTest, LiveRecordsEveryFrameAlsoThoseThatArePassedOver) {
  const ProgramRun run = run_program({"live", "--source", made("?rate=300"), "--record", path("a.h5")});
  ASSERT_THAT(run, Succeeded());
  expect_same_frames("h5:" + path("a.h5"), 12);
}

TEST_F(RecordTest, OfFramesOfWhichNoneCanBeReadTheFirstSaysWhy) {
  ASSERT_THAT(run_program({"record", "--source", made(), "--out", path("b")}), Succeeded());
  for (const auto& entry : fs::recursive_directory_iterator(path("b")))
    if (entry.path().extension() == ".png") write_text_file(entry.path(), "no image");
  const ProgramRun run =
      run_program({"record", "--source", "folder:" + path("b") + "?rate=100", "--out", path("a.h5")});
  EXPECT_THAT(run, FailedWith("12 frames could not be read; the first: "));
  EXPECT_THAT(run.error, HasSubstr("000000"));
  EXPECT_FALSE(fs::exists(path("a.h5")));
}

TEST_F(RecordTest, FaultsAreOneLine) {
  EXPECT_THAT(run_program({"record", "--source", made(), "--out", path("made.h5")}),
              FailedWith("made.h5: is there already"));
  EXPECT_THAT(run_program({"record", "--source", made(), "--out", path("none/a.h5")}),
              FailedWith("none/a.h5"));
  EXPECT_THAT(run_program({"record", "--source", "h5:" + path("none.h5"), "--out", path("a.h5")}),
              FailedWith("none.h5"));
  EXPECT_EQ(run_program({"record", "--source", made()}).status, 2);
  EXPECT_EQ(run_program({"record", "--out", path("a.h5")}).status, 2);
  EXPECT_EQ(run_program({"record", "--finish", path("a.h5"), "--out", path("a.h5")}).status, 2);
  EXPECT_EQ(run_program({"live", "--source", made(), "--record", path("a.h5"), "--record-folder", path("d")})
                .status,
            2);
  EXPECT_THAT(run_program({"live", "--source", made(), "--record", path("made.h5")}),
              FailedWith("made.h5: is there already"));
  EXPECT_THAT(entries_of(folder_.path()), ElementsAre("made.h5"));
}

}  // namespace
}  // namespace knuckle::testing
