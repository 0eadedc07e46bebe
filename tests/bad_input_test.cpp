// SPDX-License-Identifier: Apache-2.0
// Bad input ends with status 1 and one line that names file and fault; nothing half-written stays.
#include "program.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "knuckle/core/random.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/model_testing.h"

namespace knuckle::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kDemoManifest = "manifests/demo.toml";
constexpr const char* kDemoSource = "synthetic:manifests/demo.toml?count=2";

class BadInputTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  /// A folder set of one frame; `depth` is its image.
  std::string make_set(const Image<std::uint16_t>& depth, const std::string& extra_toml = "",
                       const std::string& joints = "") {
    make_folder(path("set/depth"));
    const int width = depth.width();
    const int height = depth.height();
    write_text_file(path("set/dataset.toml"),
                    fmt::format("{}\n[camera]\nmodel = 'projective'\nwidth = {}\nheight = {}\nfx = {}\nfy = "
                                "{}\ncx = {}\ncy = {}\n",
                                extra_toml, width, height, 0.9 * width, 0.9 * width, width / 2, height / 2));
    write_png(path("set/depth/000000.png"), depth);
    if (!joints.empty()) write_text_file(path("set/joints.txt"), joints);
    return "folder:" + path("set");
  }

  ProgramRun inspect(const std::string& source) { return run_program({"inspect", "--source", source}); }

  ProgramRun estimate(const std::string& source, const std::string& pipeline = "pipelines/default.toml") {
    return run_program({"estimate", "--source", source, "--pipeline", pipeline, "--out", path("poses.txt")});
  }

  std::string pipeline_file(const std::string& toml) {
    write_text_file(path("pipeline.toml"), toml);
    return path("pipeline.toml");
  }

  std::string model_file() const { return std::filesystem::absolute("models/pose_forest.model"); }

  TemporaryFolder folder_;
  Image<std::uint16_t> blank_{64, 48};
};

TEST_F(BadInputTest, ASourceThatIsNoneOrMissing) {
  EXPECT_THAT(inspect("nowhere"), FailedWith("nowhere"));
  EXPECT_THAT(inspect("painting:x"), FailedWith("painting"));
  EXPECT_THAT(inspect("folder:/nowhere/set"), FailedWith("/nowhere/set"));
  EXPECT_THAT(inspect("h5:/nowhere/set.h5"), FailedWith("/nowhere/set.h5"));
  EXPECT_THAT(inspect("synthetic:/nowhere/m.toml"), FailedWith("/nowhere/m.toml"));
  for (const std::string kind : {"icg", "icvl", "nyu", "msra15", "hands17"}) {
    EXPECT_THAT(inspect(kind + ":/nowhere"), FailedWith("/nowhere")) << kind;
  }
}

TEST_F(BadInputTest, AnEmptySource) {
  make_folder(path("empty"));
  for (const std::string kind : {"folder", "icg", "icvl", "nyu", "msra15", "hands17"}) {
    EXPECT_THAT(inspect(kind + ":" + path("empty")), FailedWith("empty")) << kind;
  }
  make_set(blank_);
  std::filesystem::remove(path("set/depth/000000.png"));
  EXPECT_THAT(inspect("folder:" + path("set")), FailedWith("set"));
}

TEST_F(BadInputTest, ASelectionThatLeavesNothingOrIsNone) {
  const std::string set = make_set(blank_);
  EXPECT_THAT(inspect(set + "?first=5"), FailedWith("first"));
  EXPECT_THAT(inspect(set + "?count=many"), FailedWith("count"));
  EXPECT_THAT(inspect(set + "?colour=red"), FailedWith("colour"));
  EXPECT_THAT(run_program({"inspect", "--source", set, "--frame", "1"}), FailedWith("frame 1"));
}

TEST_F(BadInputTest, ADepthImageThatIsCutShortOrNoneOrOfAnotherKind) {
  const std::string set = make_set(blank_);
  const std::string bytes = read_text_file(path("set/depth/000000.png"));
  write_text_file(path("set/depth/000000.png"), bytes.substr(0, bytes.size() / 2));
  EXPECT_THAT(inspect(set), FailedWith("000000.png"));
  write_text_file(path("set/depth/000000.png"), "no picture");
  EXPECT_THAT(inspect(set), FailedWith("000000.png"));
  write_png(path("set/depth/000000.png"), Image<std::uint8_t>(64, 48));
  EXPECT_THAT(inspect(set), FailedWith("000000.png"));
  write_png(path("set/depth/000000.png"), Image<std::uint16_t>(32, 48));
  EXPECT_THAT(inspect(set), FailedWith("000000.png"));
}

TEST_F(BadInputTest, LabelsWithTooFewOrOtherThanNumbers) {
  std::string joints;
  for (int i = 0; i < 20; ++i) joints += "1 2 300 ";
  EXPECT_THAT(inspect(make_set(blank_, "convention = 'icg20'", joints)), Succeeded());
  EXPECT_THAT(inspect(make_set(blank_, "convention = 'icg20'", "1 2 3\n")), FailedWith("joints.txt"));
  EXPECT_THAT(inspect(make_set(blank_, "convention = 'icg20'", "x" + joints)), FailedWith("joints.txt"));
  EXPECT_THAT(inspect(make_set(blank_, "convention = 'icg21'", joints)), FailedWith("icg21"));
}

TEST_F(BadInputTest, AnIcgSetWithoutCalibration) {
  make_folder(path("icg/clean"));
  write_text_file(path("icg/clean/1_2_depth.csv"), "400,400\n400,400\n");
  EXPECT_THAT(inspect("icg:" + path("icg")), FailedWith("calib"));
  write_text_file(path("icg/calib.txt"), "200 200\n1 1\n");
  EXPECT_THAT(inspect("icg:" + path("icg")), Succeeded());
  write_text_file(path("icg/clean/1_2_depth.csv"), "400,400\n400\n");
  EXPECT_THAT(inspect("icg:" + path("icg")), FailedWith("1_2_depth.csv"));
  write_text_file(path("icg/clean/1_2_depth.csv"), "400,400\n400,far\n");
  EXPECT_THAT(inspect("icg:" + path("icg")), FailedWith("1_2_depth.csv"));
}

TEST_F(BadInputTest, AnExrOrH5ThatIsCutShortOrForeign) {
  ASSERT_THAT(run_program({"render", "--manifest", kDemoManifest, "--count", "2", "--out", path("set.h5")}),
              Succeeded());
  const std::string bytes = read_text_file(path("set.h5"));
  write_text_file(path("cut.h5"), bytes.substr(0, bytes.size() / 2));
  EXPECT_THAT(inspect("h5:" + path("cut.h5")), FailedWith("cut.h5"));
  write_text_file(path("foreign.h5"), "text");
  EXPECT_THAT(inspect("h5:" + path("foreign.h5")), FailedWith("foreign.h5"));
  EXPECT_THAT(inspect("h5:" + model_file()), FailedWith("pose_forest.model"));

  ASSERT_THAT(run_program({"render", "--manifest", kDemoManifest, "--count", "1", "--format", "icg", "--out",
                           path("icg")}),
              Succeeded());
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path("icg"))) {
    if (entry.path().extension() == ".exr")
      write_text_file(entry.path(), read_text_file(entry.path()).substr(0, 500));
  }
  EXPECT_THAT(inspect("icg:" + path("icg")), FailedWith(".exr"));
}

TEST_F(BadInputTest, PredictionsWithFewerOrOtherLinesThanTruth) {
  ASSERT_THAT(run_program({"estimate", "--source", kDemoSource, "--out", path("two.txt")}), Succeeded());
  const auto evaluate = [&](const std::string& truth, const std::string& predictions) {
    return run_program({"evaluate", "--truth", truth, "--predictions", predictions});
  };
  EXPECT_THAT(evaluate("synthetic:manifests/demo.toml?count=3", "x=" + path("two.txt")),
              FailedWith("two.txt"));
  EXPECT_THAT(evaluate(kDemoSource, "x=" + path("none.txt")), FailedWith("none.txt"));
  EXPECT_THAT(evaluate(kDemoSource, path("two.txt")), FailedWith("two.txt"));
  EXPECT_THAT(evaluate(path("two.txt"), "x=" + path("two.txt")), FailedWith("--camera"));
  write_text_file(path("bad.txt"), "# convention: icg20\n1 2 three\n");
  EXPECT_THAT(evaluate("synthetic:manifests/demo.toml?count=1", "x=" + path("bad.txt")),
              FailedWith("bad.txt:2"));
}

TEST_F(BadInputTest, APipelineWithAnUnknownKeyTypeOrRange) {
  const std::string estimator = "[estimator]\nmethod = 'forest'\nmodel = '" + model_file() + "'\n";
  EXPECT_THAT(estimate(kDemoSource, pipeline_file(estimator)), Succeeded());
  const auto fault = [&](const std::string& toml, const std::string& part) {
    EXPECT_THAT(estimate(kDemoSource, pipeline_file(estimator + toml)), FailedWith("pipeline.toml:" + part))
        << toml;
  };
  fault("[segmentation]\nbandwith_mm = 13\n", "5: segmentation.bandwith_mm: unknown key");
  fault("[segmentation]\nbandwidth_mm = 'wide'\n", "5: segmentation.bandwidth_mm: expected a number");
  fault("[segmentation]\nbandwidth_mm = -1\n", "5: segmentation.bandwidth_mm: is -1");
  fault("[segmentation]\nmethod = 'magic'\n", "5: segmentation.method");
  fault("[hand]\nside = 'both'\n", "5: hand.side");
  fault("[hand]\nmax_hands = 0\n", "5: hand.max_hands: is 0");
  fault("[patch]\nsize_px = 48\n", "5: patch.size_px: is 48, but the model was trained on patches of 96 px");
  fault("[[refine]]\nmethod = 'polish'\n", "5: refine[1].method");
  fault("[extra]\n", "4: extra: unknown key");
  EXPECT_THAT(estimate(kDemoSource, pipeline_file("[estimator]\nmethod = 'forest'\n")), FailedWith("model"));
  EXPECT_THAT(estimate(kDemoSource, pipeline_file("[estimator\n")), FailedWith("pipeline.toml:1"));
  EXPECT_THAT(estimate(kDemoSource, path("none.toml")), FailedWith("none.toml"));
}

TEST_F(BadInputTest, AModelThatIsMissingCutShortForeignOrOfAnotherVersion) {
  const std::string pipeline = pipeline_file("[estimator]\nmethod = 'forest'\nmodel = 'model.model'\n");
  EXPECT_THAT(estimate(kDemoSource, pipeline), FailedWith("model.model"));
  const std::string bytes = read_text_file(model_file());
  for (const double part : {0.001, 0.3, 0.95}) {
    write_text_file(path("model.model"),
                    bytes.substr(0, static_cast<std::size_t>(part * double(bytes.size()))));
    EXPECT_THAT(estimate(kDemoSource, pipeline), FailedWith("model.model")) << part;
  }
  write_text_file(path("model.model"), bytes);
  EXPECT_THAT(estimate(kDemoSource, pipeline), Succeeded());
  change_model(path("model.model"), [](ModelWriter& model) { model.set_format("knuckle-forest", 99); });
  EXPECT_THAT(estimate(kDemoSource, pipeline), FailedWith("version 99"));
}

TEST_F(BadInputTest, AManifestThatIsWrong) {
  write_text_file(path("manifest.toml"), "frames = -3\n");
  EXPECT_THAT(inspect("synthetic:" + path("manifest.toml")), FailedWith("manifest.toml:1: frames"));
  write_text_file(path("manifest.toml"), "farmes = 3\n");
  EXPECT_THAT(inspect("synthetic:" + path("manifest.toml")), FailedWith("manifest.toml:1: farmes"));
  const auto fault = [&](const std::string& toml, const std::string& part) {
    write_text_file(path("manifest.toml"), toml);
    EXPECT_THAT(run_program({"render", "--manifest", path("manifest.toml"), "--out", path("x.h5")}),
                FailedWith("manifest.toml" + part))
        << toml;
  };
  fault("[body]\npeople = 0\n", ":2: body.people: is 0");
  fault("[sensor]\nsigma = 3\n", ":2: sensor.sigma: unknown key");
  fault("[sensor]\nsigma_mm = -1\n", ":2: sensor.sigma_mm: is -1");
  fault("[placement]\nnearest_mm = 600\nfarthest_mm = 500\n", ": [placement]");
  fault("[camera]\nwidth = 0\n", ":2: camera.width: is 0");
  fault("[camera]\nfx = 'wide'\n", ":2: camera.fx: expected a number");
  fault(
      "[pose]\ngesture_share = 0\npair_share = 0\nmixed_share = 0\nclosing_share = 0\ngrasp_share = 0\n"
      "uniform_share = 0\n",
      ": [pose]");
  fault("frames = 'many'\n", ":1: frames: expected a whole number");
  fault("frames = 3\nframes = 4\n", ":2: no valid TOML");
  write_text_file(path("manifest.toml"), "[body]\nfile = 'nobody.model'\n");
  EXPECT_THAT(inspect("synthetic:" + path("manifest.toml")),
              FailedWith("nobody.model: cannot read: No such file"));
  write_text_file(path("nobody.model"), "no body");
  EXPECT_THAT(inspect("synthetic:" + path("manifest.toml")), FailedWith("nobody.model: not a model's file"));
  EXPECT_THAT(entries_of(folder_.path()), Not(Contains(HasSubstr("x.h5"))));
  EXPECT_THAT(
      run_program({"render", "--manifest", kDemoManifest, "--first", "100000", "--out", path("x.h5")}),
      FailedWith("demo.toml"));
  EXPECT_THAT(run_program({"render", "--manifest", kDemoManifest, "--format", "gif", "--out", path("x.gif")}),
              FailedWith("gif"));
}

TEST_F(BadInputTest, ATrainingWithoutTruthOrWithAWrongConfiguration) {
  const auto train = [&](const std::string& toml) {
    write_text_file(path("train.toml"), toml);
    return run_program(
        {"train", "pose-forest", "--config", path("train.toml"), "--out", path("forest.model")});
  };
  make_set(blank_);
  EXPECT_THAT(train("source = 'folder:set'\n"), FailedWith("no truth"));
  EXPECT_THAT(train(""), FailedWith("source: is missing"));
  EXPECT_THAT(train("source = 'folder:set'\nconvention = 'icg21'\n"), FailedWith("train.toml:2: convention"));
  EXPECT_THAT(train("source = 'folder:set'\n[forest]\ntrees = 0\n"),
              FailedWith("train.toml:3: forest.trees"));
  EXPECT_THAT(train("source = 'folder:set'\n[forest]\ntress = 2\n"),
              FailedWith("train.toml:3: forest.tress"));
  std::string joints;
  for (int i = 0; i < 20; ++i) joints += "1 2 300 ";
  make_set(blank_, "convention = 'icg20'", joints);
  EXPECT_THAT(train("source = 'folder:set'\n"), FailedWith("no frame can be trained on"));
  EXPECT_THAT(entries_of(folder_.path()), Not(Contains("forest.model")));
}

TEST_F(BadInputTest, OutputThatCannotBeWrittenLeavesNothing) {
  const std::string nowhere = "/proc/knuckle/out";
  EXPECT_THAT(run_program({"segment", "--source", kDemoSource, "--out", nowhere}), FailedWith(nowhere));
  EXPECT_THAT(run_program({"estimate", "--source", kDemoSource, "--out", nowhere}), FailedWith(nowhere));
  EXPECT_THAT(run_program({"demo", "--out", nowhere}), FailedWith(nowhere));
  EXPECT_THAT(run_program({"inspect", "--source", kDemoSource, "--png", nowhere}), FailedWith(nowhere));
  for (const std::string format : {"h5", "folder", "icg"}) {
    EXPECT_THAT(run_program({"render", "--manifest", kDemoManifest, "--count", "1", "--format", format,
                             "--out", nowhere}),
                FailedWith(nowhere))
        << format;
  }
}

TEST_F(BadInputTest, OutputThatCannotBeWrittenIsSaidBeforeTheWork) {
  // There is no such source either, which would be said first by whatever began to work.
  const std::string nowhere = path("none/out");
  const std::string source = "folder:" + path("missing");
  for (const char* verb : {"segment", "estimate"}) {
    EXPECT_THAT(run_program({verb, "--source", source, "--out", nowhere}), FailedWith(nowhere));
    EXPECT_THAT(run_program({verb, "--source", source, "--out", path("out"), "--json", nowhere}),
                FailedWith(nowhere));
  }
  write_text_file(path("network.toml"), "source = '" + source + "'\nvalidation = '" + source + "'\n");
  write_text_file(path("forest.toml"), "source = '" + source + "'\n");
  for (const auto& [kind, config] :
       {std::pair("pose-forest", "forest.toml"), std::pair("segmentation-forest", "forest.toml"),
        std::pair("network", "network.toml")}) {
    EXPECT_THAT(run_program({"train", kind, "--config", path(config), "--out", nowhere}), FailedWith(nowhere))
        << kind;
  }
}

TEST_F(BadInputTest, AFullDiskLeavesNothingUnderTheFinalName) {
  make_folder(path("out"));
  EXPECT_THAT(run_program_on_full_disk(
                  4, {"render", "--manifest", kDemoManifest, "--count", "4", "--out", path("out/set.h5")}),
              FailedWith("set.h5"));
  EXPECT_THAT(entries_of(path("out")), Not(Contains("set.h5")));
  EXPECT_THAT(
      run_program_on_full_disk(4, {"inspect", "--source", kDemoSource, "--png", path("out/frame.png")}),
      FailedWith("frame.png"));
  EXPECT_THAT(entries_of(path("out")), Not(Contains("frame.png")));
  EXPECT_THAT(run_program_on_full_disk(1, {"estimate", "--source", "synthetic:manifests/demo.toml?count=20",
                                           "--out", path("out/poses.txt")}),
              FailedWith("poses.txt"));
  EXPECT_THAT(entries_of(path("out")), Not(Contains("poses.txt")));
  EXPECT_THAT(run_program_on_full_disk(20, {"demo", "--out", path("out/demo")}), FailedWith("out/demo"));
  EXPECT_THAT(entries_of(path("out/demo")), Not(Contains("report.html")));
}

TEST_F(BadInputTest, AFrameOfZerosHasNoHand) {
  ASSERT_THAT(estimate(make_set(blank_)), Succeeded());
  EXPECT_THAT(read_lines(path("poses.txt"))[1], HasSubstr("nan nan nan"));
}

TEST_F(BadInputTest, AFrameThatIsCoveredOrOfOnePixelOrOf48MillionHasNoHand) {
  const std::pair<int, int> sizes[] = {{64, 48}, {1, 1}, {8000, 6000}};
  for (const auto& [width, height] : sizes) {
    ASSERT_THAT(estimate(make_set(Image<std::uint16_t>(width, height, 500))), Succeeded());
    EXPECT_THAT(read_lines(path("poses.txt"))[1], HasSubstr("nan nan nan")) << width << " x " << height;
  }
}

TEST_F(BadInputTest, AFrameOfNoiseOrAHandAtTheBorderIsAStatus) {
  Random random(3);
  for (auto& pixel : blank_.pixels()) pixel = static_cast<std::uint16_t>(random());
  ASSERT_THAT(estimate(make_set(blank_)), Succeeded());
  const std::string noise = read_lines(path("poses.txt"))[1];
  EXPECT_TRUE(noise.find("nan") == std::string::npos ||
              noise.find_first_of("0123456789") == std::string::npos)
      << "a pose is whole or missing: " << noise;

  for (int row = 0; row < 48; ++row) {
    for (int column = 0; column < 64; ++column) blank_(column, row) = column < 20 ? 400 : 0;
  }
  ASSERT_THAT(estimate(make_set(blank_)), Succeeded());
  EXPECT_EQ(read_lines(path("poses.txt")).size(), 2u);
}

/// Runs the program on what is no regular file, which must not keep it waiting.
TEST_F(BadInputTest, AFifoAFolderADeviceOrASocketInPlaceOfAFile) {
  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);
  make_folder(path("folder"));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path("socket").copy(address.sun_path, sizeof(address.sun_path) - 1);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  ::close(socket);
  for (const std::string& file : {path("fifo"), path("folder"), path("socket"), std::string("/dev/zero")}) {
    EXPECT_THAT(inspect("h5:" + file), FailedWith("expected a file, found a"));
    EXPECT_THAT(inspect("synthetic:" + file), FailedWith("expected a file, found a"));
    EXPECT_THAT(estimate(kDemoSource, file), FailedWith("expected a file, found a"));
    EXPECT_THAT(
        estimate(kDemoSource, pipeline_file("[estimator]\nmethod = 'forest'\nmodel = '" + file + "'\n")),
        FailedWith("expected a file, found a"));
    EXPECT_THAT(run_program({"evaluate", "--truth", kDemoSource, "--predictions", "x=" + file}),
                FailedWith("expected a file, found a"));
  }
  const std::string set = make_set(blank_, "convention = 'icg20'");
  ASSERT_EQ(::mkfifo(path("set/joints.txt").c_str(), 0600), 0);
  EXPECT_THAT(inspect(set), FailedWith("joints.txt: expected a file, found a FIFO"));
}

TEST_F(BadInputTest, WhatGoesToTheTerminalIsPrintable) {
  const ProgramRun run = inspect("folder:/nowhere/\x1b[2J\xff\n");
  EXPECT_THAT(run, FailedWith("/nowhere/\\x1b[2J\\xff\\n"));
  write_text_file(path("bad.txt"), "# convention: \x1b]0;title\x07\n");
  EXPECT_THAT(run_program({"evaluate", "--truth", kDemoSource, "--predictions", "x=" + path("bad.txt")}),
              FailedWith("\\x1b]0;title\\x07"));
}

TEST_F(BadInputTest, APosesFileWithALineOfAHundredMegabytes) {
  write_text_file(path("poses.txt"), "# convention: icg20\n" + std::string(100'000'000, '1') + "\n");
  EXPECT_THAT(run_program({"evaluate", "--truth", kDemoSource, "--predictions", "x=" + path("poses.txt")}),
              FailedWith("poses.txt:2: the line has 100000000 characters"));
}

}  // namespace
}  // namespace knuckle::testing
