// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/thing_samples.h"

#include <functional>

#include "knuckle/camera/projection.h"
#include "knuckle/core/testing.h"
#include "knuckle/data/writers/folder_writer.h"
#include "knuckle/segment/detector/detector_testing.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

const Point3 kHand(-80, 0, 500);
const Point3 kThing(120, 20, 520);  // what the detector takes for a hand

/// A hand and a thing, both balls.
Frame frame_of_two() {
  Frame frame = testing::blank_frame(testing::quarter_vga_camera());
  testing::draw_ball(frame, kHand, 50);
  testing::draw_ball(frame, kThing, 50);
  frame.truth = HandPose::missing(superset_convention());
  frame.truth->joints[0] = Projection(frame.camera).to_image(kHand);
  return frame;
}

class ThingSamples : public ::testing::Test {
 protected:
  NetworkSamples things(
      int count, const std::function<void(Frame&)>& change = [](Frame&) {}) {
    FrameWriterOptions writer_options;
    writer_options.count = count;
    FolderWriter writer(folder_ / "set", writer_options);
    for (int i = 0; i < count; ++i) {
      Frame frame = frame_of_two();
      change(frame);
      writer.write(i, frame);
    }
    writer.finish();
    const DetectedHand seen{.centre = seen_, .extent_mm = 60.0, .score = 0.6};
    const HandDetector detector(
        testing::constant_detector(testing::small_detector(), testing::quarter_vga_camera(), seen));
    SampleOptions options;
    options.patch = {32, 200.0};
    options.crop_px = 48;
    return thing_samples("folder:" + (folder_ / "set").string(), detector, options);
  }

  testing::TemporaryFolder folder_;
  Point3 seen_ = kThing;
};

TEST_F(ThingSamples, AreWhatLooksLikeAHandOrAnythingFarFromHands) {
  const NetworkSamples found = things(24);
  ASSERT_EQ(found.samples.size(), 24);
  EXPECT_EQ(found.frames.total, 24);
  EXPECT_EQ(found.frames.without_hand, 0);
  int sought = 0;
  for (std::int64_t i = 0; i < 24; ++i) {
    const CubeSample sample = found.samples.sample(i);
    EXPECT_GT((sample.centre_mm - kHand).norm(), 160.0);
    EXPECT_LT((sample.centre_mm - kThing).norm(), 55.0);
    sought += (sample.centre_mm - kThing).norm() < 2.0;
    for (const float number : sample.joints) EXPECT_TRUE(std::isnan(number));
    EXPECT_TRUE(
        std::ranges::any_of(sample.codes, [](auto code) { return code != CubeSamples::kBackgroundCode; }));
  }
  EXPECT_GT(sought, 6) << "half are where the detector looks";
  EXPECT_LT(sought, 18);
}

TEST_F(ThingSamples, OfAHandThatIsSeenOtherPlacesAreTaken) {
  seen_ = kHand + Point3(100, 0, 0);
  for (const NetworkSamples found = things(6); const std::int64_t i : {0, 1, 2, 3, 4, 5})
    EXPECT_GT((found.samples.sample(i).centre_mm - kHand).norm(), 160.0);
}

TEST_F(ThingSamples, OfFramesWithoutTruthAreRefused) {
  EXPECT_THAT(error_of([&] { things(1, [](Frame& frame) { frame.truth.reset(); }); }),
              HasSubstr("no truth to train on"));
}

TEST_F(ThingSamples, FramesOfHandsAloneAreRefused) {
  seen_ = kHand;
  EXPECT_THAT(error_of([&] {
                things(2, [](Frame& frame) {
                  frame.truth->joints[1] = Projection(frame.camera).to_image(kThing);
                  frame.truth->joints[0] = Projection(frame.camera).to_image(2 * kHand - kThing);
                  frame.depth_mm = Image<float>(320, 240);
                  testing::draw_ball(frame, kHand, 50);
                });
              }),
              HasSubstr("no frame shows anything but hands"));
}

}  // namespace
}  // namespace knuckle
