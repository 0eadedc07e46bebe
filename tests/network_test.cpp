// SPDX-License-Identifier: Apache-2.0
// Networks, from training to poses, and their faults, through the real program.
#include "program.h"

#include <sstream>

#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

const std::string kSources =
    "source = 'synthetic:{0}?count=12'\nvalidation = 'synthetic:{0}?first=12&count=4'\n";
const std::string kSmallTables =
    "[patch]\nmode = 'cube'\nsize_px = 32\n[samples]\ncrop_px = 48\n[network]\nconvention = 'icg20'\n";
const std::string kSmall = "start = 'truth'\n" + kSmallTables;
const std::string kDense =
    "architecture = 'dense'\nstem_channels = 4\nquarter_channels = 8\neighth_channels = 8\n"
    "sixteenth_channels = 8\nhead_channels = 8\n";
const std::string kTraining = "[training]\nepochs = 2\nbatch_size = 4\nshards = 2\nvalidate_every = 2\n";

class NetworkTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  std::string sources() const {
    return fmt::format(fmt::runtime(kSources), std::filesystem::absolute("manifests/demo.toml").string());
  }
  std::string config() const { return sources() + kSmall + kDense + kTraining; }

  ProgramRun train(const std::string& toml, const std::vector<std::string>& more = {},
                   const std::string& out = "") {
    write_text_file(path("train.toml"), toml);
    std::vector<std::string> arguments = {
        "train", "network", "--config", path("train.toml"), "--out", out.empty() ? path("net.pt") : out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

  ProgramRun estimate(const std::string& toml) {
    // So short a training is sure of nothing.
    write_text_file(path("pipeline.toml"), toml + "[hand]\nsure_confidence = 0.0\n");
    return run_program({"estimate", "--source", "synthetic:manifests/demo.toml?count=3", "--pipeline",
                        path("pipeline.toml"), "--out", path("poses.txt")});
  }

  TemporaryFolder folder_;
};

TEST_F(NetworkTest, ADeviceThatIsNotThereIsSaidBeforeAnythingIsDone) {
  write_text_file(path("net.pt.checkpoint"), "of an earlier training");
  EXPECT_THAT(train(config(), {"--device", "abacus"}),
              FailedWith("device is \"abacus\", expected cpu, cuda or cuda:N"));
  EXPECT_EQ(read_text_file(path("net.pt.checkpoint")), "of an earlier training");
  EXPECT_THAT(entries_of(folder_.path()), UnorderedElementsAre("net.pt.checkpoint", "train.toml"));
}

TEST_F(NetworkTest, AMachineWithoutTheDeviceSaysSoBeforeItReadsAnything) {
  const ProgramRun run = run_program(
      {"train", "network", "--config", path("none.toml"), "--out", path("net.pt"), "--device", "cuda"});
  if (run.error.find("device cuda") == std::string::npos) {
    EXPECT_THAT(run, FailedWith("none.toml")) << "it has one";
  } else {
    EXPECT_THAT(run, FailedWith("--device cpu"));
  }
}

/// Two sets of rendered frames, the first four of which are a folder of one's own.
class OwnDataTest : public NetworkTest {
 protected:
  OwnDataTest() {
    EXPECT_THAT(run_program({"render", "--manifest", "manifests/demo.toml", "--count", "6", "--format",
                             "folder", "--out", path("mine")}),
                Succeeded());
    write_text_file(path("mine/sequences.txt"), "0\n2\n4\n");
  }

  std::string configuration(const std::string& first = "folder:mine") const {
    return "start = 'truth'\n[[source]]\nsource = '" + first +
           "'\nweight = 3\nholdout = 0.4\n[[source]]\nsource = '" + synthetic() + "?first=6&count=10'\n" +
           kSmallTables + kDense + kTraining;
  }
  static std::string synthetic() {
    return "synthetic:" + std::filesystem::absolute("manifests/demo.toml").string();
  }
};

TEST_F(OwnDataTest, IsMixedWithOthersAndGoesOnToTheSameBytes) {
  ASSERT_THAT(train(configuration(), {"--cache", path("cache")}), Succeeded());
  const std::string model = read_text_file(path("net.pt"));
  EXPECT_THAT(entries_of(path("cache")), SizeIs(3)) << "each set, and what is held out";
  EXPECT_THAT(entries_of(folder_.path()), AllOf(Contains("net_curves.svg"), Contains("net_curves.png")));
  EXPECT_THAT(train(configuration(), {"--resume"}), Succeeded());
  EXPECT_TRUE(read_text_file(path("net.pt")) == model);
  std::filesystem::remove(path("net.pt"));
  EXPECT_THAT(train(configuration()), Succeeded());
  EXPECT_TRUE(read_text_file(path("net.pt")) == model) << "with and without a cache";
  const std::string options = read_text_file(path("net.pt.options.toml"));
  EXPECT_THAT(options, AllOf(HasSubstr("[[source]]"), HasSubstr("weight = 3"), HasSubstr("holdout = 0.4")));
}

TEST_F(OwnDataTest, IsShownBeforeItIsTrainedOn) {
  const ProgramRun run = train(configuration(), {"--check"});
  ASSERT_THAT(run, Succeeded());
  EXPECT_THAT(run.out, AllOf(HasSubstr("set 1: folder:"), HasSubstr("75.0% of the samples"),
                             HasSubstr("set 2: synthetic:"), HasSubstr("landmarks: 20 of 20 labelled"),
                             HasSubstr("held out"), HasSubstr("net_check.png")));
  EXPECT_THAT(entries_of(folder_.path()), UnorderedElementsAre("mine", "train.toml", "net_check.png"));
  const Image<Rgb> sheet = read_png_rgb(path("net_check.png"));
  EXPECT_GT(sheet.width(), 1000);
  const ProgramRun detector = train(sources() + "[network]\narchitecture = 'detector'\n", {"--check"});
  EXPECT_THAT(detector, FailedWith("--check"));
}

TEST_F(OwnDataTest, OfWhichASetIsEmptyIsNamed) {
  make_folder(path("empty/depth"));
  write_text_file(path("empty/dataset.toml"), read_text_file(path("mine/dataset.toml")));
  EXPECT_THAT(train(configuration("folder:empty")), FailedWith("empty"));
  EXPECT_THAT(train("source = ['folder:mine', 'folder:empty']\n"), FailedWith("[[source]]"));
  std::string nothing;  // frames without one label
  for (std::size_t frame = 0; frame < 6; ++frame) {
    for (std::size_t number = 0; number < 66; ++number) nothing += "nan ";
    nothing += "\n";
  }
  write_text_file(path("mine/joints.txt"), nothing);
  EXPECT_THAT(train(configuration()), FailedWith("mine"));
}

TEST_F(OwnDataTest, WithoutSomeLandmarksIsLearnedWithAWarning) {
  std::string joints;
  for (const std::string& line : read_lines(path("mine/joints.txt"))) {
    std::istringstream numbers(line);
    std::string number;
    for (int i = 0; numbers >> number; ++i) joints += i >= 3 && i < 6 ? "nan " : number + " ";  // the palm
    joints += "\n";
  }
  write_text_file(path("mine/joints.txt"), joints);
  std::string toml = configuration();
  toml.replace(toml.find("icg20"), 5, "knuckle22");
  const std::size_t second = toml.find("[[source]]", toml.find("[[source]]") + 1);
  toml.erase(second, toml.find("[patch]") - second);
  const ProgramRun run = train(toml);
  ASSERT_THAT(run, Succeeded());
  EXPECT_THAT(run.error, AllOf(HasSubstr("warning: no sample labels palm"), Not(HasSubstr("little_tip"))));
  EXPECT_THAT(run.out, Not(HasSubstr("nan")));
}

TEST_F(OwnDataTest, LandmarksOfOnesOwnAreLearnedWhereTheirFileSaysThatTheyLie) {
  const std::string kHead = "format = 'knuckle-landmarks'\nversion = 1\n";
  write_text_file(path("lab.toml"),
                  kHead +
                      "convention = 'lab3'\nlandmarks = ['wrist', 'lab_knuckle', 'index_tip']\n"
                      "[lab_knuckle]\nbone = 'middle_mcp'\ntowards = 'middle_pip'\nshare = 0.5\n");
  std::string toml = config();
  toml.replace(toml.find("'icg20'"), 7, "'lab.toml'");
  EXPECT_THAT(train(toml, {"--check"}).out, HasSubstr("landmarks: 3 of 3 labelled"));
  ASSERT_THAT(train(toml), Succeeded());
  // The model knows its landmarks without the file.
  std::filesystem::remove(path("lab.toml"));
  ASSERT_THAT(estimate("[estimator]\nmethod = 'dense'\nmodel = 'net.pt'\npasses = 1\n"), Succeeded());
  const std::string poses = read_text_file(path("poses.txt"));
  EXPECT_THAT(poses, HasSubstr("# convention: lab3"));
  write_text_file(path("lab.toml"),
                  kHead + "convention = 'lab3'\nlandmarks = ['wrist', 'toe', 'index_tip']\n");
  EXPECT_THAT(train(toml), FailedWith("lab.toml:4: landmarks: names 'toe'"));
}

TEST_F(OwnDataTest, BeginsWithAnotherNetworkAndEndsEarly) {
  ASSERT_THAT(train(configuration()), Succeeded());
  std::filesystem::rename(path("net.pt"), path("first.pt"));
  const std::string more = "initial = 'first.pt'\n" + configuration() +
                           "patience = 1\nlearning_rate = 5.0\nschedule = 'constant'\nwarm_up = 0.0\n";
  std::string longer = more;
  longer.replace(longer.find("epochs = 2"), 10, "epochs = 9");
  const ProgramRun run = train(longer);
  ASSERT_THAT(run, Succeeded());
  EXPECT_THAT(run.out, AllOf(HasSubstr("before training: validation"), HasSubstr("time left"),
                             HasSubstr("ended early: 1 validations")));
}

TEST_F(NetworkTest, IsTrainedByTheKernelsOfThisProcessor) {
  ASSERT_EQ(::setenv("OPENBLAS_VERBOSE", "2", 1), 0);  // it then says which it has chosen
  const ProgramRun run =
      run_program({"train", "network", "--config", path("none.toml"), "--out", path("net.pt")});
  ::unsetenv("OPENBLAS_VERBOSE");
  const std::size_t last = run.error.rfind("Core: ");
  if (last == std::string::npos)
    GTEST_SKIP() << "the system's BLAS is not OpenBLAS, or has kernels of one kind";
  const std::string kernels = run.error.substr(last, run.error.find('\n', last) - last);
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) GTEST_SKIP() << "an old processor";
#endif
  EXPECT_THAT(kernels, Not(AnyOf("Core: Prescott", "Core: Nehalem", "Core: Sandybridge")));
}

TEST_F(NetworkTest, IsTrainedAndFindsPoses) {
  ASSERT_THAT(train(config()), Succeeded());
  EXPECT_THAT(entries_of(folder_.path()),
              AllOf(Contains("net.pt"), Contains("net.pt.checkpoint"), Contains("net.pt.metrics.csv"),
                    Contains("net.pt.options.toml"), Contains("net_curves.svg")));
  EXPECT_THAT(read_lines(path("net.pt.metrics.csv")), SizeIs(4))
      << "a heading and three validations of 6 steps";
  ASSERT_THAT(estimate("[estimator]\nmethod = 'dense'\nmodel = 'net.pt'\npasses = 1\n"), Succeeded());
  const std::vector<std::string> lines = read_lines(path("poses.txt"));
  EXPECT_THAT(lines, AllOf(SizeIs(4), Contains(HasSubstr("# convention: icg20"))));
  EXPECT_THAT(estimate("[estimator]\nmethod = 'dense'\nmodel = 'net.pt'\npasses = 3\n"), Succeeded());
  EXPECT_NE(read_lines(path("poses.txt")), lines) << "more looks see more";
  EXPECT_THAT(estimate("[patch]\nmode = 'hand'\n[estimator]\nmethod = 'dense'\nmodel = 'net.pt'\n"),
              FailedWith("pipeline.toml:2: patch.mode"));
  EXPECT_THAT(estimate("[estimator]\nmethod = 'dense'\nmodel = 'net.pt'\npasses = 0\n"),
              FailedWith("pipeline.toml:4: estimator.passes"));
  EXPECT_THAT(estimate("[estimator]\nmethod = 'pca'\nmodel = 'net.pt'\n"),
              FailedWith("net.pt is a network \"dense\""));

  const std::string bytes = read_text_file(path("net.pt"));
  write_text_file(path("net.pt"), bytes.substr(0, bytes.size() / 2));
  EXPECT_THAT(estimate("[estimator]\nmethod = 'dense'\nmodel = 'net.pt'\n"), FailedWith("net.pt"));
  const std::string metrics = read_text_file(path("net.pt.metrics.csv"));
  std::filesystem::remove(path("net.pt.metrics.csv"));
  std::filesystem::remove(path("net_curves.svg"));
  EXPECT_THAT(train(config(), {"--resume"}), Succeeded()) << "all is in the checkpoint";
  EXPECT_EQ(read_text_file(path("net.pt.metrics.csv")), metrics) << "as killed before they were written";
  EXPECT_THAT(entries_of(folder_.path()), Contains("net_curves.svg"));
  EXPECT_THAT(train(config() + "seed = 7\n", {"--resume"}), FailedWith("net.pt.checkpoint"));
  std::filesystem::remove(path("net.pt.checkpoint"));
  EXPECT_THAT(train(config(), {"--resume"}), FailedWith("net.pt.checkpoint"));
}

TEST_F(NetworkTest, AFullDiskIsSaidAndLeavesWholeFiles) {
  ASSERT_THAT(train(config()), Succeeded());
  const std::string model = read_text_file(path("net.pt"));
  for (const std::string name : {"net.pt", "net.pt.checkpoint"}) {
    const auto kilobytes = static_cast<int>(std::filesystem::file_size(path(name)) / 2000);
    EXPECT_THAT(run_program_on_full_disk(
                    kilobytes, {"train", "network", "--config", path("train.toml"), "--out", path("net.pt")}),
                FailedWith(name + ": cannot write"));
    EXPECT_EQ(std::filesystem::file_size(path("net.pt")), model.size());
    EXPECT_THAT(estimate("[estimator]\nmethod = 'dense'\nmodel = 'net.pt'\n"), Succeeded());
    if (name == "net.pt") {
      EXPECT_TRUE(read_text_file(path("net.pt")) == model) << "the former one";
      ASSERT_THAT(train(config()), Succeeded());
    }
  }
  EXPECT_THAT(entries_of(folder_.path()), Not(Contains(HasSubstr("partial"))));
}

TEST_F(NetworkTest, TakesSamplesFromTheCacheToTheSameWeights) {
  ASSERT_THAT(train(config()), Succeeded());
  const std::string without = read_text_file(path("net.pt"));
  for (const std::string run : {"first", "second"}) {
    std::filesystem::remove(path("net.pt"));
    ASSERT_THAT(train(config(), {"--cache", path("cache")}), Succeeded());
    EXPECT_TRUE(read_text_file(path("net.pt")) == without) << run;
  }
  EXPECT_THAT(entries_of(path("cache")), SizeIs(2)) << "training and validation";
  write_text_file(path("file"), "");
  EXPECT_THAT(train(config(), {"--cache", path("file")}), FailedWith("file"));
}

TEST_F(NetworkTest, AWrongConfigurationEndsItInOneLine) {
  const auto fault = [&](const std::string& toml, const std::string& part) {
    EXPECT_THAT(train(toml), FailedWith(part)) << toml;
  };
  fault("", "source: is missing");
  fault(sources() + kSmall + "architecture = 'magic'\n", "train.toml:11: network.architecture");
  fault(sources() + kSmall + "architecture = 'dense'\nhidden_units = 3\n",
        "train.toml:12: network.hidden_units");
  fault(sources() + "[patch]\nmode = 'cube'\nsize_px = 40\n", "size_px is 40");
  fault(sources() + "[patch]\nmode = 'hand'\n", "cube");
  fault(config() + "batchsize = 2\n", "training.batchsize: unknown key");
  fault(config() + "shards = 3\n", "train.toml");
  fault(sources() + kSmall + kDense + "[training]\nbatch_size = 4\nshards = 3\n", "a multiple of shards");
  fault(sources() + kSmall + kDense + "[samples]\n", "train.toml");
  fault(sources() + "[patch]\nmode = 'cube'\nsize_px = 32\n[samples]\ncrop_px = 16\n", "crops of 16 px");
  fault(sources() + "[patch]\nmode = 'cube'\n[samples]\nmemory_gb = 0.0001\n", "memory_gb");
  fault(sources() + "[patch]\nmode = 'cube'\n[augmentation]\nrotation_deg = 999\n", "rotation_deg");
  EXPECT_THAT(entries_of(folder_.path()), Not(Contains("net.pt")));
}

TEST_F(NetworkTest, ADetectorIsTrainedAndFindsHands) {
  const std::string detector =
      "[network]\narchitecture = 'detector'\nwidth = 64\nheight = 48\nfocal_cells = 43\nstem_channels = 4\n"
      "quarter_channels = 8\neighth_channels = 8\nsixteenth_channels = 8\nhead_channels = 8\n";
  ASSERT_THAT(train(sources() + detector + kTraining), Succeeded());
  EXPECT_THAT(entries_of(folder_.path()),
              AllOf(Contains("net.pt"), Contains("net.pt.checkpoint"), Contains("net.pt.metrics.csv"),
                    Contains("net.pt.options.toml"), Contains("net_curves.svg")));
  const std::vector<std::string> lines = read_lines(path("net.pt.metrics.csv"));
  ASSERT_THAT(lines, SizeIs(4));
  EXPECT_THAT(lines[0], HasSubstr("validation_recall_40mm,validation_false_positives_per_frame"));
  const std::string model = read_text_file(path("net.pt"));
  EXPECT_THAT(train(sources() + detector + kTraining, {"--resume"}), Succeeded());
  EXPECT_TRUE(read_text_file(path("net.pt")) == model);
  EXPECT_THAT(train(sources() + detector + kTraining, {"--cache", path("cache")}), FailedWith("--cache"));
  EXPECT_THAT(train(sources() + detector + "kernel = 3\n"), FailedWith("network.kernel"));
  const std::string little = "[samples]\nmemory_gb = 0.00001\n";
  EXPECT_THAT(train(sources() + little + detector), FailedWith("by `stream = true` in [samples]"));
  EXPECT_THAT(train(sources() + little + "stream = true\n" + detector),
              FailedWith("lower `most_validation`"));
  ASSERT_THAT(train(sources() + "[samples]\nstream = true\n" + detector + kTraining), Succeeded());
  EXPECT_TRUE(read_text_file(path("net.pt")) == model) << "of frames that are read when they are needed";

  const auto segmentation = [&](const std::string& file) {
    return "[segmentation]\nmethod = 'detector'\nmodel = '" + file +
           "'\nmin_score = 0.0\n[estimator]\nmethod = 'dense'\nmodel = '" +
           std::filesystem::absolute("models/dense.pt").string() + "'\n";
  };
  EXPECT_THAT(estimate(segmentation("net.pt")), Succeeded());
  EXPECT_THAT(estimate(segmentation(std::filesystem::absolute("models/dense.pt").string())),
              FailedWith("expected a knuckle-detector file, found a knuckle-network file"));
  EXPECT_THAT(estimate("[estimator]\nmethod = 'dense'\nmodel = 'net.pt'\n"),
              FailedWith("expected a knuckle-network file, found a knuckle-detector file"));
  write_text_file(path("net.pt"), model.substr(0, model.size() / 2));
  EXPECT_THAT(estimate(segmentation("net.pt")), FailedWith("net.pt"));
}

TEST_F(NetworkTest, ASourceWithoutTruthADeviceThatIsNotThereAndAnOutputThatCannotBeWritten) {
  make_folder(path("set/depth"));
  write_text_file(
      path("set/dataset.toml"),
      "[camera]\nmodel = 'projective'\nwidth = 64\nheight = 48\nfx = 60\nfy = 60\ncx = 32\ncy = 24\n");
  write_png(path("set/depth/000000.png"), Image<std::uint16_t>(64, 48));
  EXPECT_THAT(train("source = 'folder:set'\nvalidation = 'folder:set'\n" + kSmall + kDense),
              FailedWith("no truth"));
  EXPECT_THAT(train(config(), {"--device", "abacus"}), FailedWith("abacus"));
  EXPECT_THAT(train(config(), {}, "/proc/knuckle/net.pt"), FailedWith("/proc/knuckle/net.pt"));
  const ProgramRun cuda = train(config(), {"--device", "cuda"});
  if (cuda.status != 0) {
    EXPECT_THAT(cuda, FailedWith("device cuda"));
  }
}

}  // namespace
}  // namespace knuckle::testing
