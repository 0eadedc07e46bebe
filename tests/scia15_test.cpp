// SPDX-License-Identifier: Apache-2.0
// The whole of the shipped experiment scia15, made small: every model, figure and table; killed and resumed.
#include "program.h"

#include <chrono>
#include <csignal>
#include <map>
#include <thread>

#include <nlohmann/json.hpp>

#include "knuckle/core/random.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

namespace fs = std::filesystem;

constexpr const char* kScale = "0.01";
constexpr const char* kScaleOfKills = "0.004";  // three runs, as quick as still trains each model
constexpr int kKilled = 128 + SIGKILL;
constexpr const char* kSequences[] = {"creative", "pico", "kinect_v2"};
constexpr const char* kModels[] = {"segmentation_forest.model",
                                   "pose_forest.model",
                                   "heatmap2d.pt",
                                   "heatmap25d.pt",
                                   "regression.pt",
                                   "pca.pt",
                                   "autoencoder.pt",
                                   "dense.pt"};

/// All files below a folder whose name ends so, by their names.
std::map<std::string, std::string> contents(const fs::path& folder, const std::vector<std::string>& ends) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    const bool is_asked =
        std::ranges::any_of(ends, [&](const std::string& end) { return name.ends_with(end); });
    if (entry.is_regular_file() && is_asked) files[name] = read_text_file(entry.path());
  }
  return files;
}

/// The results of an experiment, without what times are in.
std::map<std::string, std::string> results(const fs::path& out) {
  std::map<std::string, std::string> files = contents(out, {".csv", "metrics.json", ".txt"});
  std::erase_if(files, [](const auto& file) {
    const std::string& name = file.first;
    return name.starts_with("timings/") || name.starts_with("models/") ||
           name.find("/boxes/") != std::string::npos;
  });
  return files;
}

/// A file as it is; one of scores without what it says of motion, which so few frames do not know.
std::string without_motion(const std::string& name, const std::string& content) {
  if (!name.ends_with("metrics.json")) return content;
  auto scores = nlohmann::json::parse(content);
  for (auto& method : scores["methods"]) method.erase("motion");
  return scores.dump();
}

std::size_t steps_done(const fs::path& out) {
  if (!fs::exists(out)) return 0;
  std::size_t count = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(out, fs::directory_options::skip_permission_denied)) {
    count += entry.path().extension() == ".inputs" ? 1 : 0;
  }
  return count;
}

/// Command lines of all processes that speak of `path`.
std::vector<std::string> processes_with(const std::string& path) {
  std::vector<std::string> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::string line;
    try {
      line = read_text_file(entry.path() / "cmdline");
    } catch (const Error&) {
      continue;  // no process, or one that has ended
    }
    if (line.find(path) != std::string::npos) found.push_back(line);
  }
  return found;
}

/// The same after up to ten seconds: the system ends children a moment after their parent.
std::vector<std::string> processes_left_with(const std::string& path) {
  for (int i = 0; i < 100 && !processes_with(path).empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return processes_with(path);
}

/// The shipped experiment in a copy, so that it can be changed.
class Scia15Test : public ::testing::Test {
 protected:
  Scia15Test() {
    for (const char* name : {"experiments", "manifests", "pipelines"}) {
      fs::copy(name, folder_ / name, fs::copy_options::recursive);
    }
  }

  std::vector<std::string> command(const std::string& out, const char* scale) const {
    return {"experiment", folder_ / "experiments/scia15.toml", "--scale", scale, "--out", folder_ / out};
  }

  void expect_whole(const fs::path& out) const {
    for (const char* model : kModels) EXPECT_TRUE(fs::exists(out / "models" / model)) << model;
    for (const std::string sequence : kSequences) {
      for (const char* figure : {"figure4_", "figure5_2d_", "figure5_3d_", "figure5_frames_"}) {
        for (const char* format : {".svg", ".png"}) {
          EXPECT_TRUE(fs::exists(out / "figures" / (figure + sequence + format)))
              << figure << sequence << format;
        }
      }
    }
    EXPECT_THAT(read_lines(out / "tables/segmentation.csv"), ::testing::SizeIs(1 + 3 * 3));
    EXPECT_THAT(read_lines(out / "tables/poses.csv"), ::testing::SizeIs(1 + 3 * 7));
    EXPECT_THAT(read_lines(out / "timings/frames.csv"), ::testing::SizeIs(1 + 3 * 10));
    EXPECT_THAT(read_lines(out / "timings/trainings.csv"), ::testing::SizeIs(1 + 8));
    const std::vector<std::string> claims = read_lines(out / "timings/claims.csv");
    EXPECT_THAT(claims, ::testing::SizeIs(1 + 7));
    EXPECT_THAT(claims, Not(Contains(HasSubstr("not known"))));
    for (const auto& [name, content] : contents(out, {".csv", "metrics.json"})) {
      EXPECT_THAT(content, Not(HasSubstr("nan"))) << name;
      EXPECT_THAT(without_motion(name, content), Not(HasSubstr("null"))) << name;
    }
    for (const auto& [name, content] : contents(out, {".html"}))
      EXPECT_THAT(content, Not(HasSubstr(">nan"))) << name;
    EXPECT_THAT(read_text_file(out / "tables/poses.csv"), Not(HasSubstr(",,")));
  }

  TemporaryFolder folder_;
};

TEST_F(Scia15Test, IsWholeDoesNothingTwiceAndRedoesWhatHangsOnAChange) {
  const fs::path out = folder_ / "out";
  ASSERT_THAT(run_program(command("out", kScale)), Succeeded());
  expect_whole(out);

  const auto before = write_times(out);
  const ProgramRun again = run_program(command("out", kScale));
  ASSERT_THAT(again, Succeeded());
  EXPECT_EQ(write_times(out), before);
  EXPECT_THAT(again.out, Not(HasSubstr("ing ")));

  const fs::path pipeline = folder_ / "experiments/scia15/pca.toml";
  std::string text = read_text_file(pipeline);
  text.replace(text.find("bandwidth_mm = 13.5"), 19, "bandwidth_mm = 40.0");
  write_text_file(pipeline, text);
  ASSERT_THAT(run_program(command("out", kScale)), Succeeded());
  std::vector<std::string> redone;
  for (const auto& [name, time] : write_times(out)) {
    if (name.ends_with(".inputs") && time != before.at(name)) redone.push_back(name);
  }
  EXPECT_THAT(redone,
              ::testing::UnorderedElementsAre("pipelines/pca.toml.inputs", "creative/poses/pca.txt.inputs",
                                              "pico/poses/pca.txt.inputs", "kinect_v2/poses/pca.txt.inputs",
                                              "report.html.inputs"));
}

TEST_F(Scia15Test, KilledAtAnyMomentItEndsWithTheSameTables) {
  ASSERT_THAT(run_program(command("whole", kScaleOfKills)), Succeeded());
  const fs::path out = folder_ / "killed";
  const std::size_t all = steps_done(folder_ / "whole");
  // The trainings take most of the time, so most kills come in one of them.
  Random random(20150615);
  int killed = 0;
  for (int i = 0; i < 2; ++i) {
    const std::size_t steps =
        steps_done(out) + random.below(static_cast<std::uint32_t>(all - steps_done(out)) / 3);
    const auto delay = std::chrono::milliseconds(random.below(3000));
    auto moment = std::chrono::steady_clock::time_point::max();
    const ProgramRun run = run_program_until(
        [&] {
          const auto now = std::chrono::steady_clock::now();
          if (moment == std::chrono::steady_clock::time_point::max() && steps_done(out) >= steps)
            moment = now + delay;
          return now >= moment;
        },
        command("killed", kScaleOfKills));
    killed += run.status == kKilled ? 1 : 0;
    EXPECT_THAT(processes_left_with(out.string()), IsEmpty()) << "a child outlived the program";
  }
  EXPECT_GE(killed, 1) << "the program ended before it could be killed";
  ASSERT_THAT(run_program(command("killed", kScaleOfKills)), Succeeded());
  EXPECT_EQ(results(out), results(folder_ / "whole"));
}

}  // namespace
}  // namespace knuckle::testing
