// SPDX-License-Identifier: Apache-2.0
// Networks exported by the program, in other engines and in ours; and files that are not to be trusted.
#include "../program.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include <sys/wait.h>

#include "knuckle/core/regular_file.h"
#include "knuckle/data/poses_file.h"
#include "knuckle/estimate/create_estimator.h"
#include "knuckle/net/onnx/onnx_check.h"
#include "knuckle/net/onnx/onnx_engine.h"
#include "knuckle/net/onnx/onnx_file.h"
#include "knuckle/net/onnx/onnx_testing.h"
#include "knuckle/net/pose_network.h"
#include "knuckle/pipeline/hand_finder.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

constexpr int kSkipped = 77;
constexpr const char* kNoRuntime = "Node.js or onnxruntime-node is missing (scripts/fetch_onnx_runtime.sh)";
constexpr double kMostMm = 0.01;  // that engines may differ in single precision
/// Frames that shipped networks are compared on; KNUCKLE_ONNX_FRAMES asks for more.
int frame_count() {
  const char* const asked = std::getenv("KNUCKLE_ONNX_FRAMES");
  return asked == nullptr ? 12 : std::atoi(asked);
}

int status_of(const std::string& command) {
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

/// Patches as a pipeline cuts them out of frames that no training has seen.
std::vector<HandPatch> patches_for(const PatchOptions& options, int count) {
  const auto source = open_source(fmt::format("synthetic:manifests/validate_network.toml?count={}", count));
  const HandFinder finder(OptionTable::parse("[segmentation]\nmethod = \"mean_shift\"\n", "finder"));
  const PatchExtractor extractor(options);
  std::vector<HandPatch> patches;
  for (std::int64_t i = 0; i < source->size(); ++i) {
    const Frame frame = source->read(i);
    const Segmentation found = finder.find_right(frame, std::nullopt);
    if (found.hands.empty()) continue;
    if (auto patch = extractor.extract(frame, found.hands.front())) patches.push_back(*std::move(patch));
  }
  return patches;
}

double distance_mm(const PatchPoint& a, const PatchPoint& b, const PatchOptions& options) {
  return std::hypot(a.u - b.u, a.v - b.v, a.d - b.d) * 0.5 * options.cube_mm;
}

void write_floats(const std::filesystem::path& path, const std::vector<float>& numbers) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(numbers.data()),
             static_cast<std::streamsize>(numbers.size() * sizeof(float)));
}

std::vector<float> read_floats(const std::filesystem::path& path) {
  const std::string bytes = read_regular_file(path, std::int64_t{1} << 30);
  std::vector<float> numbers(bytes.size() / sizeof(float));
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(float));
  return numbers;
}

/// A network that ships, exported by the program.
class ShippedNetwork : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    model_ = std::string("models/") + GetParam() + ".pt";
    onnx_ = folder_ / "net.onnx";
    ASSERT_THAT(run_program({"export", "--model", model_, "--out", onnx_}), Succeeded());
  }

  TemporaryFolder folder_;
  std::string model_;
  std::string onnx_;
};

class ShippedPoseNetwork : public ShippedNetwork {};

INSTANTIATE_TEST_SUITE_P(Onnx, ShippedNetwork, ::testing::Values("dense", "dense_scenes", "detector"));
INSTANTIATE_TEST_SUITE_P(Onnx, ShippedPoseNetwork, ::testing::Values("dense", "dense_scenes"));

TEST_P(ShippedNetwork, PassesTheCheckerOfTheOnnxLibrary) {
  const std::string program = KNUCKLE_PYTHON;
  if (program.empty()) GTEST_SKIP() << "no Python was found";
  const int status = status_of(program + " tests/onnx/check_onnx.py " + onnx_ + " > /dev/null");
  if (status == kSkipped) GTEST_SKIP() << "the ONNX library for Python (python3-onnx) is missing";
  EXPECT_EQ(status, 0);
}

TEST_P(ShippedPoseNetwork, GivesTheSamePoseInOpenCv) {
  if (!onnx_support().is_there) GTEST_SKIP() << onnx_support().text;
  const PoseNetwork network{std::filesystem::path(model_)};
  const auto estimator = create_estimator(
      OptionTable::parse(fmt::format("method = \"onnx\"\nmodel = \"{}\"\n", onnx_), "estimator"));
  const std::vector<HandPatch> patches = patches_for(network.options().patch, frame_count());
  ASSERT_GE(patches.size(), 0.9 * frame_count());
  double most_mm = 0.0;
  double most_confidence = 0.0;
  for (const HandPatch& patch : patches) {
    const NetworkPrediction expected = network.predict(patch.pixels);
    const PatchPose pose = estimator->estimate(patch);
    for (std::size_t j = 0; j < pose.joints.size(); ++j) {
      most_mm = std::max(most_mm, distance_mm(pose.joints[j], expected.joints[j], network.options().patch));
      most_confidence =
          std::max(most_confidence, std::abs(double{pose.confidence[j]} - double{expected.confidence[j]}));
    }
  }
  std::printf("%zu patches, %s: OpenCV and Knuckle differ by %.6f mm, confidences by %.6f\n", patches.size(),
              GetParam(), most_mm, most_confidence);
  EXPECT_LE(most_mm, kMostMm);
  EXPECT_LE(most_confidence, 1e-3);
}

TEST_P(ShippedPoseNetwork, GivesTheSamePoseInOnnxRuntime) {
  const PoseNetwork network{std::filesystem::path(model_)};
  const std::vector<HandPatch> patches = patches_for(network.options().patch, frame_count());
  std::vector<float> inputs;
  for (const HandPatch& patch : patches) {
    inputs.insert(inputs.end(), patch.pixels.pixels().begin(), patch.pixels.pixels().end());
  }
  write_floats(folder_ / "inputs", inputs);
  const std::string answers = folder_ / "answers";
  const int status = status_of("node tests/onnx/run_onnx.cjs " + onnx_ + " " +
                               std::string(folder_ / "inputs") + " " + answers + " > /dev/null 2>&1");
  if (status == kSkipped || status == 127) GTEST_SKIP() << kNoRuntime;
  ASSERT_EQ(status, 0);
  const std::vector<float> numbers = read_floats(answers);
  ASSERT_EQ(numbers.size() % patches.size(), 0u);
  const std::size_t stride =
      numbers.size() / patches.size();  // landmarks, then confidences, then what else there is
  double most_mm = 0.0;
  double most_confidence = 0.0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const NetworkPrediction expected = network.predict(patches[i].pixels);
    const float* const answer = numbers.data() + i * stride;
    const std::size_t joints = expected.joints.size();
    for (std::size_t j = 0; j < joints; ++j) {
      const PatchPoint joint{answer[3 * j], answer[3 * j + 1], answer[3 * j + 2]};
      most_mm = std::max(most_mm, distance_mm(joint, expected.joints[j], network.options().patch));
      most_confidence = std::max(most_confidence,
                                 std::abs(double{answer[3 * joints + j]} - double{expected.confidence[j]}));
    }
  }
  std::printf("%zu patches, %s: ONNX Runtime and Knuckle differ by %.6f mm, confidences by %.6f\n",
              patches.size(), GetParam(), most_mm, most_confidence);
  EXPECT_LE(most_mm, kMostMm);
  EXPECT_LE(most_confidence, 1e-3);
}

/// What the engine makes of the operators on the list is what ONNX Runtime does.
TEST(OnnxOperators, MeanTheSameInOnnxRuntime) {
  if (!onnx_support().is_there) GTEST_SKIP() << onnx_support().text;
  const TemporaryFolder folder;
  const std::vector<OperatorCase> cases = operator_cases();
  std::string files;
  std::vector<std::vector<float>> found;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    OnnxModel written = cases[i].model;
    written.outputs.front().shape = cases[i].output;
    const OnnxModel checked = checked_onnx(cases[i].model, written.nodes.back().operation);
    std::vector<float> input;
    for (std::int64_t k = 0; k < count_of(checked.inputs.front().shape); ++k) {
      input.push_back(static_cast<float>(std::abs(std::sin(static_cast<double>(k)))) + 0.01f);
    }
    found.push_back(create_onnx_engine(checked, "node.onnx")->run(input).front());
    const std::string name =
        fmt::format("{}/{}_{}", folder.path().string(), i, written.nodes.back().operation);
    write_text_file(name + ".onnx", onnx_bytes(written));
    write_floats(name + ".in", input);
    files += fmt::format(" {0}.onnx {0}.in {0}.out", name);
  }
  const int status =
      status_of("node tests/onnx/run_onnx.cjs" + files + " > " + std::string(folder / "log") + " 2>&1");
  if (status == kSkipped || status == 127) GTEST_SKIP() << kNoRuntime;
  ASSERT_EQ(status, 0) << read_regular_file(folder / "log", 1 << 20);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string operation = cases[i].model.nodes.back().operation;
    SCOPED_TRACE(operation);
    const std::vector<float> expected = read_floats(folder / fmt::format("{}_{}.out", i, operation));
    ASSERT_EQ(found[i].size(), expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k) EXPECT_NEAR(found[i][k], expected[k], 1e-4) << k;
  }
}

class OnnxProgramTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  ProgramRun estimate(const std::string& pipeline, const std::string& out) {
    return run_program({"estimate", "--source", "synthetic:manifests/demo.toml?count=6", "--pipeline",
                        pipeline, "--out", path(out)});
  }
  ProgramRun estimate_with(const std::string& estimator) {
    write_text_file(
        path("p.toml"),
        "[hand]\nside = \"right\"\n[segmentation]\nmethod = \"mean_shift\"\n[estimator]\n" + estimator);
    return estimate(path("p.toml"), "poses.txt");
  }
  /// Runs a pipeline with such a file as its model.
  ProgramRun estimate_file(const std::string& bytes) {
    write_text_file(path("net.onnx"), bytes);
    return estimate_with("method = \"onnx\"\nmodel = \"net.onnx\"\nconvention = \"nyu14\"\n");
  }

  TemporaryFolder folder_;
};

TEST_F(OnnxProgramTest, AnExportedFileRunsWithNothingElseSaid) {
  if (!onnx_support().is_there) GTEST_SKIP() << onnx_support().text;
  ASSERT_THAT(run_program({"export", "--model", "models/dense.pt", "--out", path("dense.onnx")}),
              Succeeded());
  ASSERT_THAT(estimate_with(fmt::format("method = \"dense\"\nmodel = \"{}\"\n",
                                        std::filesystem::absolute("models/dense.pt").string())),
              Succeeded());
  const PoseSequence expected = read_poses_file(path("poses.txt"));
  ASSERT_THAT(estimate_with("method = \"onnx\"\nmodel = \"dense.onnx\"\n"), Succeeded());
  const PoseSequence found = read_poses_file(path("poses.txt"));
  ASSERT_EQ(found.poses.size(), 6u);
  for (std::size_t i = 0; i < found.poses.size(); ++i) {
    ASSERT_EQ(found.poses[i].joints.size(), 22u);
    for (std::size_t j = 0; j < 22; ++j) {
      EXPECT_NEAR(found.poses[i].joints[j].u, expected.poses[i].joints[j].u, 0.01);
      EXPECT_NEAR(found.poses[i].joints[j].v, expected.poses[i].joints[j].v, 0.01);
      EXPECT_NEAR(found.poses[i].joints[j].depth_mm, expected.poses[i].joints[j].depth_mm, 0.01);
    }
  }
}

TEST_F(OnnxProgramTest, ANetworkOfPyTorchsEstimatesTheDemo) {
  if (!onnx_support().is_there) GTEST_SKIP() << onnx_support().text;
  ASSERT_THAT(estimate("examples/foreign_network/hand.toml", "poses.txt"), Succeeded());
  const auto source = open_source("synthetic:manifests/demo.toml?count=6");
  const PoseSequence found = read_poses_file(path("poses.txt"));
  double sum_px = 0.0;
  int count = 0;
  for (std::int64_t i = 0; i < source->size(); ++i) {
    const Frame frame = source->read(i);
    const HandPose& pose = found.poses[static_cast<std::size_t>(i)];
    ASSERT_EQ(pose.convention.name, "mediapipe21");
    for (std::size_t j = 0; j < pose.joints.size(); ++j) {
      const int place = frame.truth->convention.index_of(pose.convention.landmarks[j]);
      ASSERT_GE(place, 0);
      const ImagePoint& truth = frame.truth->joints[static_cast<std::size_t>(place)];
      sum_px += std::hypot(pose.joints[j].u - truth.u, pose.joints[j].v - truth.v);
      ++count;
    }
  }
  EXPECT_LT(sum_px / count, 20.0) << "a hand is some 100 px wide";
}

TEST_F(OnnxProgramTest, WhatCannotBeTrustedIsOneLine) {
  if (!onnx_support().is_there) GTEST_SKIP() << onnx_support().text;
  const OnnxModel sound = one_node("Conv", {1, 1, 16, 16}, {{"w", filled({42, 1, 16, 16})}});
  const std::string bytes = onnx_bytes(sound);
  EXPECT_THAT(estimate_file(bytes), Succeeded());
  EXPECT_THAT(estimate_file(bytes.substr(0, bytes.size() / 2)), FailedWith("cut short"));
  EXPECT_THAT(estimate_file("no onnx"), FailedWith("net.onnx"));
  EXPECT_THAT(estimate_file(""), FailedWith("net.onnx"));
  OnnxModel later = sound;
  later.opset = 20;
  EXPECT_THAT(estimate_file(onnx_bytes(later)), FailedWith("opset 20"));
  EXPECT_THAT(estimate_file(onnx_bytes(one_node("Einsum", {1, 1, 16, 16}))), FailedWith("(Einsum)"));
  // 100 GB and more between input and output.
  const OnnxTensor scales = real_tensor({4}, {1, 1, 64, 64});
  OnnxModel large = one_node("Resize", {1, 1, 2048, 2048}, {{"", {}}, {"s", scales}});
  EXPECT_THAT(estimate_file(onnx_bytes(large)), FailedWith("too many"));
  EXPECT_THAT(estimate_with("method = \"onnx\"\nmodel = \"none.onnx\"\n"), FailedWith("none.onnx"));
  EXPECT_THAT(estimate_with("method = \"onnx\"\nmodel = \"net.onnx\"\n"),
              FailedWith("say what it wants and gives"));
}

TEST_F(OnnxProgramTest, WhatOpenCvCannotRunIsOneLine) {
  if (!onnx_support().is_there) GTEST_SKIP() << onnx_support().text;
  // A cubic scaling that passes no check, and a broadcast of two computed tensors that OpenCV may not know.
  OnnxModel model = one_node("GlobalAveragePool", {1, 1, 16, 16});
  model.nodes.front().outputs = {"mean"};
  model.constants["s"] = integer_list({16, 16});
  model.nodes.push_back({"Reshape", "square", {"x", "s"}, {"square"}});
  model.nodes.push_back({"MatMul", "product", {"square", "mean2"}, {"y"}});
  model.constants["s2"] = integer_list({16, 16});
  model.nodes.insert(model.nodes.end() - 1, {"Reshape", "again", {"x", "s2"}, {"mean2"}});
  const ProgramRun run = estimate_file(onnx_bytes(model));
  EXPECT_EQ(run.status, 1);
  EXPECT_EQ(error_lines(run).size(), 1u) << run.error;
}

TEST_F(OnnxProgramTest, ExportSaysWhatItCannot) {
  EXPECT_THAT(run_program({"export", "--model", "models/pose_forest.model", "--out", path("x.onnx")}),
              FailedWith("expected a network"));
  EXPECT_THAT(run_program({"export", "--model", path("none.pt"), "--out", path("x.onnx")}),
              FailedWith("none.pt"));
  EXPECT_THAT(run_program({"export", "--model", "models/dense.pt", "--out", "/nowhere/x.onnx"}),
              FailedWith("/nowhere/x.onnx"));
  EXPECT_EQ(run_program({"export", "--model", "models/dense.pt"}).status, 2);
  EXPECT_FALSE(std::filesystem::exists(path("x.onnx")));
}

}  // namespace
}  // namespace knuckle::testing
