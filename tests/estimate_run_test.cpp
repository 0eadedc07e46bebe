// SPDX-License-Identifier: Apache-2.0
// `estimate` when things go wrong: killed, interrupted, with frames that cannot be read, with outputs that
// cannot be written.
#include "program.h"

#include <cerrno>
#include <cstring>

#include <nlohmann/json.hpp>

#include "knuckle/core/random.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::Not;

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kFrames = 100;
constexpr int kKilled = 128 + SIGKILL;

std::uintmax_t size_of(const fs::path& path) {
  std::error_code missing;
  const std::uintmax_t size = fs::file_size(path, missing);
  return missing ? 0 : size;
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  EXPECT_NE(text.find(from), std::string::npos) << from;
  return text.replace(text.find(from), from.size(), to);
}

class EstimateRunTest : public ::testing::Test {
 protected:
  void SetUp() override {
    write_text_file(
        path("manifest.toml"),
        fmt::format("frames = {}\nseed = 3\n[body]\npeople = 1\n[camera]\nwidth = 160\nheight = 120\n"
                    "fx = 112\nfy = 112\ncx = 79.5\ncy = 59.5\n",
                    kFrames));
    write_text_file(path("pipeline.toml"), shipped_pipeline("default"));
  }

  /// A pipeline that may be copied anywhere.
  static std::string shipped_pipeline(const std::string& name) {
    const std::string models = fs::absolute("models").string() + "/";
    std::string pipeline = read_text_file("pipelines/" + name + ".toml");
    while (pipeline.find("\"../models/") != std::string::npos)
      pipeline = with(pipeline, "\"../models/", "\"" + models);
    return pipeline;
  }

  std::string path(const std::string& name) const { return folder_ / name; }
  std::string source() const { return "synthetic:" + path("manifest.toml"); }

  /// Poses, records and summary as NAME.txt, NAME.jsonl, NAME.json.
  std::vector<std::string> command(const std::string& name, const std::vector<std::string>& more = {}) const {
    return command_on(source(), name, more);
  }
  std::vector<std::string> command_on(const std::string& of, const std::string& name,
                                      const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"estimate",
                                          "--source",
                                          of,
                                          "--pipeline",
                                          path("pipeline.toml"),
                                          "--out",
                                          path(name + ".txt"),
                                          "--records",
                                          path(name + ".jsonl"),
                                          "--json",
                                          path(name + ".json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  /// The same with another value of an option that it has.
  static std::vector<std::string> changed(std::vector<std::string> arguments, const std::string& option,
                                          const std::string& value) {
    *std::next(std::ranges::find(arguments, option)) = value;
    return arguments;
  }

  void expect_same_outputs(const std::string& name, const std::string& as) const {
    for (const char* extension : {".txt", ".jsonl"}) {
      EXPECT_TRUE(read_text_file(path(name + extension)) == read_text_file(path(as + extension)))
          << extension;
    }
    Json summary = Json::parse(read_text_file(path(name + ".json")));
    Json expected = Json::parse(read_text_file(path(as + ".json")));
    summary.erase("median_ms");
    expected.erase("median_ms");
    EXPECT_EQ(summary, expected);
    // A kill while the summary is put into place may leave `.run.RANDOM.partial.json`.
    const auto is_of_a_kill = MatchesRegex("\\.run\\.[0-9a-f]+\\.partial\\.json");
    EXPECT_THAT(entries_of(folder_.path()), Not(Contains(AllOf(HasSubstr(".partial"), Not(is_of_a_kill)))));
    EXPECT_THAT(entries_of(folder_.path()), Not(Contains(HasSubstr(".resume"))));
  }

  /// Ends a run when about this many bytes of poses are written.
  ProgramRun run_until(std::uintmax_t bytes, const std::string& name, int signal = SIGKILL,
                       const std::vector<std::string>& more = {}) const {
    return run_program_until([&] { return size_of(path(name + ".txt.partial")) > bytes; },
                             command(name, more), signal);
  }

  /// A run that was killed at about the middle.
  void leave_half_a_run(const std::string& name) const {
    const ProgramRun run = run_until(20000, name);
    ASSERT_EQ(run.status, kKilled) << run.error;
  }

  TemporaryFolder folder_;
};

TEST_F(EstimateRunTest, KilledAtManyMomentsItEndsWithTheBytesOfAnUndisturbedRun) {
  ASSERT_THAT(run_program(command("whole")), Succeeded());
  const std::uintmax_t whole = size_of(path("whole.txt"));
  Random random(16, 0);
  int killed = 0;
  for (int i = 0; i < 20; ++i) {
    const auto share = (i + random.uniform(0.0, 1.0)) / 20.0;
    const auto bytes = static_cast<std::uintmax_t>(share * static_cast<double>(whole));
    const std::uintmax_t before = size_of(path("run.txt.partial"));
    const ProgramRun run = run_until(bytes, "run", SIGKILL, {"--resume"});
    if (run.status != kKilled) break;
    ++killed;
    EXPECT_FALSE(fs::exists(path("run.txt")));
    EXPECT_GE(size_of(path("run.txt.partial")) + 2000, before)
        << "a run lost what those before it had written";
  }
  EXPECT_GE(killed, 10) << "the program ended before it could be killed";
  ASSERT_THAT(run_program(command("run", {"--resume"})), Succeeded());
  expect_same_outputs("run", "whole");
}

TEST_F(EstimateRunTest, AskedToEndItKeepsWhatIsDoneAndSaysHowToGoOn) {
  ASSERT_THAT(run_program(command("whole")), Succeeded());
  for (const auto& [signal, bytes] :
       {std::pair(SIGINT, 0), std::pair(SIGTERM, 15000), std::pair(SIGINT, 35000)}) {
    const ProgramRun run = run_until(static_cast<std::uintmax_t>(bytes), "run", signal, {"--resume"});
    ASSERT_THAT(run, FailedWith("interrupted after "));
    EXPECT_THAT(run.error, HasSubstr(fmt::format(" of {} frames; continue with --resume", kFrames)));
    const auto frames = read_lines(path("run.txt.partial")).size() - 1;
    EXPECT_THAT(run.error, HasSubstr(fmt::format("after {} of", frames)));
    EXPECT_EQ(read_lines(path("run.jsonl.partial")).size(), frames);
  }
  ASSERT_THAT(run_program(command("run", {"--resume"})), Succeeded());
  expect_same_outputs("run", "whole");
}

TEST_F(EstimateRunTest, FilesCutInTheMiddleOfALineAreCutBackToWholeFrames) {
  ASSERT_THAT(run_program(command("whole")), Succeeded());
  for (const char* file : {"run.txt.partial", "run.jsonl.partial", "run.txt.resume"}) {
    leave_half_a_run("run");
    fs::resize_file(path(file), size_of(path(file)) - 777);
    ASSERT_THAT(run_program(command("run", {"--resume"})), Succeeded());
    expect_same_outputs("run", "whole");
    for (const char* made : {"run.txt", "run.jsonl"}) fs::remove(path(made));
  }
}

TEST_F(EstimateRunTest, WithoutAnythingToGoOnFromResumeBeginsAndWithoutResumeARunIsReplaced) {
  ASSERT_THAT(run_program(command("whole", {"--resume"})), Succeeded());
  leave_half_a_run("run");
  const ProgramRun run = run_program(command("run"));
  ASSERT_THAT(run, Succeeded());
  EXPECT_THAT(run.error, HasSubstr("warning: " + path("run.txt.partial")));
  expect_same_outputs("run", "whole");
}

TEST_F(EstimateRunTest, ARunThatWasBegunWithSomethingElseIsNotGoneOnWith) {
  leave_half_a_run("run");
  const auto expect_refused = [&](const std::vector<std::string>& arguments, const std::string& what) {
    const ProgramRun run = run_program(arguments);
    EXPECT_THAT(run, FailedWith("run.txt.resume: the run was begun with another " + what));
    EXPECT_THAT(run.error, HasSubstr("begin again without --resume"));
  };
  expect_refused(command("run", {"--resume", "--init", "truth"}), "start");
  expect_refused(command_on(source() + "?count=50", "run", {"--resume"}), "source");
  expect_refused(changed(command("run", {"--resume"}), "--records", path("other.jsonl")), "file for records");

  const std::string pipeline = read_text_file(path("pipeline.toml"));
  write_text_file(path("pipeline.toml"), with(pipeline, "side = \"auto\"", "side = \"left\""));
  expect_refused(command("run", {"--resume"}), "pipeline");
  write_text_file(path("pipeline.toml"), pipeline);

  const std::string journal = read_text_file(path("run.txt.resume"));
  const std::size_t begin = journal.find("version of knuckle: ");
  ASSERT_NE(begin, std::string::npos);
  const std::size_t end = journal.find('\n', begin);
  write_text_file(path("run.txt.resume"),
                  journal.substr(0, begin) + "version of knuckle: 0.0.1" + journal.substr(end));
  expect_refused(command("run", {"--resume"}), "version of knuckle: '0.0.1'");
  write_text_file(path("run.txt.resume"), journal);
  EXPECT_THAT(run_program(command("run", {"--resume"})), Succeeded()) << "the refusals did no harm";
}

class BrokenFrameTest : public EstimateRunTest {
 protected:
  void SetUp() override {
    EstimateRunTest::SetUp();
    ASSERT_THAT(run_program({"render", "--manifest", path("manifest.toml"), "--format", "folder", "--out",
                             path("set")}),
                Succeeded());
    ASSERT_THAT(run_program(command_on(set(), "whole")), Succeeded());
  }

  std::string set() const { return "folder:" + path("set"); }
  std::string break_image(std::size_t frame) const {
    const std::string image = entries_of(path("set/depth")).at(frame);
    fs::resize_file(path("set/depth/" + image), size_of(path("set/depth/" + image)) / 2);
    return image;
  }
};

TEST_F(BrokenFrameTest, OneUnreadableFrameLosesNoOther) {
  const std::string first = break_image(50);
  break_image(70);
  const ProgramRun run = run_program(command_on(set(), "run"));
  EXPECT_THAT(run, FailedWith("2 of 100 frames could not be read"));
  EXPECT_THAT(run.error, HasSubstr("the first is frame 50: " + path("set/depth/" + first)));

  std::vector<std::string> expected = read_lines(path("whole.txt"));
  for (const std::size_t frame : {51u, 71u}) {
    std::string& line = expected.at(frame);
    line = "nan";
    for (int i = 1; i < 66; ++i) line += " nan";
  }
  EXPECT_EQ(read_lines(path("run.txt")), expected);
  const auto record = Json::parse(read_lines(path("run.jsonl")).at(50));
  EXPECT_EQ(record["frame"], 50);
  EXPECT_EQ(record["name"], fs::path(first).stem().string());
  EXPECT_THAT(record["hands"], IsEmpty());
  EXPECT_THAT(record["status"].get<std::string>(), HasSubstr(first));
  const auto summary = Json::parse(read_text_file(path("run.json")));
  EXPECT_EQ(summary["unreadable"], 2);
  EXPECT_THAT(summary["frames_without_hand"].dump(), HasSubstr(first));

  const ProgramRun going = run_program(command_on(set(), "going", {"--keep-going"}));
  ASSERT_THAT(going, Succeeded());
  EXPECT_THAT(going.error, HasSubstr("warning: 2 of 100 frames could not be read"));
  expect_same_outputs("going", "run");
}

TEST_F(BrokenFrameTest, FaultsOfAnInterruptedRunAreNotForgotten) {
  break_image(1);
  const ProgramRun run = run_program_until([&] { return size_of(path("run.txt.partial")) > 20000; },
                                           command_on(set(), "run"), SIGINT);
  ASSERT_THAT(run, FailedWith("interrupted"));
  EXPECT_THAT(run_program(command_on(set(), "run", {"--resume"})),
              FailedWith("1 of 100 frames could not be read and have no hand in " + path("run.txt") +
                         "; the first is frame 1"));
}

TEST_F(BrokenFrameTest, ASetWhoseLabelsOrDescriptionAreWrongIsRefusedAsAWhole) {
  const std::string joints = read_text_file(path("set/joints.txt"));
  write_text_file(path("set/joints.txt"), with(joints, " ", " x"));
  EXPECT_THAT(run_program(command_on(set(), "run")), FailedWith("joints.txt"));
  EXPECT_FALSE(fs::exists(path("run.txt")));
  write_text_file(path("set/joints.txt"), joints);
  write_text_file(path("set/dataset.toml"), "nonsense");
  EXPECT_THAT(run_program(command_on(set(), "run")), FailedWith("dataset.toml"));
  EXPECT_FALSE(fs::exists(path("run.txt")));
}

TEST_F(EstimateRunTest, OutputsThatAreOneFileAreRefused) {
  const std::vector<std::string> run = {"estimate", "--source", source(), "--out", path("a.txt")};
  for (const auto& [option, file] :
       {std::pair("--records", "a.txt"), std::pair("--json", "a.txt.partial"),
        std::pair("--records", "a.txt.resume"), std::pair("--json", "a.txt.options.toml")}) {
    std::vector<std::string> arguments = run;
    arguments.insert(arguments.end(), {option, path(file)});
    EXPECT_THAT(run_program(arguments), FailedWith(path(file) + ": is the file for"));
  }
  EXPECT_THAT(entries_of(folder_.path()), Not(Contains(HasSubstr("a.txt"))));
}

TEST_F(EstimateRunTest, AnOutputThatCannotBeWrittenIsSaidAtOnce) {
  for (const char* option : {"--out", "--records", "--json"}) {
    const ProgramRun run = run_program(changed(command("run"), option, "/proc/knuckle/out"));
    EXPECT_THAT(run, FailedWith("/proc/knuckle/out")) << option;
  }
  EXPECT_THAT(entries_of(folder_.path()), Not(Contains(HasSubstr("run."))));
}

TEST_F(EstimateRunTest, AnOutputFolderThatVanishesIsNoticed) {
  make_folder(path("gone"));
  const std::vector<std::string> arguments = changed(command("run"), "--records", path("gone/run.jsonl"));
  const auto remove_folder = [&] {
    if (size_of(path("run.txt.partial")) > 10000) fs::remove_all(path("gone"));
    return false;
  };
  EXPECT_THAT(run_program_until(remove_folder, arguments),
              FailedWith("run.jsonl.partial: cannot write: it vanished while it was written"));
  EXPECT_FALSE(fs::exists(path("run.txt")));
  EXPECT_GT(size_of(path("run.txt.partial")), 0u) << "what was done is kept";
}

TEST_F(EstimateRunTest, AFullDiskIsOneLineForEveryOutputAndTheRunGoesOn) {
  ASSERT_THAT(run_program(command("whole")), Succeeded());
  for (const auto& [option, file] : {std::pair("--out", "run.txt"), std::pair("--records", "run.jsonl"),
                                     std::pair("--json", "run.json")}) {
    const SmallDisk disk(path("disk"));
    if (!disk.mount(8)) GTEST_SKIP() << "no disk can be mounted here: " << std::strerror(errno);
    const std::string on_disk = path(std::string("disk/") + file);
    EXPECT_THAT(run_program(changed(command("run"), option, on_disk)), FailedWith(file)) << option;
    EXPECT_FALSE(fs::exists(on_disk));
    ASSERT_TRUE(disk.resize(4096));
    ASSERT_THAT(run_program(changed(command("run", {"--resume"}), option, on_disk)), Succeeded()) << option;
    fs::copy_file(on_disk, path(file), fs::copy_options::overwrite_existing);
    expect_same_outputs("run", "whole");
  }
}

/// Looks for two hands, and takes what is not sure for one, so that both poses files have something to say.
/// Hands that are followed, in sequences of 15 frames.
class FollowedHandsTest : public EstimateRunTest {
 protected:
  void SetUp() override {
    EstimateRunTest::SetUp();
    write_text_file(path("manifest.toml"), read_text_file(path("manifest.toml")) +
                                               "[pose]\nmotion = \"smooth\"\nframes_a_pose = 10\n"
                                               "sequence_frames = 15\n");
    write_text_file(path("pipeline.toml"), shipped_pipeline("track"));
  }
};

TEST_F(FollowedHandsTest, KilledInTheMiddleOfSequencesItEndsWithTheBytesOfAnUndisturbedRun) {
  ASSERT_THAT(run_program(command("whole")), Succeeded());
  EXPECT_THAT(read_text_file(path("whole.jsonl")), HasSubstr("\"skeleton\""));
  int killed = 0;
  for (const std::uintmax_t bytes : {5000u, 17000u, 30000u, 44000u}) {
    if (run_until(bytes, "run", SIGKILL, {"--resume"}).status == kKilled) ++killed;
  }
  EXPECT_GE(killed, 3) << "the program ended before it could be killed";
  ASSERT_THAT(run_program(command("run", {"--resume"})), Succeeded());
  expect_same_outputs("run", "whole");
}

class TwoHandsTest : public EstimateRunTest {
 protected:
  void SetUp() override {
    EstimateRunTest::SetUp();
    std::string pipeline = with(shipped_pipeline("free_hand"), "max_hands = 1", "max_hands = 2");
    pipeline = with(pipeline, "sure_confidence = 0.45", "sure_confidence = 0.1");
    write_text_file(path("pipeline.toml"), pipeline);
    ASSERT_THAT(run_program(command("whole")), Succeeded());
    ASSERT_THAT(read_lines(path("whole.hand2.txt")), Contains(Not(HasSubstr("nan"))).Times(::testing::Ge(3)))
        << "a heading and some second hands";
  }

  void expect_same_hands(const std::string& name, const fs::path& folder) const {
    for (const char* extension : {".txt", ".hand2.txt"}) {
      EXPECT_TRUE(read_text_file(folder / (name + extension)) == read_text_file(path("whole") + extension))
          << extension;
    }
  }
};

TEST_F(TwoHandsTest, KilledAndResumedBothFilesHaveTheBytesOfAnUndisturbedRun) {
  for (const std::uintmax_t bytes : {0u, 15000u, 35000u}) {
    const ProgramRun run = run_until(bytes, "run", SIGKILL, {"--resume"});
    ASSERT_EQ(run.status, kKilled) << run.error;
    EXPECT_FALSE(fs::exists(path("run.hand2.txt")));
  }
  fs::resize_file(path("run.hand2.txt.partial"), size_of(path("run.hand2.txt.partial")) - 333);
  ASSERT_THAT(run_program(command("run", {"--resume"})), Succeeded());
  expect_same_outputs("run", "whole");
  expect_same_hands("run", folder_.path());
}

TEST_F(TwoHandsTest, ADiskThatFillsUpWhileTheSecondHandsFileGrowsIsOneLineAndTheRunGoesOn) {
  const auto on_disk = [&](const std::vector<std::string>& more = {}) {
    return changed(command("run", more), "--out", path("disk/run.txt"));
  };
  int second = 0;
  for (const int kilobytes : {24, 28, 32, 36, 40, 44}) {
    const SmallDisk disk(path("disk"));
    if (!disk.mount(kilobytes)) GTEST_SKIP() << "no disk can be mounted here: " << std::strerror(errno);
    const ProgramRun run = run_program(on_disk());
    EXPECT_THAT(run, FailedWith("run.")) << kilobytes;
    EXPECT_FALSE(fs::exists(path("disk/run.txt")) || fs::exists(path("disk/run.hand2.txt")));
    if (run.error.find("run.hand2.txt.partial: cannot write: ") == std::string::npos) continue;
    ++second;
    ASSERT_TRUE(disk.resize(4096));
    ASSERT_THAT(run_program(on_disk({"--resume"})), Succeeded());
    expect_same_hands("run", path("disk"));
  }
  EXPECT_GE(second, 1) << "no disk was full for the second hand's file";
}

TEST_F(TwoHandsTest, ADiskThatIsFullForTheOptionsAloneIsOneLineAndTheRunGoesOn) {
  const auto on_disk = [&](const std::vector<std::string>& more = {}) {
    return changed(command("run", more), "--out", path("disk/run.txt"));
  };
  constexpr std::uintmax_t kPage = 4096;
  std::uintmax_t pages = 0;  // that all other files take
  {
    const SmallDisk disk(path("disk"));
    if (!disk.mount(4096)) GTEST_SKIP() << "no disk can be mounted here: " << std::strerror(errno);
    make_folder(path("disk/run.txt.options.toml/in the way"));
    ASSERT_THAT(run_program(on_disk()), FailedWith("run.txt.options.toml: cannot write: "));
    for (const auto& entry : fs::directory_iterator(path("disk"))) {
      if (entry.is_regular_file()) pages += (entry.file_size() + kPage - 1) / kPage;
    }
  }
  const SmallDisk disk(path("disk"));
  ASSERT_TRUE(disk.mount(static_cast<int>(pages * kPage / 1024)));
  EXPECT_THAT(run_program(on_disk()), FailedWith("run.txt.options.toml: cannot write: "));
  EXPECT_THAT(entries_of(path("disk")),
              ElementsAre("run.hand2.txt.partial", "run.txt.partial", "run.txt.resume"));
  ASSERT_TRUE(disk.resize(4096));
  ASSERT_THAT(run_program(on_disk({"--resume"})), Succeeded());
  EXPECT_TRUE(fs::exists(path("disk/run.txt.options.toml")));
  expect_same_hands("run", path("disk"));
}

TEST_F(EstimateRunTest, WithoutPermissionNothingIsBegun) {
  fs::permissions(folder_.path(), fs::perms::owner_all | fs::perms::others_read | fs::perms::others_exec);
  make_folder(path("locked"));
  fs::permissions(path("locked"), fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read |
                                      fs::perms::others_exec);
  make_folder(path("open"));
  fs::permissions(path("open"), fs::perms::all);
  const auto in_open = [&](const std::string& option, const std::string& file) {
    std::vector<std::string> arguments = command("open/run");
    return option.empty() ? arguments : changed(arguments, option, file);
  };
  const auto works = run_program_as_ordinary_user(in_open("", ""));
  if (!works) GTEST_SKIP() << "the program cannot be run as an ordinary user here";
  ASSERT_THAT(*works, Succeeded());
  for (const auto& entry : fs::directory_iterator(path("open"))) fs::remove(entry.path());
  for (const char* option : {"--out", "--records", "--json"}) {
    const std::string file = path("locked/run.out");
    const auto run = run_program_as_ordinary_user(in_open(option, file));
    EXPECT_THAT(*run, FailedWith(file + ": cannot write: Permission denied")) << option;
  }
  const auto rendering = run_program_as_ordinary_user(
      {"render", "--manifest", path("manifest.toml"), "--out", path("locked/set.h5")});
  EXPECT_THAT(*rendering, FailedWith("Permission denied"));
  EXPECT_THAT(entries_of(path("locked")), IsEmpty());
  EXPECT_THAT(entries_of(path("open")), IsEmpty());
}

}  // namespace
}  // namespace knuckle::testing
