// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/forest_segmenter.h"

#include <fstream>
#include <limits>

#include "knuckle/core/testing.h"
#include "knuckle/forest/pixel_forest_trainer.h"
#include "knuckle/segment/hand_region.h"
#include "knuckle/segment/segmentation_forest.h"
#include "knuckle/segment/segmenter_factory.h"
#include "knuckle/segment/testing.h"
#include "knuckle/storage/model_testing.h"

namespace knuckle {
namespace {

using ::knuckle::testing::blank_frame;
using ::knuckle::testing::change_model;
using ::knuckle::testing::draw_ball;
using ::knuckle::testing::draw_rod;
using ::knuckle::testing::error_of;
using ::knuckle::testing::quarter_vga_camera;
using ::knuckle::testing::TemporaryFolder;
using ::knuckle::testing::trusting_forest;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// A ball of a hand's size before a wide trunk; mask: the ball.
Frame ball_before_trunk(std::uint64_t seed) {
  Random random(seed);
  Frame frame = blank_frame(quarter_vga_camera());
  const RayTable rays(frame.camera);
  const Point3 centre(random.uniform(-150, 150), random.uniform(-100, 100), random.uniform(450, 700));
  draw_ball(frame, rays, centre, 60);
  frame.mask = Image<std::uint8_t>(frame.camera.width, frame.camera.height);
  for (std::size_t i = 0; i < frame.mask.size(); ++i)
    frame.mask.data()[i] = is_measured(frame.depth_mm.data()[i]);
  draw_rod(frame, rays, Point3(0, -150, 1000), Point3(0, 400, 1000), 180);
  for (float& depth : frame.depth_mm.pixels()) {
    if (is_measured(depth)) depth += static_cast<float>(2.0 * random.normal());
  }
  return frame;
}

PixelForest ball_forest() {
  constexpr int kFrames = 40;
  PixelSamples samples(kFrames);
  for (int i = 0; i < kFrames; ++i) {
    const Frame frame = ball_before_trunk(static_cast<std::uint64_t>(i));
    std::vector<LabelledPixel> pixels;
    for (int row = 0; row < 240; row += 5) {
      for (int column = 0; column < 320; column += 5) {
        if (!is_measured(frame.depth_mm(column, row))) continue;
        pixels.push_back(
            {static_cast<std::int16_t>(column), static_cast<std::int16_t>(row), frame.mask(column, row)});
      }
    }
    samples.set(i, frame.depth_mm, frame.camera, pixels);
  }
  PixelForestOptions options;
  options.trees = 3;
  options.tree.splits_per_node = 200;
  options.offsets.offsets_per_node = 64;
  return train_pixel_forest(samples, options);
}

TEST(ForestSegmenter, FindsWhatItWasTrainedOn) {
  const ForestSegmenter segmenter(ball_forest(), {});
  for (std::uint64_t seed = 100; seed < 105; ++seed) {
    const Frame frame = ball_before_trunk(seed);
    const Segmentation found = segmenter.segment(frame, std::nullopt, 1);
    ASSERT_EQ(found.hands.size(), 1U) << found.reason;
    const HandRegion& hand = found.hands[0];
    int in_both = 0;
    int in_either = 0;
    for (int row = 0; row < 240; ++row) {
      for (int column = 0; column < 320; ++column) {
        const bool is_found =
            hand.box.contains(column, row) && hand.mask(column - hand.box.x, row - hand.box.y) == 1;
        in_both += is_found && frame.mask(column, row) == 1 ? 1 : 0;
        in_either += is_found || frame.mask(column, row) == 1 ? 1 : 0;
      }
    }
    EXPECT_GT(in_both, 0.9 * in_either);
  }
}

TEST(ForestSegmenter, SaysWhyThereIsNoHand) {
  const ForestSegmenter segmenter(ball_forest(), {});
  Frame frame = blank_frame(quarter_vga_camera());
  draw_rod(frame, RayTable(frame.camera), Point3(0, -150, 1000), Point3(0, 400, 1000), 180);
  const Segmentation found = segmenter.segment(frame, std::nullopt, 1);
  EXPECT_TRUE(found.hands.empty());
  EXPECT_THAT(found.reason, HasSubstr("takes for a hand"));
}

TEST(ForestSegmenter, TakesTheHandAtTheStart) {
  Frame frame = blank_frame(quarter_vga_camera());
  draw_ball(frame, Point3(-200, 0, 500), 60);
  draw_ball(frame, Point3(220, 0, 500), 50);
  const ForestSegmenter segmenter(trusting_forest(), {});
  EXPECT_LT(segmenter.segment(frame, std::nullopt, 1).hands.at(0).centre.x(), -100);
  EXPECT_GT(segmenter.segment(frame, Point3(180, 0, 480), 1).hands.at(0).centre.x(), 100);
}

TEST(ForestSegmenter, FiltersDoWhatTheirNamesSay) {
  Frame frame = blank_frame(quarter_vga_camera());
  for (int row = 50; row < 150; ++row) {
    for (int column = 50; column < 150; ++column) frame.depth_mm(column, row) = 500.0F;
  }
  for (int column = 150; column < 200; ++column) frame.depth_mm(column, 100) = 500.0F;  // a thread
  const auto box_with = [&](int median, int closing, int opening) {
    const ForestSegmenterOptions options{.median_px = median, .closing_px = closing, .opening_px = opening};
    return ForestSegmenter(trusting_forest(), options).segment(frame, std::nullopt, 1).hands.at(0).box;
  };
  EXPECT_EQ(box_with(1, 1, 1), (Box{50, 50, 150, 100}));
  EXPECT_EQ(box_with(3, 1, 1), (Box{50, 50, 101, 100}));  // the thread's root has a majority
  EXPECT_EQ(box_with(1, 1, 3), (Box{50, 50, 100, 100}));
  for (int row = 50; row < 150; ++row) frame.depth_mm(100, row) = 0.0F;  // a gap parts the square
  EXPECT_LT(box_with(1, 1, 1).width, 110);
  EXPECT_EQ(box_with(1, 3, 1).width, 50);  // a gap that was not measured stays one
}

TEST(ForestSegmenter, TrimsTheEdgeWhereAsked) {
  Frame frame = blank_frame(quarter_vga_camera());
  for (int row = 40; row < 200; ++row) {
    for (int column = 40; column < 200; ++column) {
      const bool is_near = column >= 60 && column < 140 && row >= 60 && row < 140;
      frame.depth_mm(column, row) = is_near ? 500.0F : 530.0F;
    }
  }
  const auto hand_with = [&](double step) {
    return ForestSegmenter(trusting_forest(), {.edge_step_mm = step})
        .segment(frame, std::nullopt, 1)
        .hands.at(0);
  };
  EXPECT_EQ(hand_with(0.0).box, (Box{40, 40, 160, 160}));
  EXPECT_EQ(hand_with(40.0).box, (Box{41, 41, 158, 158}));  // only where nothing lies beside it
  const HandRegion parted = hand_with(20.0);  // also the near square's, so the frame is one part
  EXPECT_EQ(parted.mask(60 - parted.box.x, 100 - parted.box.y), 0);
  EXPECT_EQ(parted.mask(59 - parted.box.x, 100 - parted.box.y), 1);
}

TEST(ForestSegmenter, RefusesEvenSizes) {
  EXPECT_THAT(error_of([] { ForestSegmenter(trusting_forest(), {.median_px = 4}); }),
              AllOf(HasSubstr("median_px is 4"), HasSubstr("odd")));
  EXPECT_THAT(error_of([] { ForestSegmenter(trusting_forest(), {.probability = 1.0}); }),
              HasSubstr("probability"));
}

TEST(SegmentationForestFile, SavedAndLoadedAnswersTheSame) {
  const TemporaryFolder folder;
  const PixelForest forest = ball_forest();
  save_segmentation_forest(folder / "forest.model", forest);
  const PixelForest loaded = load_segmentation_forest(folder / "forest.model");
  const Frame frame = ball_before_trunk(7);
  EXPECT_EQ(loaded.probability(frame.depth_mm, frame.camera),
            forest.probability(frame.depth_mm, frame.camera));
}

TEST(SegmentationForestFile, RefusesWhatIsNone) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "forest.model";
  const auto fault = [&] { return error_of([&] { (void)load_segmentation_forest(path); }); };
  EXPECT_THAT(fault(), HasSubstr("forest.model"));  // missing
  std::ofstream(path) << "no forest";
  EXPECT_THAT(fault(), HasSubstr("forest.model"));

  save_segmentation_forest(path, ball_forest());
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_THAT(fault(), HasSubstr("forest.model"));

  save_segmentation_forest(path, ball_forest());
  change_model(path, [](ModelWriter& model) { model.set_format("knuckle-forest", 99); });
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("version")));

  save_segmentation_forest(path, ball_forest());
  change_model(path, [](ModelWriter& model) { model.set("kind", "pose"); });
  EXPECT_THAT(fault(), HasSubstr("a forest of kind \"pose\", expected \"segmentation\""));
}

TEST(SegmenterFactory, FindsTheForestBesideTheFile) {
  const TemporaryFolder folder;
  save_segmentation_forest(folder / "forest.model", trusting_forest());
  std::ofstream(folder / "pipeline.toml")
      << "method = \"forest\"\nmodel = \"forest.model\"\nprobability = 0.5\n";
  EXPECT_NE(create_segmenter(OptionTable::load(folder / "pipeline.toml")), nullptr);
  EXPECT_THAT(error_of([] { (void)create_segmenter(OptionTable::parse("method = \"forest\"", "a.toml")); }),
              AllOf(HasSubstr("a.toml"), HasSubstr("model")));
  EXPECT_THAT(error_of([&] {
                std::ofstream(folder / "other.toml") << "method = \"forest\"\nmodel = \"none.model\"\n";
                (void)create_segmenter(OptionTable::load(folder / "other.toml"));
              }),
              HasSubstr("none.model"));
}

}  // namespace
}  // namespace knuckle
