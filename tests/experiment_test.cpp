// SPDX-License-Identifier: Apache-2.0
// `knuckle experiment`: from data to report, and only what must be redone.
#include "program.h"

#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A plan of one short sequence, two segmentations and one forest that is trained on a few frames.
class ExperimentTest : public ::testing::Test {
 protected:
  ExperimentTest() {
    write_text_file(folder_ / "scene.toml",
                    "frames = 6\n[camera]\nwidth = 160\nheight = 120\nfx = 112.0\nfy = 112.0\n"
                    "cx = 79.5\ncy = 59.5\n[pose]\nmotion = \"smooth\"\n");
    write_text_file(folder_ / "train.toml",
                    "source = \"synthetic:scene.toml?count=4\"\n[patch]\nsize_px = 24\n"
                    "[forest]\ntrees = 2\nmax_depth = 3\nsplits_per_node = 20\nmin_leaf_samples = 1\n");
    write_text_file(folder_ / "threshold.toml", "[segmentation]\nmethod = \"threshold\"\n");
    write_text_file(folder_ / "mean_shift.toml", "[segmentation]\nmethod = \"mean_shift\"\n");
    write_text_file(folder_ / "forest.toml",
                    "[segmentation]\nmethod = \"mean_shift\"\n[estimator]\nmethod = \"forest\"\n"
                    "model = \"../models/forest.model\"\n");
    write_text_file(
        folder_ / "plan.toml",
        "title = \"A small plan\"\n[[sequence]]\nname = \"scene\"\ntitle = \"The scene\"\n"
        "source = \"synthetic:scene.toml\"\n[[model]]\nfile = \"forest.model\"\nkind = \"pose-forest\"\n"
        "config = \"train.toml\"\n"
        "[[segmentation]]\nname = \"threshold\"\npipeline = \"threshold.toml\"\n"
        "[[segmentation]]\nname = \"mean shift\"\npipeline = \"mean_shift.toml\"\n"
        "[[estimation]]\nname = \"forest\"\npipeline = \"forest.toml\"\n");
  }

  ProgramRun run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"experiment", folder_ / "plan.toml", "--out", out_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

  void add_to_plan(const std::string& toml) const {
    write_text_file(folder_ / "plan.toml", read_text_file(folder_ / "plan.toml") + toml);
  }

  std::string read(const std::string& name) const { return read_text_file(out_ / name); }

  TemporaryFolder folder_;
  std::filesystem::path out_ = std::filesystem::path(folder_ / "out");
};

TEST_F(ExperimentTest, GoesFromDataToReport) {
  ASSERT_THAT(run(), Succeeded());
  const std::string page = read("report.html");
  for (const char* part : {"A small plan", "The scene", "mean shift", "Frames with box overlap r &gt; t",
                           "Mean 3D error of each joint", "Segmentation of a frame (ms)"}) {
    EXPECT_THAT(page, HasSubstr(part));
  }
  for (const char* file : {"models/forest.model", "pipelines/forest.toml", "scene/boxes/mean_shift.csv",
                           "scene/poses/forest.txt", "scene/metrics.json", "scene/report.html",
                           "figures/figure4_scene.png", "tables/poses.csv", "timings/frames.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(out_ / file)) << file;
  }
}

TEST_F(ExperimentTest, ASecondRunDoesNothing) {
  ASSERT_THAT(run(), Succeeded());
  const auto before = write_times(out_);
  const ProgramRun again = run();
  ASSERT_THAT(again, Succeeded());
  EXPECT_THAT(again.out, Not(HasSubstr("training")));
  EXPECT_EQ(write_times(out_), before);
}

TEST_F(ExperimentTest, RedoesOnlyWhatAChangeTouches) {
  ASSERT_THAT(run(), Succeeded());
  const auto before = write_times(out_);
  write_text_file(folder_ / "mean_shift.toml",
                  "[segmentation]\nmethod = \"mean_shift\"\nbandwidth_mm = 12.0\n");
  ASSERT_THAT(run(), Succeeded());
  const auto after = write_times(out_);
  const auto is_redone = [&](const std::string& file) { return after.at(file) != before.at(file); };
  EXPECT_TRUE(is_redone("scene/boxes/mean_shift.csv"));
  EXPECT_TRUE(is_redone("report.html"));
  EXPECT_FALSE(is_redone("scene/boxes/threshold.csv"));
  EXPECT_FALSE(is_redone("models/forest.model"));
  EXPECT_FALSE(is_redone("scene/poses/forest.txt"));
}

TEST_F(ExperimentTest, ScaleCutsTrainingAndTest) {
  std::string scene = read_text_file(folder_ / "scene.toml");
  scene.replace(scene.find("frames = 6"), 10, "frames = 24");
  write_text_file(folder_ / "scene.toml", scene);
  ASSERT_THAT(run({"--scale", "0.5"}), Succeeded());
  const std::string boxes = read("scene/boxes/threshold.csv");
  EXPECT_EQ(std::count(boxes.begin(), boxes.end(), '\n'), 1 + 12);
  EXPECT_THAT(read("training/forest.model.toml"), HasSubstr("splits_per_node = 20"))
      << "it was least already";
  EXPECT_THAT(read("report.html"), HasSubstr("at scale 0.5"));
}

TEST_F(ExperimentTest, UsesTrainedModels) {
  ASSERT_THAT(run(), Succeeded());
  const std::string model = read("models/forest.model");
  std::filesystem::rename(out_ / "models", folder_ / "trained");
  const ProgramRun again = run({"--models", folder_ / "trained"});
  ASSERT_THAT(again, Succeeded());
  EXPECT_THAT(again.out, Not(HasSubstr("training")));
  EXPECT_EQ(read("models/forest.model"), model);
}

TEST_F(ExperimentTest, AGivenModelMustBeWhatThePlanAsksFor) {
  add_to_plan("[[model]]\nfile = \"dense.pt\"\nkind = \"network\"\nconfig = \"net.toml\"\ntrained = \"" +
              std::filesystem::absolute("models/dense.pt").string() + "\"\n");
  const std::string sources = "source = \"synthetic:scene.toml\"\nvalidation = \"synthetic:scene.toml\"\n";
  const std::string cube = "[patch]\nmode = \"cube\"\n";
  write_text_file(folder_ / "net.toml", sources + cube + "[network]\nconvention = \"icg20\"\n");
  EXPECT_THAT(run(), FailedWith("dense.pt: its convention is knuckle22"));
  write_text_file(folder_ / "net.toml", sources + cube + "[network]\narchitecture = \"pca\"\n");
  EXPECT_THAT(run(), FailedWith("dense.pt: its architecture is dense"));
  EXPECT_FALSE(std::filesystem::exists(out_ / "models/forest.model"))
      << "the fault is found before any training";
  write_text_file(folder_ / "net.toml", sources + cube + "[network]\nconvention = \"knuckle22\"\n");
  ASSERT_THAT(run(), Succeeded());
  EXPECT_THAT(read("report.html"), HasSubstr("models/dense.pt"));
}

TEST_F(ExperimentTest, AFailedTrainingPassesItsErrorOn) {
  add_to_plan("[[model]]\nfile = \"net.pt\"\nkind = \"network\"\nconfig = \"net.toml\"\n");
  write_text_file(folder_ / "net.toml",
                  "source = \"synthetic:scene.toml\"\nvalidation = \"synthetic:scene.toml\"\n"
                  "[patch]\nmode = \"cube\"\n[samples]\nmemory_gb = 0.00001\n");
  EXPECT_THAT(run(), FailedWith("more than memory_gb"));
  EXPECT_THAT(run({"--device", "abacus"}), FailedWith("device is \"abacus\""))
      << "the device is asked for first";
}

TEST_F(ExperimentTest, DoesOneStep) {
  EXPECT_THAT(run({"--step", "scene/poses/forest.txt"}), FailedWith("pipelines/forest.toml"))
      << "what it needs is not there";
  EXPECT_THAT(run({"--step", "forest"}), FailedWith("no step 'forest' in the experiment plan"));
  ASSERT_THAT(run({"--step", "models/forest.model"}), Succeeded());
  EXPECT_FALSE(std::filesystem::exists(out_ / "report.html"));
  const ProgramRun whole = run();
  ASSERT_THAT(whole, Succeeded());
  EXPECT_THAT(whole.out, Not(HasSubstr("training"))) << "the step was done";
}

TEST_F(ExperimentTest, NamesWhatIsWrong) {
  EXPECT_THAT(run_program({"experiment", "nonsense", "--out", out_}), FailedWith("scia15"));
  EXPECT_THAT(run({"--scale", "0"}), FailedWith("scale"));
  EXPECT_THAT(run({"--scale", "nan"}), FailedWith("scale"));
  EXPECT_THAT(run({"--models", folder_ / "nowhere"}), FailedWith("nowhere: not a folder of trained models"));
  write_text_file(folder_ / "forest.toml",
                  "[estimator]\nmethod = \"forest\"\nmodel = \"../models/none.model\"\n");
  EXPECT_THAT(run(), FailedWith("none.model"));
}

}  // namespace
}  // namespace knuckle::testing
