// SPDX-License-Identifier: Apache-2.0
// A rendering that is killed, or whose disk fills up, goes on later and makes what an undisturbed one makes.
#include "program.h"

#include <cerrno>
#include <cstring>

#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

namespace fs = std::filesystem;

constexpr const char* kDemoManifest = "manifests/demo.toml";
constexpr int kKilled = 128 + 9;

std::uintmax_t size_of(const fs::path& path) {
  std::error_code missing;
  const std::uintmax_t size = fs::file_size(path, missing);
  return missing ? 0 : size;
}

std::vector<std::string> rendering(const std::string& out, const std::string& manifest = kDemoManifest) {
  return {"render", "--manifest", manifest, "--out", out};
}

class InterruptionTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_THAT(run_program(rendering(path("whole.h5"))), Succeeded()); }

  std::string path(const std::string& name) const { return folder_ / name; }

  bool is_like_whole(const std::string& file) const {
    return read_text_file(path("whole.h5")) == read_text_file(file);
  }

  TemporaryFolder folder_;
};

TEST_F(InterruptionTest, AKilledRenderingGoesOn) {
  const std::string out = path("set.h5");
  const std::uintmax_t whole = size_of(path("whole.h5"));
  int killed = 0;
  for (const double part : {0.0, 0.05, 0.3, 0.6, 0.9}) {
    fs::remove(out);
    fs::remove(out + ".partial");
    const auto limit = static_cast<std::uintmax_t>(part * static_cast<double>(whole));
    const ProgramRun run =
        run_program_until([&] { return size_of(out + ".partial") > limit; }, rendering(out));
    if (run.status == kKilled) {
      ++killed;
      EXPECT_FALSE(fs::exists(out)) << "a part of a file stands under the final name";
      EXPECT_THAT(run_program({"inspect", "--source", "h5:" + out + ".partial"}), FailedWith("unfinished"));
    }
    ASSERT_THAT(run_program(rendering(out)), Succeeded());
    EXPECT_TRUE(is_like_whole(out)) << "killed at " << limit << " bytes";
    EXPECT_FALSE(fs::exists(out + ".partial"));
  }
  EXPECT_GE(killed, 3) << "the program ended before it could be killed";
}

TEST_F(InterruptionTest, KilledAgainAndAgainItComesToAnEnd) {
  const std::string out = path("set.h5");
  std::uintmax_t kept = 0;
  for (int i = 0; i < 5 && !fs::exists(out); ++i) {
    run_program_until([&] { return size_of(out + ".partial") > kept + 60000; }, rendering(out));
    if (fs::exists(out + ".partial")) {
      EXPECT_GT(size_of(out + ".partial"), kept) << "a run lost what those before it had written";
      kept = size_of(out + ".partial");
    }
  }
  ASSERT_THAT(run_program(rendering(out)), Succeeded());
  EXPECT_TRUE(is_like_whole(out));
}

TEST_F(InterruptionTest, KilledWhileItPutsTheFileTogetherItDoesSoAgain) {
  const std::string out = path("set.h5");
  run_program_until([&] { return fs::exists(out + ".assembled"); }, rendering(out));
  ASSERT_THAT(run_program(rendering(out)), Succeeded());
  EXPECT_TRUE(is_like_whole(out));
  EXPECT_THAT(entries_of(folder_.path()), Not(Contains(HasSubstr(".assembled"))));
}

TEST_F(InterruptionTest, ARemainderOfAnotherManifestIsRefused) {
  const std::string out = path("set.h5");
  const ProgramRun run = run_program_until([&] { return size_of(out + ".partial") > 30000; }, rendering(out));
  ASSERT_EQ(run.status, kKilled);
  std::string manifest = read_text_file(kDemoManifest);
  write_text_file(path("other.toml"), manifest.replace(manifest.find("seed = 1"), 8, "seed = 2"));
  EXPECT_THAT(run_program(rendering(out, path("other.toml"))),
              FailedWith("set.h5.partial: is left from a run with "
                         "another manifest"));
  std::vector<std::string> fewer = rendering(out);
  fewer.insert(fewer.end(), {"--count", "7"});
  EXPECT_THAT(run_program(fewer),
              FailedWith("set.h5.partial: is left from a run with another manifest or other"));
  EXPECT_FALSE(fs::exists(out));
  ASSERT_THAT(run_program(rendering(out)), Succeeded()) << "the refusals did no harm";
  EXPECT_TRUE(is_like_whole(out));
}

TEST_F(InterruptionTest, ARenderingThatIsAskedToEndKeepsItsFramesAndGoesOn) {
  const std::string out = path("set.h5");
  const ProgramRun run = run_program_until(
      [&] { return size_of(out + ".partial") > size_of(path("whole.h5")) / 3; }, rendering(out), SIGINT);
  EXPECT_THAT(run, FailedWith("interrupted after "));
  EXPECT_THAT(run.error, HasSubstr(" of 40 frames; the same command goes on"));
  EXPECT_GT(size_of(out + ".partial"), 0u);
  ASSERT_THAT(run_program(rendering(out)), Succeeded());
  EXPECT_TRUE(is_like_whole(out));
}

TEST_F(InterruptionTest, ASegmentationThatIsAskedToEndKeepsItsFrames) {
  write_text_file(path("long.toml"), "frames = 100000\n[body]\npeople = 1\n");
  const std::string out = path("boxes.csv");
  int looks = 0;
  const ProgramRun run =
      run_program_until([&] { return ++looks > 2000; },  // about half a second
                        {"segment", "--source", "synthetic:" + path("long.toml"), "--out", out}, SIGTERM);
  EXPECT_THAT(run, FailedWith("interrupted after "));
  const auto frames = read_lines(out + ".partial").size() - 1;
  EXPECT_THAT(run.error,
              HasSubstr(fmt::format("after {} of 100000 frames, kept in {}.partial", frames, out)));
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(InterruptionTest, ATrainingThatIsAskedToEndGoesOnFromItsSplits) {
  const std::string source = "synthetic:" + fs::absolute(kDemoManifest).string() + "?count=40";
  write_text_file(path("train.toml"),
                  "source = '" + source + "'\n[forest]\ntrees = 3\nsplits_per_node = 2000\n");
  const auto training = [&](const std::string& out) {
    return std::vector<std::string>{"train", "pose-forest", "--config", path("train.toml"),
                                    "--out", path(out)};
  };
  ASSERT_THAT(run_program(training("whole_forest.model")), Succeeded());
  std::vector<std::string> arguments = training("forest.model");
  const ProgramRun run =
      run_program_until([&] { return fs::exists(path("forest.model.checkpoint")); }, arguments, SIGINT);
  ASSERT_THAT(run, FailedWith("interrupted after "));
  EXPECT_THAT(run.error, HasSubstr(" of 3 trees; continue with --resume"));
  EXPECT_FALSE(fs::exists(path("forest.model")));
  arguments.emplace_back("--resume");
  ASSERT_THAT(run_program(arguments), Succeeded());
  EXPECT_TRUE(read_text_file(path("forest.model")) == read_text_file(path("whole_forest.model")));
}

TEST_F(InterruptionTest, ATrainingOfANetworkThatIsAskedToEndGoesOnFromItsLastCheckpoint) {
  const std::string source = "synthetic:" + fs::absolute(kDemoManifest).string();
  write_text_file(path("train.toml"),
                  "source = '" + source + "?count=12'\nvalidation = '" + source + "?first=12&count=4'\n" +
                      "start = 'truth'\n[patch]\nmode = 'cube'\nsize_px = 32\n[samples]\ncrop_px = 48\n"
                      "[network]\nconvention = 'icg20'\narchitecture = 'dense'\nstem_channels = 4\n"
                      "quarter_channels = 8\neighth_channels = 8\nsixteenth_channels = 8\nhead_channels = 8\n"
                      "[training]\nepochs = 60\nbatch_size = 4\nshards = 2\nvalidate_every = 10\n");
  const auto training = [&](const std::string& out) {
    return std::vector<std::string>{"train", "network", "--config", path("train.toml"), "--out", path(out)};
  };
  ASSERT_THAT(run_program(training("whole.pt")), Succeeded());
  std::vector<std::string> arguments = training("net.pt");
  const ProgramRun run =
      run_program_until([&] { return fs::exists(path("net.pt.checkpoint")); }, arguments, SIGINT);
  ASSERT_THAT(run, FailedWith("interrupted after "));
  EXPECT_THAT(run.error, HasSubstr(" of 180 steps; continue with --resume from step "));
  arguments.emplace_back("--resume");
  ASSERT_THAT(run_program(arguments), Succeeded());
  EXPECT_TRUE(read_text_file(path("net.pt")) == read_text_file(path("whole.pt")));
}

TEST_F(InterruptionTest, AnExperimentThatIsAskedToEndKeepsItsStepsAndGoesOn) {
  const std::string demo = fs::absolute(kDemoManifest).string();
  write_text_file(path("scene.toml"), "frames = 100000\n[body]\npeople = 1\n");
  write_text_file(path("train.toml"), "source = 'synthetic:" + demo +
                                          "?count=4'\n[patch]\nsize_px = 24\n[forest]\ntrees = 2\n"
                                          "splits_per_node = 20\nmin_leaf_samples = 1\n");
  write_text_file(path("boxes.toml"), "[segmentation]\nmethod = 'threshold'\n");
  write_text_file(path("forest.toml"),
                  "[segmentation]\nmethod = 'mean_shift'\n[estimator]\nmethod = 'forest'\nmodel = "
                  "'../models/forest.model'\n");
  write_text_file(path("plan.toml"),
                  "title = 'A plan'\n[[sequence]]\nname = 'scene'\ntitle = 'The scene'\nsource = "
                  "'synthetic:scene.toml'\n[[model]]\nfile = 'forest.model'\nkind = 'pose-forest'\nconfig = "
                  "'train.toml'\n[[segmentation]]\nname = 'boxes'\npipeline = 'boxes.toml'\n"
                  "[[estimation]]\nname = 'forest'\npipeline = 'forest.toml'\n");
  const std::vector<std::string> arguments = {"experiment", path("plan.toml"), "--out", path("out")};
  const std::string model = path("out/models/forest.model");
  int looks = 0;
  const ProgramRun run =
      run_program_until([&] { return fs::exists(model) && ++looks > 1500; }, arguments, SIGINT);
  EXPECT_THAT(run, FailedWith("interrupted; what was done is kept in " + path("out")));
  EXPECT_FALSE(fs::exists(path("out/report.html")));
  ASSERT_TRUE(fs::exists(model));
  const auto trained = fs::last_write_time(model);
  write_text_file(path("scene.toml"), "frames = 3\n[body]\npeople = 1\n");
  ASSERT_THAT(run_program(arguments), Succeeded());
  EXPECT_TRUE(fs::exists(path("out/report.html")));
  EXPECT_EQ(fs::last_write_time(model), trained);
}

TEST_F(InterruptionTest, AnEvaluationThatIsAskedToEndWritesNothing) {
  constexpr int kLong = 100000;
  write_text_file(path("long.toml"), fmt::format("frames = {}\n[body]\npeople = 1\n", kLong));
  std::string poses = "# convention: nyu14\n";
  for (int i = 0; i < kLong; ++i) {
    for (int j = 0; j < 42; ++j) poses += j == 0 ? "nan" : " nan";
    poses += "\n";
  }
  write_text_file(path("poses.txt"), poses);
  int looks = 0;
  const ProgramRun run =
      run_program_until([&] { return ++looks > 2000; },  // about half a second
                        {"evaluate", "--truth", "synthetic:" + path("long.toml"), "--predictions",
                         "mine=" + path("poses.txt"), "--out", path("report"), "--json", path("scores.json")},
                        SIGINT);
  EXPECT_THAT(run, FailedWith("interrupted"));
  EXPECT_FALSE(fs::exists(path("report")) || fs::exists(path("scores.json")));
}

TEST_F(InterruptionTest, AFullDiskIsOneLineAndTheNextRunGoesOn) {
  const std::string out = path("set.h5");
  const auto kilobytes = static_cast<int>(size_of(path("whole.h5")) / 2000);
  EXPECT_THAT(run_program_on_full_disk(kilobytes, rendering(out)), FailedWith("set.h5"));
  EXPECT_FALSE(fs::exists(out));
  EXPECT_GT(size_of(out + ".partial"), 0u) << "what was written is kept";
  ASSERT_THAT(run_program(rendering(out)), Succeeded());
  EXPECT_TRUE(is_like_whole(out));
}

TEST_F(InterruptionTest, ARealDiskThatFillsUpIsOneLineAndTheNextRunGoesOn) {
  const auto whole = static_cast<int>(size_of(path("whole.h5")) / 1000);
  const SmallDisk disk(path("disk"));
  if (!disk.mount(whole / 2)) GTEST_SKIP() << "no disk can be mounted here: " << std::strerror(errno);
  const std::string out = path("disk/set.h5");
  EXPECT_THAT(run_program(rendering(out)), FailedWith("set.h5")) << "while frames are rendered";
  EXPECT_THAT(entries_of(path("disk")), ElementsAre("set.h5.partial"));
  ASSERT_TRUE(disk.resize(whole * 3 / 2));
  EXPECT_THAT(run_program(rendering(out)), FailedWith("set.h5")) << "while the file is put together";
  EXPECT_THAT(entries_of(path("disk")), ElementsAre("set.h5.partial"));
  ASSERT_TRUE(disk.resize(whole * 4));
  ASSERT_THAT(run_program(rendering(out)), Succeeded());
  EXPECT_TRUE(is_like_whole(out));
}

}  // namespace
}  // namespace knuckle::testing
