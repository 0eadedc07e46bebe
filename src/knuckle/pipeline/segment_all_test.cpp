// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/segment_all.h"

#include <chrono>
#include <thread>

#include "knuckle/core/testing.h"
#include "knuckle/segment/hand_region.h"

namespace knuckle {
namespace {

constexpr int kFrames = 60;

/// The frame's number is its first depth; its hand, where it has one, is a box of 3 x 2 at column 4, row 5.
class MaskedSource final : public FrameSource {
 public:
  std::int64_t size() const override { return kFrames; }
  Frame read(std::int64_t index) const override {
    Frame frame;
    frame.camera = {.width = 12, .height = 10, .fx = 10.0, .fy = 10.0, .cx = 5.5, .cy = 4.5};
    frame.depth_mm = Image<float>(12, 10, 500.0f + static_cast<float>(index));
    if (index == 7) return frame;  // without a mask
    frame.mask = Image<std::uint8_t>(12, 10);
    if (index == 8) return frame;  // with an empty one
    for (int row = 5; row < 7; ++row) {
      for (int column = 4; column < 7; ++column) frame.mask(column, row) = 1;
    }
    return frame;
  }
  std::optional<Convention> convention() const override { return std::nullopt; }
};

/// Finds the right two columns of the hand and one more, in frames that are not a multiple of four; the
/// others take their time.
class ShiftedSegmenter final : public Segmenter {
 public:
  Segmentation segment(const Frame& frame, const std::optional<Point3>& /*start*/,
                       int /*max_hands*/) const override {
    const int number = static_cast<int>(frame.depth_mm(0, 0)) - 500;
    if (number % 4 == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      return {{}, "nothing"};
    }
    std::vector<std::int32_t> pixels;
    for (int row = 5; row < 7; ++row) {
      for (int column = 5; column < 8; ++column) pixels.push_back(row * 12 + column);
    }
    return {{region_of_pixels(pixels, 12)}, ""};
  }
};

TEST(SegmentAll, ResultsAreThoseOfTheirFramesInOrder) {
  const HandFinder finder(std::make_unique<ShiftedSegmenter>());
  const std::vector<FrameSegmentation> frames = segment_all(MaskedSource(), finder, Start::nearest, "x");
  ASSERT_EQ(frames.size(), std::size_t{kFrames});
  for (int i = 0; i < kFrames; ++i) {
    const FrameSegmentation& frame = frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.found, i % 4 != 0) << i;
    EXPECT_EQ(frame.box, i % 4 != 0 ? (Box{5, 5, 3, 2}) : Box()) << i;
    EXPECT_EQ(frame.mask.has_value(), i != 7) << i;
  }
}

TEST(SegmentAll, TheUnionHoldsWhatIsTrueAndWhatIsFound) {
  const HandFinder finder(std::make_unique<ShiftedSegmenter>());
  const std::vector<FrameSegmentation> frames = segment_all(MaskedSource(), finder, Start::nearest, "x");
  const auto expect_overlap = [&](std::size_t frame, std::int64_t in_both, std::int64_t in_either,
                                  double iou) {
    EXPECT_EQ(frames[frame].mask->in_both, in_both) << frame;
    EXPECT_EQ(frames[frame].mask->in_either, in_either) << frame;
    EXPECT_DOUBLE_EQ(frames[frame].mask->iou(), iou) << frame;
  };
  expect_overlap(1, 4, 8, 0.5);  // two columns of three in common
  expect_overlap(4, 0, 6, 0.0);  // nothing was found
  expect_overlap(8, 0, 0, 1.0);  // there is nothing to find
}

TEST(SegmentAll, WritesBoxesAsALinePerFrame) {
  std::vector<FrameSegmentation> frames(2);
  frames[0].found = true;
  frames[0].box = {1, 2, 30, 40};
  frames[0].milliseconds = 1.5;
  const std::string csv = boxes_csv(frames);
  EXPECT_THAT(csv, ::testing::StartsWith("frame,found,x,y,width,height,milliseconds\n0,1,1,2,30,40,1.5"));
  EXPECT_THAT(csv, ::testing::HasSubstr("\n1,0,"));
}

}  // namespace
}  // namespace knuckle
