// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/segmentation_forest_training.h"

#include <fstream>

#include "knuckle/core/testing.h"
#include "knuckle/data/writers/folder_writer.h"
#include "knuckle/pipeline/segment_all.h"
#include "knuckle/segment/segmentation_forest.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

/// A ball of a hand's size before a trunk, right of it in the image; mask: the ball.
Frame ball_frame(std::uint64_t seed) {
  Random random(seed);
  Frame frame = testing::blank_frame(testing::quarter_vga_camera());
  const RayTable rays(frame.camera);
  testing::draw_ball(frame, rays, Point3(random.uniform(60, 160), random.uniform(-80, 80), 600), 60);
  frame.mask = Image<std::uint8_t>(320, 240);
  for (std::size_t i = 0; i < frame.mask.size(); ++i) {
    frame.mask.data()[i] = is_measured(frame.depth_mm.data()[i]) ? 1 : 0;
  }
  testing::draw_rod(frame, rays, Point3(0, -150, 1000), Point3(0, 400, 1000), 180);
  return frame;
}

class SegmentationForestTrainingTest : public ::testing::Test {
 protected:
  void write_source(const std::string& name, const std::function<void(Frame&)>& change = {}) const {
    FrameWriterOptions options;
    options.count = 12;
    FolderWriter writer(folder_ / name, options);
    for (int i = 0; i < 12; ++i) {
      Frame frame = ball_frame(static_cast<std::uint64_t>(i));
      if (change) change(frame);
      writer.write(i, frame);
    }
    writer.finish();
  }

  SegmentationForestTrainingConfig config(const std::string& text) const {
    std::ofstream(folder_ / "c.toml") << text;
    return SegmentationForestTrainingConfig::load(folder_ / "c.toml");
  }

  TemporaryFolder folder_;
};

constexpr const char* kForest = "[forest]\ntrees = 2\nsplits_per_node = 60\noffsets_per_node = 40\n";

TEST_F(SegmentationForestTrainingTest, TheForestFindsTheHandOfItsSource) {
  write_source("set");
  const auto trained = run_training(config(std::string("source = \"folder:set\"\n") + kForest), {});
  EXPECT_EQ(trained.frames, 12);
  EXPECT_EQ(trained.samples, 12 * (120 + 60));
  save_segmentation_forest(folder_ / "f.h5", trained.forest);
  std::ofstream(folder_ / "p.toml") << "[segmentation]\nmethod = \"forest\"\nmodel = \"f.h5\"\n";
  const HandFinder finder = HandFinder::load(folder_ / "p.toml");
  for (std::uint64_t seed = 20; seed < 23; ++seed) {
    const Frame frame = ball_frame(seed);
    const Segmentation found = finder.find(frame, std::nullopt);
    ASSERT_EQ(found.hands.size(), 1U) << found.reason;
    EXPECT_GT(found.hands[0].centre.x(), 40.0);
  }
}

TEST_F(SegmentationForestTrainingTest, ALeftHandsForestIsThatOfTheMirroredFrames) {
  write_source("set");
  write_source("mirror", [](Frame& frame) { frame = mirrored(frame); });
  const std::string options =
      std::string("[pixels]\nhand_pixels = 100000\nbackground_pixels = 100000\n") + kForest;
  const auto right = run_training(config("source = \"folder:set\"\n" + options), {});
  const auto left =
      run_training(config("source = \"folder:mirror\"\n[hand]\nside = \"left\"\n" + options), {});
  const Frame frame = ball_frame(30);
  EXPECT_EQ(right.forest.probability(frame.depth_mm, frame.camera),
            left.forest.probability(frame.depth_mm, frame.camera));
}

TEST(AsRightHand, TheSourceKnowsBetterThanTheOptions) {
  Frame frame;
  frame.depth_mm = Image<float>(2, 1);
  frame.depth_mm(0, 0) = 500.0f;
  frame.camera = {.width = 2, .height = 1, .fx = 1, .fy = 1, .cx = 0.5, .cy = 0};
  const auto is_mirrored = [&](std::optional<HandSide> side, const std::string& option) {
    frame.side = side;
    return as_right_hand(frame, {.side = option, .max_hands = 1}).depth_mm(1, 0) == 500.0f;
  };
  EXPECT_FALSE(is_mirrored(std::nullopt, "right"));
  EXPECT_TRUE(is_mirrored(std::nullopt, "left"));
  EXPECT_FALSE(is_mirrored(HandSide::right, "left"));
  EXPECT_TRUE(is_mirrored(HandSide::left, "right"));
}

TEST_F(SegmentationForestTrainingTest, TakesAShareOfTheFrames) {
  write_source("set");
  const auto trained =
      run_training(config(std::string("source = \"folder:set\"\n[pixels]\nshare = 0.25\n") + kForest), {});
  EXPECT_EQ(trained.frames, 3);
}

TEST_F(SegmentationForestTrainingTest, CountsTheWristAsHandWhereAsked) {
  const Convention convention = convention_from_name("mediapipe21");
  const auto put_wrist = [&](Frame& frame) {
    std::ranges::fill(frame.mask.pixels(), std::uint8_t{0});
    frame.truth = HandPose::missing(convention);
    // On the trunk: nothing of it is hand but what the wrist says.
    frame.truth->joints[0] = {160.0, 120.0, frame.depth_mm(160, 120)};
  };
  write_source("wrist", put_wrist);
  const std::string source = "source = \"folder:wrist\"\n[pixels]\n";
  EXPECT_THAT(error_of([&] { (void)run_training(config(source + kForest), {}); }),
              HasSubstr("expected both"));
  const std::string everything = "hand_pixels = 100000\nbackground_pixels = 100000\n";
  const auto trained =
      run_training(config(source + everything + "wrist_mm = 30\n[forest]\nmax_depth = 0\ntrees = 1\n"), {});
  // A disc of 30 mm at 820 mm: pi * (30 * 241.42 / 820)^2 = 245 pixels of each frame.
  const double hand = trained.samples * trained.forest.parts().leaf_codes[0] / 255.0 / 12.0;
  EXPECT_NEAR(hand, 245.0, 0.5 * trained.samples / 255.0 / 12.0 + 15.0);
  EXPECT_THAT(error_of([&] {
                write_source("set");
                (void)run_training(config("source = \"folder:set\"\n[pixels]\nwrist_mm = 30\n"), {});
              }),
              HasSubstr("no true wrist"));
}

TEST_F(SegmentationForestTrainingTest, NamesTheFault) {
  write_source("plain", [](Frame& frame) { frame.mask = {}; });
  write_source("empty", [](Frame& frame) { std::ranges::fill(frame.mask.pixels(), std::uint8_t{0}); });
  write_source("set");
  const auto fault_of = [&](const std::string& text) {
    return error_of([&] { (void)run_training(config(text), {}); });
  };
  EXPECT_THAT(fault_of("source = \"folder:plain\"\n"), AllOf(HasSubstr("plain"), HasSubstr("no mask")));
  EXPECT_THAT(fault_of("source = \"folder:empty\"\n"), AllOf(HasSubstr("empty"), HasSubstr("expected both")));
  EXPECT_THAT(fault_of("source = \"folder:set\"\n[forest]\nmemory_gb = 1e-3\n"),
              AllOf(HasSubstr("memory_gb is 0.001"), HasSubstr("would fit")));
  EXPECT_THAT(fault_of("source = \"folder:set\"\n[pixels]\nhand_pixel = 3\n"),
              AllOf(HasSubstr("c.toml"), HasSubstr("hand_pixel")));
  EXPECT_THAT(fault_of("source = \"folder:set\"\n[pixels]\nshare = 0.0\n"), HasSubstr("share"));
  EXPECT_THAT(fault_of("[pixels]\n"), AllOf(HasSubstr("c.toml"), HasSubstr("source")));
}

TEST(SegmentationSummary, MasksAreComparedPixelByPixel) {
  FrameSegmentation found;
  found.found = true;
  found.mask = FrameSegmentation::MaskOverlap{3, 4};
  FrameSegmentation lost;
  lost.mask = FrameSegmentation::MaskOverlap{0, 6};
  EXPECT_DOUBLE_EQ(found.mask->iou(), 0.75);
  const std::string json = summary_json(std::vector{found, lost}, "folder:x");
  EXPECT_THAT(json, AllOf(HasSubstr("\"found\": 1"), HasSubstr("\"mean_iou\": 0.375"),
                          HasSubstr("\"pixel_iou\": 0.3")));
}

}  // namespace
}  // namespace knuckle
