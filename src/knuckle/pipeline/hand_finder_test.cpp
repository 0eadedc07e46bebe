// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/hand_finder.h"

#include <fstream>

#include "knuckle/core/testing.h"
#include "knuckle/pipeline/start.h"
#include "knuckle/segment/detector/detector_testing.h"
#include "knuckle/segment/detector/side_network.h"
#include "knuckle/segment/hand_region.h"

namespace knuckle {
namespace {

using ::testing::ElementsAre;

/// Three pixels that are no mirror image of themselves; 100 mm are 10 px at 500 mm.
Frame three_pixels() {
  Frame frame;
  frame.camera = {.width = 20, .height = 10, .fx = 50.0, .fy = 50.0, .cx = 9.5, .cy = 4.5};
  frame.depth_mm = Image<float>(20, 10);
  frame.depth_mm(2, 3) = frame.depth_mm(3, 3) = frame.depth_mm(2, 4) = 500.0f;
  return frame;
}

/// Finds all that is measured, at the start that it is given, and keeps what it was asked.
class KeepingSegmenter final : public Segmenter {
 public:
  struct Seen {
    std::optional<Point3> start;
    int max_hands = 0;
    int first_column = -1;
  };
  explicit KeepingSegmenter(Seen& seen) : seen_(seen) {}
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override {
    std::vector<std::int32_t> pixels;
    for (std::size_t i = 0; i < frame.depth_mm.size(); ++i) {
      if (is_measured(frame.depth_mm.data()[i])) pixels.push_back(static_cast<std::int32_t>(i));
    }
    HandRegion region = region_of_pixels(pixels, frame.depth_mm.width());
    seen_ = {start, max_hands, region.box.x};
    region.centre = Point3(30.0, 1.0, 500.0);
    region.score = 2.0;
    return {{region}, ""};
  }

 private:
  Seen& seen_;
};

TEST(HandFinder, OfAPipelineFileOnlyItsOwnTablesCount) {
  const testing::TemporaryFolder folder;
  const std::string others = "[patch]\na = 1\n[estimator]\nb = 1\n[tracker]\nc = 1\n[[refine]]\nd = 1\n";
  std::ofstream(folder / "whole.toml") << "[hand]\nmax_hands = 5\n[segmentation]\nmethod = \"mean_shift\"\n"
                                       << others;
  EXPECT_EQ(HandFinder::load(folder / "whole.toml").hand().max_hands, 5);
  std::ofstream(folder / "odd.toml") << "[segmentatio]\nmethod = \"mean_shift\"\n" << others;
  EXPECT_THAT(testing::error_of([&] { HandFinder::load(folder / "odd.toml"); }),
              ::testing::HasSubstr("segmentatio"));
}

TEST(HandFinder, WhoTellsSidesIsAskedWhereTheyAreOpen) {
  const DetectorWeights weights = random_detector(testing::small_detector(), 3);
  const std::vector<Point3> centres = {Point3(30.0, 1.0, 500.0)};
  const double right = SideNetwork(weights).right_hands(three_pixels(), centres)[0];
  for (const std::string side : {"auto", "right", "left"}) {
    KeepingSegmenter::Seen seen;
    const HandFinder finder(std::make_unique<KeepingSegmenter>(seen), {.side = side},
                            std::make_shared<const SideNetwork>(weights));
    const Segmentation found = finder.find(three_pixels(), std::nullopt);
    ASSERT_EQ(found.hands.size(), 1u);
    EXPECT_FALSE(finder.find_right(three_pixels(), std::nullopt).hands[0].right_hand) << "nobody asked";
    EXPECT_EQ(found.hands[0].right_hand, side == "auto" ? std::optional(right) : std::nullopt) << side;
    if (side != "auto") continue;
    EXPECT_EQ(found.hands[0].side, right >= 0.5 ? HandSide::right : HandSide::left);
    EXPECT_DOUBLE_EQ(mirrored(found.hands[0], 20).right_hand.value(), 1.0 - right);
  }
}

TEST(HandFinder, TheModelOfSidesIsNamedInTheFile) {
  const testing::TemporaryFolder folder;
  const std::string rest = "[segmentation]\nmethod = \"mean_shift\"\n";
  save_detector_weights(folder / "sides.pt", random_detector(testing::small_detector(), 3));
  std::ofstream(folder / "good.toml") << "[hand]\nside = \"auto\"\nside_model = \"sides.pt\"\n" << rest;
  EXPECT_NO_THROW(HandFinder::load(folder / "good.toml"));
  std::ofstream(folder / "bad.toml") << "[hand]\nside_model = \"none.pt\"\n" << rest;
  EXPECT_THAT(testing::error_of([&] { HandFinder::load(folder / "bad.toml"); }),
              ::testing::HasSubstr("none.pt"));
}

TEST(HandFinder, ALeftHandIsSoughtInTheMirrorAndFoundInTheFrame) {
  KeepingSegmenter::Seen seen;
  const HandFinder finder(std::make_unique<KeepingSegmenter>(seen), {.side = "left", .max_hands = 3});
  const Segmentation found = finder.find(three_pixels(), Point3(-40.0, 2.0, 510.0));
  EXPECT_EQ(*seen.start, Point3(40.0, 2.0, 510.0));
  EXPECT_EQ(seen.max_hands, 3);
  EXPECT_EQ(seen.first_column, 16);
  ASSERT_EQ(found.hands.size(), 1u);
  EXPECT_EQ(found.hands[0].box, (Box{2, 3, 2, 2}));
  EXPECT_THAT(found.hands[0].mask.pixels(), ElementsAre(1, 1, 1, 0));
  EXPECT_EQ(found.hands[0].centre, Point3(-30.0, 1.0, 500.0));
  EXPECT_EQ(found.hands[0].score, 2.0);
}

TEST(HandFinder, ARightHandIsSoughtInTheFrameItself) {
  KeepingSegmenter::Seen seen;
  const HandFinder finder(std::make_unique<KeepingSegmenter>(seen), {.max_hands = 2});
  const Segmentation found = finder.find(three_pixels(), std::nullopt);
  EXPECT_FALSE(seen.start);
  EXPECT_EQ(seen.max_hands, 2);
  EXPECT_EQ(seen.first_column, 2);
  EXPECT_EQ(found.hands.at(0).centre, Point3(30.0, 1.0, 500.0));
}

TEST(AsRightHand, IsMirroredWhereTheFrameElseTheOptionsSayLeft) {
  Frame frame = three_pixels();
  const auto first_column = [&](std::optional<HandSide> side, const std::string& option) {
    frame.side = side;
    const Frame right = as_right_hand(frame, {.side = option});
    return right.depth_mm(2, 4) > 0.0f ? 2 : right.depth_mm(17, 4) > 0.0f ? 17 : -1;
  };
  EXPECT_EQ(first_column(std::nullopt, "right"), 2);
  EXPECT_EQ(first_column(std::nullopt, "left"), 17);
  EXPECT_EQ(first_column(HandSide::left, "right"), 17);
  EXPECT_EQ(first_column(HandSide::right, "left"), 2);
}

class TrueStart : public ::testing::Test {
 protected:
  TrueStart() { frame_.truth = HandPose::missing(superset_convention()); }

  /// A joint at pixel (9.5 + x / 10, 4.5), 500 mm away: at (x, 0, 500) mm.
  void put(Landmark landmark, double x_mm) {
    const int index = frame_.truth->convention.index_of(landmark);
    frame_.truth->joints[index] = {9.5 + 0.1 * x_mm, 4.5, 500.0};
  }
  double x_mm() const { return true_start(frame_)->x(); }

  Frame frame_ = three_pixels();
};

TEST_F(TrueStart, IsThePalmElseTheMeanOfWristAndBasesElseOfAllJoints) {
  EXPECT_FALSE(true_start(frame_));
  put(Landmark::index_tip, 90.0);
  put(Landmark::thumb_mcp, 10.0);
  EXPECT_NEAR(x_mm(), 50.0, 1e-9);
  put(Landmark::wrist, -10.0);
  put(Landmark::little_mcp, -40.0);
  EXPECT_NEAR(x_mm(), -25.0, 1e-9);
  put(Landmark::thumb_cmc, 11.0);
  put(Landmark::index_mcp, 4.0);
  put(Landmark::middle_mcp, 3.0);
  put(Landmark::ring_mcp, 2.0);
  EXPECT_NEAR(x_mm(), -5.0, 1e-9);
  put(Landmark::palm, 20.0);
  EXPECT_NEAR(x_mm(), 20.0, 1e-9);
  frame_.truth.reset();
  EXPECT_FALSE(true_start(frame_));
}

TEST_F(TrueStart, IsUsedOnlyWhereAskedFor) {
  put(Landmark::palm, 20.0);
  EXPECT_FALSE(start_in(frame_, Start::nearest));
  EXPECT_NEAR(start_in(frame_, Start::truth)->x(), 20.0, 1e-9);
  EXPECT_EQ(start_from_name("truth"), Start::truth);
  EXPECT_EQ(start_from_name("nearest"), Start::nearest);
  EXPECT_THAT(testing::error_of([] { start_from_name("palm"); }), ::testing::HasSubstr("nearest or truth"));
}

TEST(MirroredPoint, ChangesTheSignOfXAlone) {
  EXPECT_EQ(*mirrored(std::optional(Point3(3.0, 4.0, 5.0))), Point3(-3.0, 4.0, 5.0));
  EXPECT_FALSE(mirrored(std::optional<Point3>()));
}

}  // namespace
}  // namespace knuckle
