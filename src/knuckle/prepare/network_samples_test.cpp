// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/network_samples.h"

#include "knuckle/core/own_convention.h"
#include "knuckle/core/testing.h"
#include "knuckle/data/writers/folder_writer.h"
#include "knuckle/segment/hand_region.h"

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Answers with the start that it is given; without one with a place 200 mm to the right of the hand.
class TrustingSegmenter final : public Segmenter {
 public:
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start,
                       int /*max_hands*/) const override {
    HandRegion region = region_of_pixels({30 * frame.depth_mm.width() + 20}, frame.depth_mm.width());
    region.centre = start.value_or(Point3(200.0, 0.0, frame.depth_mm(20, 30)));
    return {{region}, ""};
  }
};

/// Frame i is a plate of a hand's size 500 + 10 i mm away; 1 mm is 0.2 px at 500 mm.
Frame plate_frame(int i) {
  Frame frame;
  frame.camera = {.width = 80, .height = 60, .fx = 100.0, .fy = 100.0, .cx = 39.5, .cy = 29.5};
  frame.depth_mm = Image<float>(80, 60);
  const float depth_mm = 500.0f + 10.0f * static_cast<float>(i);
  for (int row = 20; row < 40; ++row) {
    for (int column = 10; column < 30; ++column) frame.depth_mm(column, row) = depth_mm;
  }
  frame.truth = HandPose::missing(superset_convention());
  const auto put = [&](Landmark landmark, double u, double v, double d) {
    frame.truth->joints[static_cast<std::size_t>(landmark)] = {u, v, depth_mm + d};
  };
  put(Landmark::palm, 19.5, 29.5, 0.0);
  put(Landmark::index_tip, 27.5, 23.5, 20.0);
  put(Landmark::wrist, 11.5, 37.5, -20.0);
  return frame;
}

class NetworkSamplesTest : public ::testing::Test {
 protected:
  NetworkSamplesTest() {
    options_.patch = {32, 200.0};
    options_.crop_px = 48;
    options_.start = Start::truth;
  }

  NetworkSamples samples(int count, const std::function<void(int, Frame&)>& change = {},
                         const HandOptions& hand = {}) {
    FrameWriterOptions writer_options;
    writer_options.count = count;
    FolderWriter writer(folder_ / "set", writer_options);
    for (int i = 0; i < count; ++i) {
      Frame frame = plate_frame(i);
      if (change) change(i, frame);
      writer.write(i, frame);
    }
    writer.finish();
    const HandFinder finder(std::make_unique<TrustingSegmenter>(), hand);
    return network_samples("folder:" + (folder_ / "set").string(), finder, options_);
  }

  static std::vector<double> depths_of(const NetworkSamples& made) {
    std::vector<double> depths;
    for (std::int64_t i = 0; i < made.samples.size(); ++i)
      depths.push_back(made.samples.sample(i).centre_mm.z());
    return depths;
  }

  testing::TemporaryFolder folder_;
  SampleOptions options_;
};

TEST_F(NetworkSamplesTest, JointsLieInTheCropAsInTheImage) {
  const NetworkSamples made = samples(2);
  ASSERT_EQ(made.samples.size(), 2);
  const CubeSample sample = made.samples.sample(0);
  EXPECT_NEAR(sample.centre_mm.x(), -100.0, 0.1);
  EXPECT_NEAR(sample.centre_mm.y(), 0.0, 0.1);
  EXPECT_NEAR(sample.centre_mm.z(), 500.0, 0.1);
  const auto joint = [&](Landmark landmark, int k) {
    return sample.joints[3 * static_cast<std::size_t>(landmark) + static_cast<std::size_t>(k)];
  };
  // The crop's cube has 300 mm: 60 px of the image at 500 mm are its 48 px; d counts 150 mm.
  EXPECT_NEAR(joint(Landmark::palm, 0), 0.0, 1e-3);
  EXPECT_NEAR(joint(Landmark::index_tip, 0), 8.0 * 48.0 / 60.0, 1e-3);
  EXPECT_NEAR(joint(Landmark::index_tip, 1), -6.0 * 48.0 / 60.0, 1e-3);
  EXPECT_NEAR(joint(Landmark::index_tip, 2), 20.0 / 150.0, 1e-3);
  EXPECT_NEAR(joint(Landmark::wrist, 1), 8.0 * 48.0 / 60.0, 1e-3);
  EXPECT_TRUE(std::isnan(joint(Landmark::thumb_tip, 0)));
}

TEST_F(NetworkSamplesTest, TheMostThatAreTakenAreEvenlySpread) {
  options_.most = 3;
  const NetworkSamples made = samples(7);
  EXPECT_EQ(made.frames.total, 3);
  EXPECT_THAT(depths_of(made), ElementsAre(500.0, 520.0, 540.0));
}

TEST_F(NetworkSamplesTest, HandsThatSegmentationMissesAreSoughtAtTheTruth) {
  options_.start = Start::nearest;
  const NetworkSamples made = samples(2);
  EXPECT_EQ(made.frames.used(), 2);
  EXPECT_NEAR(made.samples.sample(0).centre_mm.x(), -100.0, 0.1);
}

TEST_F(NetworkSamplesTest, AroundTheJointsSegmentationIsNotAsked) {
  options_.around_joints = true;
  const NetworkSamples made = samples(2, [](int i, Frame& frame) {
    if (i == 0) return;
    // 84 mm from the palm, where segmentation would be: no frame is left out.
    frame.truth->joints[static_cast<std::size_t>(Landmark::index_tip)].depth_mm += 3.0 * 84.0;
  });
  EXPECT_EQ(made.frames.used(), 2);
  for (const std::int64_t i : {0, 1}) {
    std::array<double, 3> sums{};
    const CubeSample sample = made.samples.sample(i);
    for (std::size_t k = 0; k < sample.joints.size(); ++k)
      sums[k % 3] += std::isnan(sample.joints[k]) ? 0.0 : sample.joints[k];
    EXPECT_NEAR(sums[2], 0.0, 1e-3) << "the mean of the joints is the centre";
  }
}

TEST_F(NetworkSamplesTest, FramesWhoseJointsAreFarFromTheCentreOrUnknownAreLeftOut) {
  const NetworkSamples made = samples(4, [](int i, Frame& frame) {
    std::vector<ImagePoint>& joints = frame.truth->joints;
    const auto move_tips = [&](double mm) {  // the mean of the three joints, 3 mm for each of theirs
      joints[static_cast<std::size_t>(Landmark::index_tip)].depth_mm += 3.0 * mm;
    };
    if (i == 0) move_tips(78.0);
    if (i == 1) move_tips(84.0);
    if (i == 2) frame.truth = HandPose::missing(superset_convention());
  });
  EXPECT_EQ(made.frames.total, 4);
  EXPECT_EQ(made.frames.off_centre, 1);
  EXPECT_EQ(made.frames.without_hand, 1);
  EXPECT_THAT(depths_of(made), ElementsAre(500.0, 530.0));
}

TEST_F(NetworkSamplesTest, LeftHandsAreTakenInTheMirror) {
  const NetworkSamples made = samples(1, {}, {.side = "left"});
  const CubeSample sample = made.samples.sample(0);
  EXPECT_NEAR(sample.centre_mm.x(), 100.0, 0.1);
  EXPECT_NEAR(sample.joints[3 * static_cast<std::size_t>(Landmark::index_tip)], -8.0 * 48.0 / 60.0, 1e-3);
}

TEST_F(NetworkSamplesTest, ASetMayShowOtherHandsThanTheOthers) {
  options_.side = HandSide::left;
  EXPECT_NEAR(samples(1).samples.sample(0).centre_mm.x(), 100.0, 0.1);
  std::filesystem::remove_all(folder_ / "set");
  const auto is_right = [](int, Frame& frame) { frame.side = HandSide::right; };
  EXPECT_NEAR(samples(1, is_right).samples.sample(0).centre_mm.x(), -100.0, 0.1) << "the frames know it";
}

TEST_F(NetworkSamplesTest, OfAPartOfASetTheMostAreSpreadOverThatPart) {
  const auto sequences = [](int i, Frame& frame) { frame.sequence = i / 2; };
  options_.holdout = {0.5, Holdout::Part::validation};
  const std::vector<double> validation = depths_of(samples(8, sequences));
  options_.holdout.part = Holdout::Part::training;
  std::filesystem::remove_all(folder_ / "set");
  const std::vector<double> training = depths_of(samples(8, sequences));
  EXPECT_THAT(validation, ::testing::SizeIs(4));
  EXPECT_THAT(training, ::testing::SizeIs(4));
  for (const double depth : training) EXPECT_THAT(validation, ::testing::Not(::testing::Contains(depth)));
  options_.most = 2;
  std::filesystem::remove_all(folder_ / "set");
  EXPECT_THAT(depths_of(samples(8, sequences)), ElementsAre(training[0], training[2]));
}

TEST_F(NetworkSamplesTest, LandmarksAreFoundByTheirNames) {
  options_.convention = convention_from_name("nyu14");
  const NetworkSamples made = samples(1);
  const CubeSample sample = made.samples.sample(0);
  const Convention nyu = options_.convention;
  for (int j = 0; j < nyu.size(); ++j) {
    const bool is_labelled = nyu.landmarks[static_cast<std::size_t>(j)] == Landmark::palm ||
                             nyu.landmarks[static_cast<std::size_t>(j)] == Landmark::index_tip;
    EXPECT_EQ(std::isnan(sample.joints[3 * static_cast<std::size_t>(j)]), !is_labelled) << j;
  }
}

/// A landmark between the wrist and the tip of the index finger, and the palm.
LandmarkDefinition halfway_definition(const std::string& name) {
  const Landmark halfway = own_landmark("own_halfway", Landmark::index_mcp);
  LandmarkDefinition definition =
      LandmarkDefinition::plain(register_convention(name, {halfway, Landmark::palm}));
  definition.landmarks[0] = {.bone = Landmark::wrist, .towards = Landmark::index_tip, .share = 0.5};
  return definition;
}

TEST_F(NetworkSamplesTest, LandmarksOfOnesOwnLieWhereTheDefinitionSays) {
  options_.definition = halfway_definition("own_half");
  options_.convention = options_.definition->convention;
  const NetworkSamples made = samples(1);
  const CubeSample sample = made.samples.sample(0);
  const double tip_depth = 520.0;
  const double wrist_depth = 480.0;
  const double x = 0.5 * ((27.5 - 39.5) * tip_depth + (11.5 - 39.5) * wrist_depth) / 100.0;
  const double palm_x = (19.5 - 39.5) * 500.0 / 100.0;
  const double y = 0.5 * ((23.5 - 29.5) * tip_depth + (37.5 - 29.5) * wrist_depth) / 100.0;
  // Of a patch of 32 pixels for 200 mm; both lie at 500 mm.
  EXPECT_NEAR(6.25 * (sample.joints[0] - sample.joints[3]), x - palm_x, 1e-3);
  EXPECT_NEAR(6.25 * (sample.joints[1] - sample.joints[4]), y, 1e-3);
  EXPECT_NEAR(sample.joints[2], sample.joints[5], 1e-3);
}

TEST_F(NetworkSamplesTest, WhatASetLabelsItselfIsTakenAsItIs) {
  options_.definition = halfway_definition("own_half");
  options_.convention = options_.definition->convention;
  const auto labelled = [&](int, Frame& frame) {
    frame.truth = HandPose::missing(options_.convention);
    frame.truth->joints[0] = {25.5, 22.5, 510.0};
    frame.truth->joints[1] = {19.5, 29.5, 500.0};
  };
  const CubeSamples made = samples(1, labelled).samples;
  const CubeSample sample = made.sample(0);
  EXPECT_NEAR(150.0 * (sample.joints[2] - sample.joints[5]), 10.0, 0.01) << "half a crop's side is 150 mm";
}

TEST_F(NetworkSamplesTest, ASetWithoutACommonLandmarkIsNamed) {
  options_.convention = register_convention("own_dots", {own_landmark("own_dot", Landmark::palm)});
  EXPECT_THAT(testing::error_of([&] { samples(1); }),
              ::testing::AllOf(HasSubstr("folder:"), HasSubstr("knuckle22"), HasSubstr("own_dots")));
}

TEST_F(NetworkSamplesTest, WithoutTruthThereIsNothingToTrainOn) {
  EXPECT_THAT(testing::error_of([&] { samples(1, [](int, Frame& frame) { frame.truth.reset(); }); }),
              HasSubstr("no truth to train on"));
  std::filesystem::remove_all(folder_ / "set");
  EXPECT_THAT(testing::error_of([&] {
                samples(2, [](int, Frame& frame) { frame.truth = HandPose::missing(superset_convention()); });
              }),
              HasSubstr("no frame can be used: of 2 frames 2 have no labels"));
}

}  // namespace
}  // namespace knuckle
