// SPDX-License-Identifier: Apache-2.0
// The verbs as a user types them.
#include "program.h"

#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;

constexpr const char* kDemoSource = "synthetic:manifests/demo.toml?count=6";

class VerbsTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  TemporaryFolder folder_;
};

TEST_F(VerbsTest, EveryVerbHasHelpWithAnExampleAndThreads) {
  for (const std::vector<std::string>& verb : {std::vector<std::string>{"info"},
                                               {"inspect"},
                                               {"render"},
                                               {"train", "pose-forest"},
                                               {"train", "segmentation-forest"},
                                               {"segment"},
                                               {"shrink"},
                                               {"estimate"},
                                               {"live"},
                                               {"record"},
                                               {"cameras"},
                                               {"landmarks"},
                                               {"evaluate"},
                                               {"experiment"},
                                               {"demo"}}) {
    std::vector<std::string> arguments = verb;
    arguments.push_back("--help");
    const ProgramRun run = run_program(arguments);
    EXPECT_THAT(run, Succeeded());
    EXPECT_THAT(run.out, HasSubstr("Example:\n"));
    EXPECT_THAT(run.out, HasSubstr("\n  knuckle " + verb.front()));
    EXPECT_THAT(run.out, HasSubstr("--threads"));
  }
}

TEST_F(VerbsTest, WrongUsageEndsWithStatusTwo) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{},
        {"paint"},
        {"segment"},
        {"info", "--colour"},
        {"train"},
        {"segment", "--source", kDemoSource, "--out", "x", "--init", "somewhere"},
        {"info", "--threads", "-1"},
        {"info", "--threads", "many"}}) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.status, 2) << ::testing::PrintToString(arguments) << run.error;
    EXPECT_FALSE(run.error.empty());
  }
}

TEST_F(VerbsTest, MistypedWordsAreNamedWithTheNearestThatIsKnown) {
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"estimat", "--source", "x"}, "unknown verb 'estimat' (did you mean 'estimate'?); `knuckle --help`"},
      {{"estimate", "--sorce", "x"},
       "unknown option '--sorce' (did you mean '--source'?); `knuckle estimate --help`"},
      {{"estimate", "--sorce=x", "--out", "y"}, "unknown option '--sorce' (did you mean '--source'?)"},
      {{"train", "netwrk"}, "unknown verb 'netwrk' (did you mean 'network'?); `knuckle train --help`"},
      {{"info", "--colour"}, "unknown option '--colour'; `knuckle info --help`"},
      {{"info", "everything"}, "unknown argument 'everything'; `knuckle info --help`"},
      {{"qwertz"}, "unknown verb 'qwertz'; `knuckle --help`"}};
  for (const auto& [arguments, message] : cases) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.status, 2) << ::testing::PrintToString(arguments);
    EXPECT_THAT(run.error, StartsWith("knuckle: " + message));
    EXPECT_EQ(std::ranges::count(run.error, '\n'), 1) << run.error;
  }
}

TEST_F(VerbsTest, TheVersionIsASemanticOne) {
  const ProgramRun run = run_program({"--version"});
  EXPECT_THAT(run, Succeeded());
  EXPECT_THAT(run.out, MatchesRegex("knuckle [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST_F(VerbsTest, InfoListsEveryMethodByKind) {
  const ProgramRun run = run_program({"info", "--json"});
  ASSERT_THAT(run, Succeeded());
  const auto info = nlohmann::json::parse(run.out);
  EXPECT_THAT(info["cameras"].get<std::vector<std::string>>(), Contains("v4l2"));
  EXPECT_THAT(info["segmenters"].get<std::vector<std::string>>(), Contains("mean_shift"));
  EXPECT_THAT(info["estimators"].get<std::vector<std::string>>(), Contains("forest"));
  EXPECT_THAT(info["refiners"].get<std::vector<std::string>>(), Contains("depth_lookup"));
  EXPECT_THAT(info["sources"].get<std::vector<std::string>>(), Contains("synthetic"));
  EXPECT_EQ(info["conventions"].size(), 7u);
}

TEST_F(VerbsTest, InspectDrawsAFrame) {
  const ProgramRun run =
      run_program({"inspect", "--source", kDemoSource, "--frame", "2", "--png", path("frame.png")});
  ASSERT_THAT(run, Succeeded());
  EXPECT_THAT(run.out, HasSubstr("frames       6"));
  EXPECT_THAT(run.out, HasSubstr("knuckle22"));
  EXPECT_FALSE(read_png_rgb(path("frame.png")).empty());
}

TEST_F(VerbsTest, InspectMeasuresTheHandsOfASource) {
  const ProgramRun run =
      run_program({"inspect", "--source", kDemoSource, "--statistics", "--panels", path("panels.png")});
  ASSERT_THAT(run, Succeeded());
  EXPECT_THAT(run.out, HasSubstr("found in 6 of 6 frames"));
  EXPECT_THAT(run.out, HasSubstr("surface noise"));
  EXPECT_FALSE(read_png_rgb(path("panels.png")).empty());
}

TEST_F(VerbsTest, WhatIsRenderedReadsBackInEveryFormat) {
  for (const std::string format : {"h5", "folder", "icg"}) {
    const std::string out = path("set_" + format);
    ASSERT_THAT(run_program({"render", "--manifest", "manifests/demo.toml", "--format", format, "--out", out,
                             "--first", "2", "--count", "3"}),
                Succeeded());
    const ProgramRun run = run_program({"inspect", "--source", format + ":" + out, "--frame", "2"});
    ASSERT_THAT(run, Succeeded());
    EXPECT_THAT(run.out, HasSubstr("frames       3"));
    EXPECT_THAT(run.out, HasSubstr("joints known"));
  }
}

TEST_F(VerbsTest, RenderWritesItsManifestWithAllDefaults) {
  write_text_file(path("short.toml"), "frames = 2\nseed = 4\n[body]\npeople = 1\n");
  ASSERT_THAT(run_program({"render", "--manifest", path("short.toml"), "--out", path("a.h5")}), Succeeded());
  const std::string resolved = read_text_file(path("a.h5.options.toml"));
  EXPECT_THAT(resolved, HasSubstr("seed = 4"));
  EXPECT_THAT(resolved, HasSubstr("sigma_mm = 3.0"));
  EXPECT_THAT(resolved, HasSubstr("wrist_deg = "));
  const auto frame_of = [&](const std::string& manifest, const std::string& png) {
    EXPECT_THAT(
        run_program({"inspect", "--source", "synthetic:" + manifest, "--frame", "1", "--png", path(png)}),
        Succeeded());
    return read_text_file(path(png));
  };
  EXPECT_TRUE(frame_of(path("short.toml"), "a.png") == frame_of(path("a.h5.options.toml"), "b.png"))
      << "the resolved manifest makes other frames";
}

TEST_F(VerbsTest, RenderMakesAContactSheetAloneOrBesideItsFrames) {
  const auto sheet = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "render",    "--manifest", "manifests/demo.toml", "--contact-sheet", path("sheet.png"),
        "--columns", "3"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_THAT(run_program(arguments), Succeeded());
    const Image<Rgb> picture = read_png_rgb(path("sheet.png"));
    return std::pair(picture.width(), picture.height());
  };
  EXPECT_EQ(sheet({"--count", "5", "--first", "3"}), std::pair(1074, 318));
  EXPECT_THAT(entries_of(folder_.path()), ::testing::ElementsAre("sheet.png"));
  EXPECT_EQ(sheet({"--count", "5", "--tiles", "2", "--out", path("a.h5")}), std::pair(718, 162));
  EXPECT_THAT(run_program({"inspect", "--source", "h5:" + path("a.h5")}), Succeeded());
  EXPECT_EQ(run_program({"render", "--manifest", "manifests/demo.toml"}).status, 2) << "nothing to make";
}

TEST_F(VerbsTest, SegmentWritesOneLinePerFrame) {
  ASSERT_THAT(run_program({"segment", "--source", kDemoSource, "--pipeline", "pipelines/free_hand.toml",
                           "--out", path("boxes.csv")}),
              Succeeded());
  const auto lines = read_lines(path("boxes.csv"));
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_EQ(lines[0], "frame,found,x,y,width,height,milliseconds");
  for (std::size_t i = 1; i < lines.size(); ++i)
    EXPECT_THAT(lines[i], StartsWith(std::to_string(i - 1) + ",1,"));
  const std::string options = read_text_file(path("boxes.csv.options.toml"));
  EXPECT_THAT(options, HasSubstr("bandwidth_mm = 13.5"));
  EXPECT_THAT(options, HasSubstr("max_iterations = ")) << "defaults are written too";
}

TEST_F(VerbsTest, ASegmentationForestIsTrainedAndItsBoxesAreScored) {
  write_text_file(path("train.toml"),
                  "source = \"synthetic:" + std::filesystem::absolute("manifests/demo.toml").string() +
                      "?count=20\"\n[forest]\ntrees = 2\nsplits_per_node = 100\noffsets_per_node = 40\n");
  ASSERT_THAT(run_program({"train", "segmentation-forest", "--config", path("train.toml"), "--out",
                           path("forest.model")}),
              Succeeded());
  write_text_file(path("pipeline.toml"), "[segmentation]\nmethod = 'forest'\nmodel = 'forest.model'\n");
  ASSERT_THAT(run_program({"segment", "--source", kDemoSource, "--pipeline", path("pipeline.toml"), "--out",
                           path("boxes.csv"), "--json", path("segment.json")}),
              Succeeded());
  const auto summary = nlohmann::json::parse(read_text_file(path("segment.json")));
  EXPECT_EQ(summary["found"], 6);
  EXPECT_GT(summary["mask"]["mean_iou"], 0.8);

  ASSERT_THAT(
      run_program({"evaluate", "--truth", kDemoSource, "--boxes", "forest=" + path("boxes.csv"), "--boxes",
                   "again=" + path("boxes.csv"), "--json", path("scores.json"), "--out", path("report")}),
      Succeeded());
  const auto scores = nlohmann::json::parse(read_text_file(path("scores.json")));
  EXPECT_EQ(scores["segmentation"][1]["name"], "again");
  EXPECT_EQ(scores["segmentation"][0]["frames"], 6);
  EXPECT_GT(scores["segmentation"][0]["mean_iou"], 0.5);
  EXPECT_TRUE(std::filesystem::exists(path("report/figures/overlap.svg")));
  EXPECT_THAT(run_program({"evaluate", "--truth", kDemoSource}).error, HasSubstr("nothing to score"));
}

TEST_F(VerbsTest, EstimatesAreEvaluatedAgainstTheirSource) {
  ASSERT_THAT(run_program({"estimate", "--source", kDemoSource, "--pipeline", "pipelines/default.toml",
                           "--init", "truth", "--out", path("poses.txt"), "--json", path("summary.json")}),
              Succeeded());
  const auto lines = read_lines(path("poses.txt"));
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_EQ(lines[0], "# convention: knuckle22");
  const auto summary = nlohmann::json::parse(read_text_file(path("summary.json")));
  EXPECT_EQ(summary["frames"], 6);
  EXPECT_EQ(summary["found"], 6);

  ASSERT_THAT(run_program({"evaluate", "--truth", kDemoSource, "--predictions", "forest=" + path("poses.txt"),
                           "--json", path("scores.json"), "--out", path("report")}),
              Succeeded());
  const auto scores = nlohmann::json::parse(read_text_file(path("scores.json")));
  EXPECT_EQ(scores["methods"][0]["frames"], 6);
  EXPECT_GT(scores["methods"][0]["mean_3d_mm"], 0.0);
  EXPECT_LT(scores["methods"][0]["mean_3d_mm"], 60.0);
  EXPECT_THAT(read_text_file(path("report/report.html")), HasSubstr("<svg"));
  for (const std::string options : {"report/options.toml", "scores.json.options.toml"}) {
    EXPECT_THAT(read_text_file(path(options)), HasSubstr(fmt::format("truth = '{}'", kDemoSource)));
    EXPECT_THAT(read_text_file(path(options)), HasSubstr("even_frames = 8"));
  }
}

TEST_F(VerbsTest, AFrameWithoutAHandIsALineOfNanAndAMissingPrediction) {
  make_folder(path("set/depth"));
  write_text_file(
      path("set/dataset.toml"),
      "convention = 'icg20'\n[camera]\nmodel = 'projective'\nwidth = 32\nheight = 24\nfx = 30\nfy = 30\n"
      "cx = 16\ncy = 12\n");
  write_png(path("set/depth/0.png"), Image<std::uint16_t>(32, 24));
  std::string truth;
  for (int i = 0; i < 20; ++i) truth += "10 10 400 ";
  write_text_file(path("set/joints.txt"), truth + "\n");
  ASSERT_THAT(run_program({"estimate", "--source", "folder:" + path("set"), "--out", path("poses.txt")}),
              Succeeded());
  EXPECT_THAT(read_lines(path("poses.txt"))[1], StartsWith("nan nan nan"));
  ASSERT_THAT(run_program({"evaluate", "--truth", "folder:" + path("set"), "--predictions",
                           "x=" + path("poses.txt"), "--json", path("scores.json")}),
              Succeeded());
  EXPECT_EQ(nlohmann::json::parse(read_text_file(path("scores.json")))["methods"][0]["missing"], 1);
}

TEST_F(VerbsTest, ASourceWithoutTruthGivesAReportOfPictures) {
  ASSERT_THAT(run_program({"render", "--manifest", "manifests/demo.toml", "--format", "folder", "--out",
                           path("set"), "--count", "2"}),
              Succeeded());
  std::filesystem::remove(path("set/joints.txt"));
  const std::string source = "folder:" + path("set");
  ASSERT_THAT(run_program({"estimate", "--source", source, "--out", path("poses.txt")}), Succeeded());
  const std::string predictions = "x=" + path("poses.txt");
  EXPECT_THAT(run_program({"evaluate", "--truth", source, "--predictions", predictions}),
              FailedWith("no truth"));
  ASSERT_THAT(
      run_program({"evaluate", "--truth", source, "--predictions", predictions, "--out", path("report")}),
      Succeeded());
  EXPECT_THAT(read_text_file(path("report/report.html")), HasSubstr("data:image/png;base64,"));
  EXPECT_THAT(run_program({"evaluate", "--truth", source + "?count=1", "--predictions", predictions, "--out",
                           path("other")}),
              FailedWith("poses.txt"));
}

TEST_F(VerbsTest, TheForestFindsThePaintedHandOfARecording) {
  KNUCKLE_REQUIRE_SHARED_DATA(shared);
  ASSERT_THAT(run_program({"segment", "--source", "folder:" + (shared / "real/kinect_hand_mask").string(),
                           "--pipeline", "pipelines/forest_segmentation_wrist.toml", "--out",
                           path("boxes.csv"), "--json", path("scores.json")}),
              Succeeded());
  const auto scores = nlohmann::json::parse(read_text_file(path("scores.json")));
  EXPECT_GT(scores["mask"]["pixel_iou"], 0.90) << "a published forest that was trained on such frames: 0.965";
}

TEST_F(VerbsTest, AShrunkForestIsSmallerAndEstimates) {
  ASSERT_THAT(run_program({"shrink", "--model", "models/pose_forest.model", "--leaves", "2000", "--leaf-step",
                           "0.1", "--out", path("small.model")}),
              Succeeded());
  EXPECT_LT(std::filesystem::file_size(path("small.model")),
            std::filesystem::file_size("models/pose_forest.model") / 4);
  write_text_file(path("small.toml"),
                  "[patch]\nsize_px = 96\n[estimator]\nmethod = \"forest\"\nmodel = \"small.model\"\n");
  EXPECT_THAT(run_program({"estimate", "--source", kDemoSource, "--pipeline", path("small.toml"), "--out",
                           path("poses.txt")}),
              Succeeded());
  EXPECT_THAT(
      run_program({"shrink", "--model", "models/dense.pt", "--leaves", "9", "--out", path("b.model")}),
      FailedWith("models/dense.pt"));
  EXPECT_FALSE(std::filesystem::exists(path("b.model")));
}

/// "mean mm" of a method in what `evaluate --json` wrote.
double mean_error_mm(const std::string& file) {
  return nlohmann::json::parse(read_text_file(file))["methods"][0]["mean_3d_mm"];
}

TEST_F(VerbsTest, LandmarksThatAreLabelledElsewhereAreLearnedAndApplied) {
  const std::string source = "synthetic:manifests/demo.toml?count=24";
  const std::string fitted = source + "&step=2";
  const std::string held_out = source + "&first=1&step=2";
  ASSERT_THAT(run_program({"landmarks", "--source", fitted, "--out", path("marks.toml")}), Succeeded());
  ASSERT_THAT(run_program({"estimate", "--source", held_out, "--init", "truth", "--out", path("plain.txt")}),
              Succeeded());
  ASSERT_THAT(run_program({"estimate", "--source", held_out, "--init", "truth", "--landmarks",
                           path("marks.toml"), "--out", path("moved.txt"), "--records", path("moved.jsonl")}),
              Succeeded());
  ASSERT_THAT(run_program({"evaluate", "--truth", held_out, "--predictions", "m=" + path("plain.txt"),
                           "--landmarks", path("marks.toml"), "--json", path("moved_later.json")}),
              Succeeded());
  ASSERT_THAT(run_program({"evaluate", "--truth", held_out, "--predictions", "m=" + path("moved.txt"),
                           "--json", path("moved.json")}),
              Succeeded());
  ASSERT_THAT(run_program({"evaluate", "--truth", held_out, "--predictions", "m=" + path("plain.txt"),
                           "--json", path("plain.json")}),
              Succeeded());
  EXPECT_NEAR(mean_error_mm(path("moved.json")), mean_error_mm(path("moved_later.json")), 0.002);
  EXPECT_GT(std::abs(mean_error_mm(path("moved.json")) - mean_error_mm(path("plain.json"))), 0.002)
      << "moved";
}

TEST_F(VerbsTest, SyntheticFramesAreScoredInTheLandmarksOfADataSet) {
  const std::string source = "synthetic:manifests/demo.toml?count=4";
  ASSERT_THAT(run_program({"estimate", "--source", source, "--out", path("poses.txt")}), Succeeded());
  for (const auto& [file, count] : {std::pair{"landmarks/nyu14.toml", 14},
                                    {"landmarks/icvl16.toml", 16},
                                    {"mediapipe21", 21},
                                    {"icg20", 20}}) {
    ASSERT_THAT(run_program({"evaluate", "--truth", source, "--predictions", "m=" + path("poses.txt"),
                             "--landmarks", file, "--json", path("scores.json")}),
                Succeeded());
    const auto method = nlohmann::json::parse(read_text_file(path("scores.json")))["methods"][0];
    EXPECT_EQ(method["joints"].size(), count);
    for (const auto& error : method["per_joint_3d_mm"]) EXPECT_LT(error, 60.0);
  }
}

TEST_F(VerbsTest, MethodsWithADataSetsOwnLandmarksAreScoredBesideThoseThatAreMovedThere) {
  const std::string source = "synthetic:manifests/demo.toml?count=4";
  const auto estimate = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"estimate", "--source", source, "--out", path(name)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ASSERT_THAT(run_program(arguments), Succeeded());
  };
  estimate("all22.txt", {});
  estimate("own14.txt", {"--landmarks", "nyu14"});
  ASSERT_THAT(run_program({"evaluate", "--truth", source, "--predictions", "moved=" + path("all22.txt"),
                           "--predictions", "own=" + path("own14.txt"), "--landmarks", "nyu14", "--json",
                           path("scores.json")}),
              Succeeded());
  const auto methods = nlohmann::json::parse(read_text_file(path("scores.json")))["methods"];
  ASSERT_EQ(methods.size(), 2u);
  for (const auto& method : methods) EXPECT_EQ(method["joints"].size(), 14u);
  EXPECT_NEAR(methods[0]["mean_3d_mm"], methods[1]["mean_3d_mm"], 0.002);
}

TEST_F(VerbsTest, ADataSetMayHaveLandmarksOfItsOwn) {
  write_text_file(path("lab3.toml"),
                  "format = \"knuckle-landmarks\"\nversion = 1\nconvention = \"lab3\"\n"
                  "landmarks = [\"thumb_tip\", \"middle_of_index\", \"wrist\"]\n"
                  "[middle_of_index]\nbone = \"index_mcp\"\ntowards = \"index_tip\"\nshare = 0.5\n");
  ASSERT_THAT(run_program({"estimate", "--source", kDemoSource, "--landmarks", path("lab3.toml"), "--out",
                           path("lab3.txt"), "--records", path("lab3.jsonl")}),
              Succeeded());
  EXPECT_THAT(read_text_file(path("lab3.txt")), StartsWith("# convention: lab3\n"));
  EXPECT_THAT(read_text_file(path("lab3.jsonl")), HasSubstr("\"middle_of_index\":["));
  // Its own poses are its truth: the folder set says the convention by the file beside it.
  std::filesystem::create_directories(path("set") + "/depth");
  const std::string joints = read_text_file(path("lab3.txt"));
  write_text_file(path("set/joints.txt"), joints.substr(joints.find('\n') + 1));
  std::filesystem::copy(path("lab3.toml"), path("set/lab3.toml"));
  write_text_file(path("set/dataset.toml"),
                  "convention = \"lab3.toml\"\n[camera]\nwidth = 320\nheight = 240\nfx = 224.5\nfy = 230.5\n"
                  "cx = 160.0\ncy = 120.0\n");
  for (int i = 0; i < 6; ++i)
    write_png(path("set/depth/" + std::to_string(i) + ".png"), Image<std::uint16_t>(320, 240, 900));
  ASSERT_THAT(run_program({"evaluate", "--truth", "folder:" + path("set"), "--predictions",
                           "own=" + path("lab3.txt"), "--json", path("own.json")}),
              Succeeded());
  EXPECT_LT(mean_error_mm(path("own.json")), 0.01);
  write_text_file(path("set/dataset.toml"),
                  "convention = \"../lab3.toml\"\n[camera]\nwidth = 320\nheight = 240\n"
                  "fx = 224.5\nfy = 230.5\ncx = 160.0\ncy = 120.0\n");
  EXPECT_THAT(run_program({"inspect", "--source", "folder:" + path("set")}),
              FailedWith("expected the name of a file in the same folder"));
}

TEST_F(VerbsTest, PosesInSpaceAreScoredAndMixedUpOnesAreNoticed) {
  const std::string source = "synthetic:manifests/demo.toml?count=3";
  ASSERT_THAT(run_program({"estimate", "--source", source, "--out", path("poses.txt"), "--records",
                           path("poses.jsonl")}),
              Succeeded());
  std::string in_metres;  // as a program with OpenGL's axes writes them
  std::istringstream records(read_text_file(path("poses.jsonl")));
  for (std::string line; std::getline(records, line);) {
    const auto hands = nlohmann::ordered_json::parse(line)["hands"];
    ASSERT_FALSE(hands.empty());
    for (const auto& point : hands[0]["landmarks_mm"]) {
      in_metres += fmt::format("{} {} {} ", point[0].get<double>() / 1000, -point[1].get<double>() / 1000,
                               -point[2].get<double>() / 1000);
    }
    in_metres += "\n";
  }
  write_text_file(path("space.txt"), in_metres);
  std::vector<std::string> arguments = {"evaluate",
                                        "--truth",
                                        source,
                                        "--predictions",
                                        "space=" + path("space.txt"),
                                        "pixels=" + path("poses.txt"),
                                        "--convention",
                                        "knuckle22",
                                        "--json",
                                        path("scores.json")};
  const ProgramRun mixed_up = run_program(arguments);
  EXPECT_THAT(mixed_up, Succeeded());
  EXPECT_THAT(mixed_up.error, HasSubstr("space.txt: read so, half of its joints are more than"));
  EXPECT_THAT(mixed_up.error, HasSubstr("with --format xyz --axes x,-y,-z --unit m more than"));
  EXPECT_THAT(mixed_up.error, Not(HasSubstr("poses.txt")));
  const ProgramRun behind =
      run_program({"evaluate", "--truth", source, "--predictions", "space=" + path("space.txt"),
                   "--convention", "knuckle22", "--format", "xyz"});
  EXPECT_THAT(behind, Succeeded());
  EXPECT_THAT(behind.error, HasSubstr("half of its joints are behind the camera; with --format xyz --axes"));
  write_text_file(path("space.txt"), "# format: xyz\n# axes: x,-y,-z\n# unit: m\n" + in_metres);
  const ProgramRun right = run_program(arguments);
  EXPECT_THAT(right, Succeeded());
  EXPECT_EQ(right.error, "");
  const auto scores = nlohmann::json::parse(read_text_file(path("scores.json")));
  EXPECT_NEAR(scores["methods"][0]["mean_3d_mm"], scores["methods"][1]["mean_3d_mm"], 0.01);
  EXPECT_NEAR(scores["differences"][0]["mean_mm"], 0.0, 0.01);
  arguments.insert(arguments.end(), {"--axes", "x,-y,-z"});
  EXPECT_THAT(run_program(arguments), FailedWith("--axes: tells of x y z"));
}

TEST_F(VerbsTest, AMethodThatFoundNothingHasAReport) {
  std::string nothing = "# convention: hands21\n";
  for (int i = 0; i < 3; ++i) {
    for (int number = 0; number < 63; ++number) nothing += "nan ";
    nothing += "\n";
  }
  write_text_file(path("nothing.txt"), nothing);
  const ProgramRun run =
      run_program({"evaluate", "--truth", "synthetic:manifests/demo.toml?count=3", "--predictions",
                   "nothing=" + path("nothing.txt"), "--out", path("report")});
  EXPECT_THAT(run, Succeeded());
  EXPECT_EQ(run.error, "");
  EXPECT_THAT(read_text_file(path("report/report.html")), HasSubstr("nothing"));
}

TEST_F(VerbsTest, AHandThatIsFollowedKeepsItsIdAndTremblesLess) {
  const std::string source = "synthetic:manifests/test_creative.toml?count=40";
  ASSERT_THAT(run_program({"estimate", "--source", source, "--out", path("single.txt")}), Succeeded());
  ASSERT_THAT(run_program({"estimate", "--source", source, "--pipeline", "pipelines/track.toml", "--out",
                           path("followed.txt"), "--records", path("followed.jsonl")}),
              Succeeded());
  ASSERT_THAT(run_program({"evaluate", "--truth", source, "--predictions", "single=" + path("single.txt"),
                           "followed=" + path("followed.txt"), "--json", path("both.json")}),
              Succeeded());
  const auto methods = nlohmann::json::parse(read_text_file(path("both.json")))["methods"];
  EXPECT_LT(methods[1]["motion"]["acceleration_mm"],
            0.8 * methods[0]["motion"]["acceleration_mm"].get<double>());
  EXPECT_LT(methods[1]["motion"]["bone_deviation"], 0.02);
  EXPECT_LT(methods[1]["mean_3d_mm"], 1.3 * methods[0]["mean_3d_mm"].get<double>());
  std::istringstream lines(read_text_file(path("followed.jsonl")));
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const auto hand = nlohmann::json::parse(line)["hands"].at(0);
    EXPECT_EQ(hand["id"], 1);
    EXPECT_EQ(hand["skeleton"], "adult");
    EXPECT_EQ(hand["angles_rad"].size(), 22u);
  }
  EXPECT_EQ(count, 40);
  EXPECT_THAT(run_program({"estimate", "--source", source, "--pipeline", "pipelines/track.toml", "--init",
                           "truth", "--out", path("p.txt")}),
              FailedWith("--init truth"));
}

TEST_F(VerbsTest, FittedSurfacesAreShownWithAndWithoutTruth) {
  const std::string labelled = "synthetic:manifests/test_creative.toml?count=3";
  ASSERT_THAT(run_program({"estimate", "--source", labelled, "--pipeline", "pipelines/track.toml", "--out",
                           path("p.txt"), "--records", path("p.jsonl")}),
              Succeeded());
  ASSERT_THAT(run_program({"render", "--manifest", "manifests/test_creative.toml", "--format", "folder",
                           "--out", path("set"), "--count", "3"}),
              Succeeded());
  std::filesystem::remove(path("set/joints.txt"));
  for (const std::string& source : {labelled, "folder:" + path("set")}) {
    ASSERT_THAT(run_program({"evaluate", "--truth", source, "--records", "m=" + path("p.jsonl"), "--out",
                             path("report"), "--strip", path("strip.png")}),
                Succeeded());
    const std::string page = read_text_file(path("report/report.html"));
    EXPECT_THAT(page, HasSubstr("<img alt=\"m: surface\""));
    EXPECT_THAT(page, HasSubstr("<img alt=\"m: difference\""));
    EXPECT_THAT(page, HasSubstr("aria-label=\"index_pip\""));
    EXPECT_TRUE(std::filesystem::exists(path("report/figures/angle_index_pip.svg")));
    EXPECT_TRUE(std::filesystem::exists(path("strip.png")));
    std::filesystem::remove_all(path("report"));
    std::filesystem::remove(path("strip.png"));
  }
}

TEST_F(VerbsTest, LandmarksSayWhatIsWrong) {
  EXPECT_THAT(run_program({"landmarks", "--source", kDemoSource, "--out", path("marks.toml")}),
              FailedWith("too few to fit"));
  EXPECT_FALSE(std::filesystem::exists(path("marks.toml")));
  EXPECT_THAT(run_program({"landmarks", "--source", kDemoSource, "--out", path("none/marks.toml")}),
              FailedWith("none/marks.toml"));
  EXPECT_THAT(run_program({"estimate", "--source", kDemoSource, "--landmarks", path("no.toml"), "--out",
                           path("p.txt")}),
              FailedWith("no.toml"));
  write_text_file(path("marks.toml"),
                  "format = \"knuckle-landmarks\"\nversion = 1\nconvention = \"icg20\"\n");
  EXPECT_THAT(run_program({"estimate", "--source", kDemoSource, "--landmarks", path("marks.toml"), "--out",
                           path("p.txt")}),
              FailedWith("lacks the table [palm]"));
  EXPECT_FALSE(std::filesystem::exists(path("p.txt")));
}

TEST_F(VerbsTest, ALeftHandIsEstimatedAsItsMirrorImage) {
  // A frame and its mirror image, the one with side = right, the other with side = left.
  const std::string pipeline = read_text_file("pipelines/pose_forest.toml");
  const std::string model = std::filesystem::absolute("models/pose_forest.model");
  const auto with = [&](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string right = with(pipeline, "../models/pose_forest.model", model);
  write_text_file(path("right.toml"), right);
  write_text_file(path("left.toml"), with(right, "side = \"right\"", "side = \"left\""));
  make_folder(path("a/depth"));
  make_folder(path("b/depth"));
  ASSERT_THAT(run_program({"render", "--manifest", "manifests/demo.toml", "--format", "folder", "--out",
                           path("frames"), "--count", "1"}),
              Succeeded());
  const auto depth_file = entries_of(path("frames/depth")).front();
  const auto depth = read_png16(path("frames/depth/" + depth_file));
  const std::string toml =
      "depth_unit_mm = 0.1\n[camera]\nmodel = 'projective'\nwidth = {}\nheight = {}\nfx = 224\nfy = 224\ncx "
      "= {}\ncy = 120\n";
  const double centre = (depth.width() - 1) / 2.0;
  for (const std::string set : {"a", "b"}) {
    write_text_file(path(set + "/dataset.toml"),
                    fmt::format(fmt::runtime(toml), depth.width(), depth.height(), centre));
    write_png(path(set + "/depth/0.png"), set == "a" ? depth : mirrored(depth));
  }
  ASSERT_THAT(run_program({"estimate", "--source", "folder:" + path("a"), "--pipeline", path("right.toml"),
                           "--out", path("right.txt")}),
              Succeeded());
  ASSERT_THAT(run_program({"estimate", "--source", "folder:" + path("b"), "--pipeline", path("left.toml"),
                           "--out", path("left.txt")}),
              Succeeded());
  std::istringstream right_line(read_lines(path("right.txt"))[1]);
  std::istringstream left_line(read_lines(path("left.txt"))[1]);
  double right_value = 0.0;
  double left_value = 0.0;
  for (int i = 0; right_line >> right_value && left_line >> left_value; ++i) {
    EXPECT_NEAR(left_value, i % 3 == 0 ? depth.width() - 1 - right_value : right_value, 2e-3)
        << "value " << i;
  }
}

TEST_F(VerbsTest, TrainingMakesAModelThatEstimates) {
  write_text_file(path("train.toml"),
                  "source = 'synthetic:" + std::filesystem::absolute("manifests/demo.toml").string() +
                      "?count=30'\nconvention = 'icg20'\n[forest]\ntrees = 2\nsplits_per_node = 50\n");
  ASSERT_THAT(
      run_program({"train", "pose-forest", "--config", path("train.toml"), "--out", path("forest.model")}),
      Succeeded());
  write_text_file(path("pipeline.toml"), "[estimator]\nmethod = 'forest'\nmodel = 'forest.model'\n");
  ASSERT_THAT(run_program({"estimate", "--source", kDemoSource, "--pipeline", path("pipeline.toml"), "--out",
                           path("poses.txt")}),
              Succeeded());
  EXPECT_THAT(entries_of(folder_.path()), Not(Contains(HasSubstr("checkpoint"))));
}

TEST_F(VerbsTest, TheSameTrainingOnOneAndTwoThreadsMakesTheSameFile) {
  write_text_file(path("train.toml"),
                  "source = 'synthetic:" + std::filesystem::absolute("manifests/demo.toml").string() +
                      "?count=20'\n[forest]\ntrees = 2\nsplits_per_node = 50\n");
  for (const std::string threads : {"1", "2"}) {
    ASSERT_THAT(run_program({"train", "pose-forest", "--config", path("train.toml"), "--out",
                             path("forest" + threads + ".model"), "--threads", threads}),
                Succeeded());
  }
  EXPECT_TRUE(read_text_file(path("forest1.model")) == read_text_file(path("forest2.model")));
}

TEST_F(VerbsTest, DemoMakesAReport) {
  const ProgramRun run = run_program({"demo", "--out", path("demo")});
  ASSERT_THAT(run, Succeeded());
  EXPECT_THAT(run.out, HasSubstr(path("demo/report.html")));
  EXPECT_THAT(read_text_file(path("demo/report.html")), HasSubstr("data:image/png;base64,"));
}

}  // namespace
}  // namespace knuckle::testing
