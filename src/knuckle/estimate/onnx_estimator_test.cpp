// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/onnx_estimator.h"

#include <atomic>
#include <cmath>
#include <thread>

#include "knuckle/camera/projection.h"
#include "knuckle/core/testing.h"
#include "knuckle/estimate/create_estimator.h"
#include "knuckle/net/exported_network.h"
#include "knuckle/net/heat_map.h"
#include "knuckle/net/onnx/onnx_engine.h"
#include "knuckle/net/onnx/onnx_file.h"
#include "knuckle/net/onnx/onnx_testing.h"
#include "knuckle/patch/cube_patch.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using testing::error_of;
using testing::filled;
using ::testing::FloatNear;
using ::testing::HasSubstr;

constexpr int kSize = 8;
constexpr std::int64_t kJoints = 14;  // of nyu14

/// A network that always gives the same numbers, plus the sum over its input times `share`.
OnnxModel constant_network(const std::vector<float>& numbers, OnnxShape shape, float share = 0.0f) {
  OnnxModel model = testing::one_node("GlobalAveragePool", {1, 1, kSize, kSize});
  const auto count = static_cast<std::int64_t>(numbers.size());
  model.nodes.front().outputs = {"mean"};
  model.constants = {{"row", integer_list({1, 1})},
                     {"w", filled({count, 1}, share * kSize * kSize)},
                     {"b", real_tensor({count}, numbers)},
                     {"shape", integer_list(shape)}};
  model.nodes.push_back({"Reshape", "flat", {"mean", "row"}, {"flat"}});
  model.nodes.push_back({"Gemm", "gemm", {"flat", "w", "b"}, {"numbers"}, {{"transB", std::int64_t{1}}}});
  model.nodes.push_back({"Reshape", "y", {"numbers", "shape"}, {"y"}});
  return model;
}

std::vector<float> counted(std::int64_t count) {
  std::vector<float> numbers;
  for (std::int64_t i = 0; i < count; ++i) numbers.push_back(static_cast<float>(i) / 16.0f);
  return numbers;
}

class OnnxEstimatorTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!onnx_support().is_there) GTEST_SKIP() << onnx_support().text;
  }

  std::unique_ptr<Estimator> load(const OnnxModel& model, const std::string& toml) {
    write_text_file(folder_ / "net.onnx", onnx_bytes(model));
    write_text_file(folder_ / "p.toml", "method = \"onnx\"\nmodel = \"net.onnx\"\n" + toml);
    return create_estimator(OptionTable::load(folder_ / "p.toml"));
  }
  std::unique_ptr<Estimator> load(const OnnxModel& model) { return load(model, "convention = \"nyu14\"\n"); }

  std::string fault(const OnnxModel& model, const std::string& toml) {
    return error_of([&] { (void)load(model, "convention = \"nyu14\"\n" + toml); });
  }

  /// A patch that is background but for one pixel.
  static HandPatch patch(float d = 0.5f) {
    HandPatch result;
    result.pixels = Image<float>(kSize, kSize, kCubeBackground);
    result.pixels(3, 4) = d;
    result.camera = {CameraModel::projective, 320, 240, 200.0, 220.0, 150.0, 130.0, {}};
    result.geometry = cube_geometry(result.camera, {200.0, 90.0, 500.0}, {kSize, 250.0});
    return result;
  }

  testing::TemporaryFolder folder_;
};

TEST_F(OnnxEstimatorTest, PatchCoordinatesAreTakenAsTheyAre) {
  const auto estimator = load(constant_network(counted(3 * kJoints), {1, kJoints, 3}));
  EXPECT_EQ(estimator->convention().name, "nyu14");
  EXPECT_EQ(estimator->patches().options(),
            (PatchOptions{.size_px = kSize, .mode = "cube", .cube_mm = 250.0}));
  EXPECT_EQ(estimator->passes(), 2);
  const PatchPose pose = estimator->estimate(patch());
  ASSERT_EQ(pose.joints.size(), 14u);
  EXPECT_TRUE(pose.confidence.empty());
  EXPECT_EQ(pose.joints[2].u, 6 / 16.0);
  EXPECT_EQ(pose.joints[2].v, 7 / 16.0);
  EXPECT_EQ(pose.joints[2].d, 8 / 16.0);
}

TEST_F(OnnxEstimatorTest, AConventionOfOnesOwnIsAFileBesideThePipeline) {
  std::string names;
  for (const Landmark landmark : convention_from_name("nyu14").landmarks)
    names = fmt::format("\"{}\", {}", name_of(landmark), names);
  write_text_file(folder_ / "lab.toml",
                  fmt::format("convention = \"lab_turned\"\nlandmarks = [{}]\n", names));
  const auto estimator =
      load(constant_network(counted(3 * kJoints), {1, kJoints, 3}), "convention = \"lab.toml\"\n");
  EXPECT_EQ(estimator->convention().name, "lab_turned");
  EXPECT_EQ(estimator->convention().landmarks.back(), convention_from_name("nyu14").landmarks.front());
  EXPECT_EQ(estimator->estimate(patch()).joints[2].u, 6 / 16.0);
}

TEST_F(OnnxEstimatorTest, OtherRangesAreMapped) {
  std::vector<float> pixels(3 * kJoints, 0.0f);
  pixels[0] = 7.0f;   // the last pixel
  pixels[1] = 3.5f;   // the middle
  pixels[2] = 0.25f;  // a quarter of the way from far (0) to near (1)
  const auto estimator =
      load(constant_network(pixels, {1, 3 * kJoints}),
           "convention = \"nyu14\"\nfirst_pixel = 0\nlast_pixel = 7\nnear_depth = 1\nfar_depth = 0\n");
  const PatchPose pose = estimator->estimate(patch());
  EXPECT_DOUBLE_EQ(pose.joints[0].u, 1.0);
  EXPECT_DOUBLE_EQ(pose.joints[0].v, 0.0);
  EXPECT_DOUBLE_EQ(pose.joints[0].d, 0.5);
  EXPECT_DOUBLE_EQ(pose.joints[1].u, -1.0);
}

TEST_F(OnnxEstimatorTest, TheInputsValuesAreThoseThatAreAskedFor) {
  // What it gives is the sum of its input: 63 pixels of background and one of 0.5.
  const OnnxModel network = constant_network(std::vector<float>(3 * kJoints, 0.0f), {1, kJoints, 3}, 1.0f);
  const auto u_of = [&](const std::string& toml) {
    return load(network, "convention = \"nyu14\"\n" + toml)->estimate(patch()).joints[0].u;
  };
  EXPECT_NEAR(u_of(""), 63.5, 1e-4);
  EXPECT_NEAR(u_of("near_value = 1\nfar_value = 0\n"), 0.25, 1e-5);
  EXPECT_NEAR(u_of("near_value = 0\nfar_value = 255\n"), 63 * 255 + 0.75 * 255, 0.05);
  // Of the segmented hand, d runs to 3 deviations: 1 and 0.5 of them.
  EXPECT_NEAR(u_of("patch = \"hand\"\n"), 63.5, 1e-4);
  EXPECT_NEAR(u_of("patch = \"hand\"\nnear_value = -1\nfar_value = 1\n"), 63.5 / 3, 1e-4);
}

TEST_F(OnnxEstimatorTest, AnOrderOfItsOwnIsSorted) {
  const Convention& convention = convention_from_name("nyu14");
  std::string order = "\"-\"";
  for (std::size_t i = convention.landmarks.size(); i-- > 0;)
    order += fmt::format(", \"{}\"", name_of(convention.landmarks[i]));
  const OnnxModel network = constant_network(counted(3 * 15), {1, 15, 3});
  const PatchPose pose =
      load(network, "convention = \"nyu14\"\norder = [" + order + "]\n")->estimate(patch());
  ASSERT_EQ(pose.joints.size(), 14u);
  EXPECT_EQ(pose.joints[13].u, 3 / 16.0);
  EXPECT_EQ(pose.joints[0].d, 44 / 16.0);
  EXPECT_THAT(fault(network, "order = [\"thumb\"]\n"), HasSubstr("'thumb' is no landmark of nyu14"));
  EXPECT_THAT(fault(network, "order = [\"thumb_tip\", \"thumb_tip\"]\n"), HasSubstr("twice"));
  EXPECT_THAT(fault(network, "order = [\"thumb_tip\"]\n"), HasSubstr("is missing"));
}

TEST_F(OnnxEstimatorTest, AllFirstCoordinatesFirstIsSeenByTheShape) {
  const PatchPose pose = load(constant_network(counted(3 * kJoints), {1, 3, kJoints}))->estimate(patch());
  EXPECT_EQ(pose.joints[2].u, 2 / 16.0);
  EXPECT_EQ(pose.joints[2].v, (2 + 14) / 16.0);
  EXPECT_EQ(pose.joints[2].d, (2 + 28) / 16.0);
}

TEST_F(OnnxEstimatorTest, PointsInSpaceAreProjected) {
  const HandPatch seen = patch();
  const Projection projection(seen.camera);
  const Point3 centre = projection.to_camera(ImagePoint{200.0, 90.0, 500.0});
  const auto place_of = [&](const Point3& offset) {
    return seen.geometry.to_patch(projection.to_image(Point3(centre + offset)));
  };
  std::vector<float> numbers(3 * kJoints, 0.0f);
  numbers[0] = 0.2f;
  numbers[1] = 0.3f;
  numbers[2] = -0.4f;
  const auto expect_first = [&](const std::string& axes, const Point3& offset) {
    const auto estimator =
        load(constant_network(numbers, {1, kJoints, 3}),
             "convention = \"nyu14\"\ngives = \"xyz\"\nxyz_mm = 100\naxes = \"" + axes + "\"\n");
    const PatchPose pose = estimator->estimate(seen);
    const PatchPoint expected = place_of(offset);
    EXPECT_NEAR(pose.joints[0].u, expected.u, 1e-6) << axes;
    EXPECT_NEAR(pose.joints[0].v, expected.v, 1e-6) << axes;
    EXPECT_NEAR(pose.joints[0].d, expected.d, 1e-6) << axes;
    EXPECT_NEAR(pose.joints[1].u, 0.0, 1e-9) << "the patch's centre";
  };
  expect_first("right_down_far", {20, 30, -40});
  expect_first("right_up_far", {20, -30, -40});
  expect_first("right_up_near", {20, -30, 40});
  numbers[2] = -100.0f;
  EXPECT_THAT(error_of([&] {
                (void)load(constant_network(numbers, {1, kJoints, 3}),
                           "convention = \"nyu14\"\ngives = \"xyz\"\nxyz_mm = 100\n")
                    ->estimate(seen);
              }),
              HasSubstr("behind the camera"));
}

TEST_F(OnnxEstimatorTest, PeaksOfHeatMapsAreFound) {
  constexpr int kCells = 6;
  std::vector<float> maps;
  for (int joint = 0; joint < kJoints; ++joint) {
    for (int row = 0; row < kCells; ++row) {
      for (int column = 0; column < kCells; ++column) {
        const double x = column - 2.3;
        const double y = row - 3.1;
        maps.push_back(static_cast<float>(0.8 * std::exp(-0.5 * (x * x + y * y))));
      }
    }
  }
  const auto estimator = load(constant_network(maps, {1, kJoints, kCells, kCells}),
                              "convention = \"nyu14\"\ngives = \"heat_maps\"\n");
  const PatchPose pose = estimator->estimate(patch());
  const HeatMapGrid grid{kCells, kSize};
  EXPECT_NEAR(pose.joints[5].u, grid.coordinate_of(2.3), 1e-4);
  EXPECT_NEAR(pose.joints[5].v, grid.coordinate_of(3.1), 1e-4);
  EXPECT_NEAR(pose.joints[5].d, 0.5 + 12.0 / 125.0, 1e-6) << "behind the skin";
  EXPECT_THAT(pose.confidence, Each(FloatNear(0.8f * std::exp(-0.5f * (0.09f + 0.01f)), 1e-3f)));
}

TEST_F(OnnxEstimatorTest, ConfidencesComeFromTheirOutput) {
  OnnxModel network = constant_network(counted(3 * kJoints), {1, kJoints, 3});
  std::vector<float> confidences(kJoints, 0.25f);
  confidences[3] = 1.5f;
  network.constants["c"] = real_tensor({kJoints}, confidences);
  network.constants["cw"] = filled({kJoints, 1}, 0.0f);
  network.nodes.push_back({"Gemm", "sure", {"flat", "cw", "c"}, {"sure"}, {{"transB", std::int64_t{1}}}});
  network.outputs.push_back({"sure", {}});
  EXPECT_THAT(fault(network, ""), AllOf(HasSubstr("2 outputs"), HasSubstr("y, sure")));
  EXPECT_THAT(fault(network, "landmarks_output = \"z\"\n"), HasSubstr("no output 'z'"));
  EXPECT_THAT(fault(network, "landmarks_output = \"sure\"\n"),
              HasSubstr("14 numbers, expected 3 for each of 14"));
  EXPECT_THAT(fault(network, "landmarks_output = \"y\"\nconfidence_output = \"y\"\n"),
              HasSubstr("42 numbers"));
  EXPECT_THAT(fault(network, "landmarks_output = \"y\"\nconfidence_output = \"certainty\"\n"),
              HasSubstr("net.onnx: it has no output 'certainty'"));
  const PatchPose pose =
      load(network, "convention = \"nyu14\"\nlandmarks_output = \"y\"\nconfidence_output = \"sure\"\n")
          ->estimate(patch());
  EXPECT_EQ(pose.confidence[0], 0.25f);
  EXPECT_EQ(pose.confidence[3], 1.0f);
}

TEST_F(OnnxEstimatorTest, WhatDoesNotFitIsSaid) {
  const OnnxModel network = constant_network(counted(3 * kJoints), {1, kJoints, 3});
  EXPECT_THAT(
      error_of([&] { (void)load(network, ""); }),
      AllOf(HasSubstr("p.toml:2"), HasSubstr("say what it wants and gives"), HasSubstr("convention")));
  EXPECT_THAT(error_of([&] { (void)load(network, "convention = \"icvl16\"\n"); }), HasSubstr("42 numbers"));
  EXPECT_THAT(error_of([&] { (void)load(network, "convention = \"nobodys\"\n"); }),
              AllOf(HasSubstr("p.toml"), HasSubstr("unknown convention 'nobodys'")));
  EXPECT_THAT(fault(network, "patch = \"sphere\"\n"), HasSubstr("patch"));
  EXPECT_THAT(fault(network, "patch_size_px = 64\n"), HasSubstr("patches of 8 x 8"));
  EXPECT_THAT(fault(network, "gives = \"xyz\"\nxyz_mm = 0\n"), HasSubstr("xyz_mm"));
  EXPECT_THAT(fault(network, "gives = \"heat_maps\"\n"), HasSubstr("square heat maps"));
  EXPECT_THAT(fault(network, "patch = \"hand\"\npasses = 2\n"), HasSubstr("looked at once"));
  EXPECT_THAT(fault(network, "near_value = 1\n"), HasSubstr("near_value and far_value are the same"));
  EXPECT_THAT(fault(network, "near_depth = 0.25\nfar_depth = 0.25\n"),
              HasSubstr("near_depth and far_depth are the same"));
  EXPECT_THAT(fault(network, "first_pixel = 0.5\nlast_pixel = 0.5\n"),
              HasSubstr("first_pixel and last_pixel are the same"));
  EXPECT_THAT(fault(network, "patch = \"hand\"\npasses = 1\ngives = \"heat_maps\"\n"),
              HasSubstr("heat maps look depth up in a cube"));
  EXPECT_THAT(fault(network, "patch = \"hand\"\ngives = \"heat_maps\"\n"),
              HasSubstr("heat maps look depth up in a cube"));
  EXPECT_THAT(fault(network, "near_value = 1\n"), HasSubstr("near_value and far_value are the same"));
  EXPECT_THAT(fault(network, "near_depth = 1\n"), HasSubstr("near_depth and far_depth are the same"));
  EXPECT_THAT(fault(network, "first_pixel = 1\n"), HasSubstr("first_pixel and last_pixel are the same"));
  EXPECT_THAT(fault(network, "colour = 1\n"), HasSubstr("colour"));
  OnnxModel colours = network;
  colours.inputs.front().shape = {1, 3, kSize, kSize};
  colours.constants["row"] = integer_list({1, 3});
  colours.constants["w"] = filled({3 * kJoints, 3}, 0.0f);
  EXPECT_THAT(fault(colours, ""), HasSubstr("expected a square patch of one channel"));
}

/// Metadata say that the file is one of ours.
TEST_F(OnnxEstimatorTest, AFileOfOursThatIsNotWhatItsMetadataSayIsRefused) {
  NetworkOptions options;
  options.architecture = "dense";
  options.patch.mode = "cube";
  options.patch.size_px = 32;
  const std::int64_t joints = options.landmarks().size();
  const auto fault_of = [&](std::int64_t size, const std::string& output, const OnnxShape& shape) {
    OnnxModel model = testing::one_node("GlobalAveragePool", {1, 1, size, size});
    const std::int64_t count = count_of(shape);
    model.nodes.front().outputs = {"mean"};
    model.constants = {
        {"row", integer_list({1, 1})}, {"w", filled({count, 1})}, {"shape", integer_list(shape)}};
    model.nodes.push_back({"Reshape", "flat", {"mean", "row"}, {"flat"}});
    model.nodes.push_back({"Gemm", "gemm", {"flat", "w"}, {"numbers"}, {{"transB", std::int64_t{1}}}});
    model.nodes.push_back({"Reshape", "last", {"numbers", "shape"}, {output}});
    model.outputs.front().name = output;
    set_exported_options(model, options);
    return error_of([&] { (void)load(model, ""); });
  };
  EXPECT_THAT(fault_of(16, "landmarks", {1, joints, 3}),
              AllOf(HasSubstr("its input is"), HasSubstr("but its metadata ask for")));
  EXPECT_THAT(fault_of(32, "others", {1, joints, 3}), HasSubstr("it has no output 'landmarks'"));
  EXPECT_THAT(fault_of(32, "landmarks", {1, joints, 2}),
              AllOf(HasSubstr("its output 'landmarks' is"), HasSubstr("but its metadata ask for")));
}

TEST_F(OnnxEstimatorTest, APatchOfAnotherSizeAndNumbersThatAreNotFiniteAreSaid) {
  const auto estimator = load(constant_network(counted(3 * kJoints), {1, kJoints, 3}));
  HandPatch small = patch();
  small.pixels = Image<float>(4, 4);
  EXPECT_THAT(error_of([&] { (void)estimator->estimate(small); }), HasSubstr("a patch of 4 x 4"));
  OnnxModel unsound = constant_network(counted(3 * kJoints), {1, kJoints, 3});
  unsound.nodes.back().outputs = {"before"};
  unsound.constants["minus_one"] = filled({1}, -1.0f);
  unsound.nodes.push_back({"Add", "below", {"before", "minus_one"}, {"below"}});
  unsound.nodes.push_back({"Sqrt", "y", {"below"}, {"y"}});
  EXPECT_THAT(fault(unsound, ""), HasSubstr("'y' is not finite"));
}

/// What `knuckle export` writes, of a network that always gives the same numbers.
OnnxModel exported(const std::string& landmarks_output, OnnxShape landmarks,
                   const std::string& confidence_output, std::int64_t confidences) {
  OnnxModel model = constant_network(counted(3 * kJoints), std::move(landmarks));
  model.inputs.front().shape = {1, 1, 32, 32};
  model.nodes.back().outputs = {landmarks_output};
  model.constants["c"] = filled({confidences}, 0.5f);
  model.constants["cw"] = filled({confidences, 1}, 0.0f);
  model.nodes.push_back(
      {"Gemm", "sure", {"flat", "cw", "c"}, {confidence_output}, {{"transB", std::int64_t{1}}}});
  model.outputs = {{landmarks_output, {}}, {confidence_output, {}}};
  NetworkOptions options;
  options.convention = "nyu14";
  options.patch.size_px = 32;
  set_exported_options(model, options);
  return model;
}

TEST_F(OnnxEstimatorTest, AnExportedFileIsWhatItsMetadataSay) {
  const OnnxModel sound = exported("landmarks", {1, kJoints, 3}, "confidence", kJoints);
  const auto estimator = load(sound, "");
  HandPatch seen = patch();
  EXPECT_THAT(error_of([&] { (void)estimator->estimate(seen); }),
              HasSubstr("a patch of 8 x 8, expected 32 x 32"));
  seen.pixels = Image<float>(32, 32, kCubeBackground);
  EXPECT_EQ(estimator->estimate(seen).joints[2].u, 6 / 16.0);
  EXPECT_THAT(estimator->estimate(seen).confidence, Each(0.5f));

  const auto fault_of = [&](const OnnxModel& model) { return error_of([&] { (void)load(model, ""); }); };
  OnnxModel small = sound;
  small.inputs.front().shape = {1, 1, 16, 16};
  EXPECT_THAT(fault_of(small),
              HasSubstr("net.onnx: its input is 1 x 1 x 16 x 16, but its metadata ask for 1 x 1 x 32 x 32"));
  EXPECT_THAT(fault_of(exported("joints", {1, kJoints, 3}, "confidence", kJoints)),
              HasSubstr("it has no output 'landmarks', which its metadata ask for"));
  EXPECT_THAT(fault_of(exported("landmarks", {1, kJoints, 3}, "sure", kJoints)),
              HasSubstr("it has no output 'confidence', which its metadata ask for"));
  EXPECT_THAT(fault_of(exported("landmarks", {1, 3, kJoints}, "confidence", kJoints)),
              HasSubstr("its output 'landmarks' is 1 x 3 x 14, but its metadata ask for 1 x 14 x 3"));
  EXPECT_THAT(fault_of(exported("landmarks", {1, kJoints, 3}, "confidence", kJoints - 1)),
              HasSubstr("its output 'confidence' is 1 x 13, but its metadata ask for 1 x 14"));
}

TEST_F(OnnxEstimatorTest, AnsweringIsSafeFromManyThreads) {
  const auto estimator = load(constant_network(counted(3 * kJoints), {1, kJoints, 3}, 0.01f));
  const double expected = estimator->estimate(patch()).joints[3].u;
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int k = 0; k < 50; ++k) wrong += estimator->estimate(patch()).joints[3].u == expected ? 0 : 1;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace knuckle
