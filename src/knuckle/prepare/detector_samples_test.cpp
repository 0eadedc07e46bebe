// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/detector_samples.h"

#include <algorithm>
#include <cmath>

#include "knuckle/camera/projection.h"
#include "knuckle/core/testing.h"
#include "knuckle/data/writers/folder_writer.h"
#include "knuckle/prepare/detector_augmentation.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

using testing::blank_frame;
using testing::draw_ball;
using testing::quarter_vga_camera;

const DetectorAugmentation kFaultless{
    .noise_per_m = 0, .missing_share = 0, .erased_discs = 0, .erased_cells = 0, .cut_share = 0};

/// A ball at `centre` with a truth of three landmarks around it.
Frame ball_frame(const Point3& centre, std::optional<HandSide> side) {
  Frame frame = blank_frame(quarter_vga_camera());
  draw_ball(frame, centre, 60);
  frame.side = side;
  const Projection projection(frame.camera);
  frame.truth = HandPose::missing(convention_from_name("knuckle22"));
  for (int i = 0; i < 3; ++i) {
    frame.truth->joints[static_cast<std::size_t>(i)] =
        projection.to_image(centre + Point3(40.0 * (i - 1), 0, 0));
  }
  return frame;
}

DetectorSamples detector_samples_of(const std::vector<Frame>& frames) {
  DetectorSamples samples({}, std::ssize(frames));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const DetectorView view({}, frames[i].camera);
    samples.set(static_cast<std::int64_t>(i), view.shrink(frames[i].depth_mm),
                hand_numbers(hands_to_detect(frames[i]), view));
  }
  return samples;
}

TEST(DetectorSamplesOfASource, WithoutTruthAreRefused) {
  const testing::TemporaryFolder folder;
  FrameWriterOptions options;
  options.count = 1;
  FolderWriter writer(folder / "set", options);
  writer.write(0, blank_frame(quarter_vga_camera()));
  writer.finish();
  EXPECT_THAT(
      testing::error_of(
          [&] { DetectorFrames(std::vector<DetectorSource>{{"folder:" + (folder / "set").string()}}, {}); }),
      ::testing::AllOf(::testing::HasSubstr("folder:"), ::testing::HasSubstr("no truth to train on")));
}

TEST(LabelledHands, CentreAndExtentAreThoseOfTheKnownLandmarks) {
  const std::vector<HandToDetect> hands = hands_to_detect(ball_frame({30, -20, 600}, HandSide::left));
  ASSERT_EQ(hands.size(), 1u);
  EXPECT_LT((hands[0].centre - Point3(30, -20, 600)).norm(), 1e-6);
  EXPECT_NEAR(hands[0].extent_mm, 40.0, 1e-6);
  EXPECT_EQ(hands[0].side, HandSide::left);
  EXPECT_TRUE(hands_to_detect(blank_frame(quarter_vga_camera())).empty());
  Frame unknown = ball_frame({30, -20, 600}, std::nullopt);
  EXPECT_FALSE(hands_to_detect(unknown)[0].side.has_value());
  unknown.truth = HandPose::missing(convention_from_name("knuckle22"));
  EXPECT_TRUE(hands_to_detect(unknown).empty());
}

TEST(LabelledHands, AllHandsOfAFrameAreKnownAndTheHiddenDoNotCount) {
  Frame frame = ball_frame({30, -20, 600}, HandSide::left);
  const Frame other = ball_frame({-90, 10, 700}, HandSide::right);
  frame.hands = {{HandSide::left, *frame.truth, {}, 0.9}, {HandSide::right, *other.truth, {}, 0.05}};
  const std::vector<HandToDetect> hands = hands_to_detect(frame);
  ASSERT_EQ(hands.size(), 2u);
  EXPECT_LT((hands[0].centre - Point3(30, -20, 600)).norm(), 1e-6);
  EXPECT_LT((hands[1].centre - Point3(-90, 10, 700)).norm(), 1e-6);
  EXPECT_EQ(hands[1].side, HandSide::right);
  EXPECT_TRUE(hands[0].counts);
  EXPECT_FALSE(hands[1].counts);
}

TEST(DetectorSamples, KeepWhatWasSeenWithinTheirSteps) {
  const Frame frame = ball_frame({30, -20, 600}, HandSide::right);
  const DetectorSamples samples = detector_samples_of({frame});
  const DetectorInput input = DetectorView({}, frame.camera).shrink(frame.depth_mm);
  std::vector<float> seen(input.inverse_depth.size() * kMeasuredInputs);
  view_cells(samples.sample(0), {}, {}, seen);
  for (std::size_t i = 0; i < input.inverse_depth.size(); ++i) {
    EXPECT_NEAR(seen[i], input.inverse_depth.data()[i], 1e-4);
    EXPECT_NEAR(seen[input.inverse_depth.size() + i], input.measured_share.data()[i], 1e-6);
  }
}

TEST(DetectorSamples, TakeAsManyBytesAsTheySay) {
  const Frame frame = ball_frame({30, -20, 600}, HandSide::right);
  const DetectorSamples samples = detector_samples_of({frame});
  const DetectorSample sample = samples.sample(0);
  const auto held = static_cast<std::int64_t>(sample.codes.size_bytes() + sample.measured.size_bytes() +
                                              sample.hands.size_bytes());
  EXPECT_EQ(DetectorSamples::bytes(5, {}), 5 * held);
}

/// The middle of the cells in which something was measured.
ImagePoint middle_of(std::span<const float> input) {
  const DetectorOptions options;
  double sum_u = 0.0;
  double sum_v = 0.0;
  double count = 0.0;
  for (int row = 0; row < options.height; ++row) {
    for (int column = 0; column < options.width; ++column) {
      if (input[static_cast<std::size_t>(row) * options.width + column] <= 0.0f) continue;
      sum_u += column;
      sum_v += row;
      ++count;
    }
  }
  return {sum_u / count, sum_v / count, count};
}

TEST(DetectorViews, HandsMoveAsCellsDo) {
  const DetectorSamples samples = detector_samples_of({ball_frame({30, -20, 700}, HandSide::right)});
  const DetectorOptions options;
  std::vector<float> input(static_cast<std::size_t>(options.width) * options.height * kMeasuredInputs);
  LabelledHands hands;
  Random random(1);
  DetectorAugmentation augmentation = kFaultless;
  augmentation.rotation_deg = 180.0;
  for (int i = 0; i < 40; ++i) {
    const PictureView view = random_view(augmentation, random);
    view_cells(samples.sample(0), options, view, input);
    view_hands(samples.sample(0), options, view, hands);
    ASSERT_EQ(hands[kHandCounts], 1.0f);
    const ImagePoint middle = middle_of(input);
    EXPECT_NEAR(middle.u, hands[kHandU], 0.5);
    EXPECT_NEAR(middle.v, hands[kHandV], 0.5);
    EXPECT_EQ(hands[kHandSide], view.is_mirrored ? 0.0f : 1.0f);
    // What comes nearer grows: the ball's surface lies 60 mm before its centre.
    const float nearest = *std::ranges::max_element(std::span(input).first(input.size() / 2));
    EXPECT_NEAR(nearest / std::exp(hands[kHandInverseDepth]), 700.0 / 640.0, 0.01);
    EXPECT_TRUE(std::isnan(hands[kHandNumbers + kHandCounts])) << "there is no second hand";
  }
}

TEST(DetectorViews, AMirrorSeenInAMirrorIsThePictureItself) {
  const DetectorSamples samples = detector_samples_of(
      {ball_frame({30, -20, 700}, HandSide::left), mirrored(ball_frame({30, -20, 700}, HandSide::left))});
  const DetectorOptions options;
  std::vector<float> there(static_cast<std::size_t>(options.width) * options.height * kMeasuredInputs);
  std::vector<float> back(there.size());
  LabelledHands hands_there;
  LabelledHands hands_back;
  view_cells(samples.sample(0), options, {}, there);
  view_cells(samples.sample(1), options, {.is_mirrored = true}, back);
  view_hands(samples.sample(0), options, {}, hands_there);
  view_hands(samples.sample(1), options, {.is_mirrored = true}, hands_back);
  EXPECT_EQ(there, back);
  for (const std::size_t number : {kHandU, kHandV, kHandInverseDepth, kHandExtent, kHandSide}) {
    EXPECT_NEAR(hands_there[number], hands_back[number], 1e-3);
  }
}

TEST(DetectorViews, AHandThatLeavesThePictureOrIsNotMeasuredDoesNotCount) {
  const DetectorSamples samples = detector_samples_of({ball_frame({30, -20, 700}, HandSide::right)});
  const DetectorOptions options;
  std::vector<float> input(static_cast<std::size_t>(options.width) * options.height * kMeasuredInputs);
  LabelledHands hands;
  view_hands(samples.sample(0), options, {.shift_u = 100.0}, hands);
  EXPECT_EQ(hands[kHandCounts], 0.0f);
  view_hands(samples.sample(0), options, {}, hands);
  view_cells(samples.sample(0), options, {}, input);
  excuse_unseen_hands(options, input, hands);
  EXPECT_EQ(hands[kHandCounts], 1.0f);
  std::ranges::fill(input, 0.0f);
  excuse_unseen_hands(options, input, hands);
  EXPECT_EQ(hands[kHandCounts], 0.0f);
}

TEST(DetectorViews, FaultsKeepNumbersInTheirRanges) {
  const DetectorSamples samples = detector_samples_of({ball_frame({30, -20, 700}, HandSide::right)});
  const DetectorOptions options;
  std::vector<float> clean(static_cast<std::size_t>(options.width) * options.height * kMeasuredInputs);
  view_cells(samples.sample(0), options, {}, clean);
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    std::vector<float> input = clean;
    spoil_cells({}, options, random, input);
    EXPECT_NE(input, clean);
    for (const float value : input) EXPECT_TRUE(value >= 0.0f && value <= kMostInverseDepth + 1.0);
  }
}

TEST(DetectorSamples, OfAManifestAreTheSameOnAnyNumberOfThreads) {
  const DetectorOptions options{.width = 64, .height = 48, .focal_cells = 43.0};
  const DetectorFrames frames(std::vector<DetectorSource>{{"synthetic:manifests/demo.toml", 6}}, options);
  const DetectorSamples samples = samples_of(frames);
  const DetectorSamples again = samples_of(frames);
  ASSERT_EQ(samples.size(), 6);
  for (std::int64_t i = 0; i < samples.size(); ++i) {
    EXPECT_TRUE(std::ranges::equal(samples.sample(i).codes, again.sample(i).codes));
    EXPECT_EQ(samples.sample(i).hands[kHandCounts], 1.0f);
    EXPECT_TRUE(std::isfinite(samples.sample(i).hands[kHandSide]));
  }
}

TEST(DetectorFrames, OfSeveralSourcesAreTheirsOneAfterAnother) {
  const DetectorOptions options{.width = 64, .height = 48, .focal_cells = 43.0};
  const DetectorSource demo{"synthetic:manifests/demo.toml", 3};
  const DetectorSource scenes{"synthetic:manifests/validate_scenes.toml", 2};
  const DetectorSamples first = samples_of(DetectorFrames({&demo, 1}, options));
  const DetectorSamples second = samples_of(DetectorFrames({&scenes, 1}, options));
  const DetectorSamples both = samples_of(DetectorFrames(std::vector{demo, scenes}, options));
  ASSERT_EQ(both.size(), 5);
  for (std::int64_t i = 0; i < both.size(); ++i) {
    const DetectorSample alone = i < 3 ? first.sample(i) : second.sample(i - 3);
    EXPECT_TRUE(std::ranges::equal(both.sample(i).codes, alone.codes)) << i;
    EXPECT_TRUE(std::ranges::equal(both.sample(i).measured, alone.measured)) << i;
  }
}

}  // namespace
}  // namespace knuckle
