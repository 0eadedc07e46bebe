// SPDX-License-Identifier: Apache-2.0
// What every segmentation method must do.
#include "knuckle/segment/segmenter.h"

#include <limits>
#include <numbers>
#include <sstream>
#include <string>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/segment/detector/detector_testing.h"
#include "knuckle/segment/hand_region.h"
#include "knuckle/segment/segmentation_forest.h"
#include "knuckle/segment/segmenter_factory.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

using ::knuckle::testing::blank_frame;
using ::knuckle::testing::draw_ball;
using ::knuckle::testing::error_of;
using ::knuckle::testing::hand_frame;
using ::knuckle::testing::quarter_vga_camera;
using ::testing::HasSubstr;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A way to make a segmenter: the method and its options.
struct Setup {
  std::string name;
  std::string toml;
};

/// A forest that calls everything a hand; lives as long as the tests.
const std::filesystem::path& trusting_forest_file() {
  static const testing::TemporaryFolder folder;
  static const std::filesystem::path path = [] {
    save_segmentation_forest(folder / "forest.model", testing::trusting_forest());
    return folder / "forest.model";
  }();
  return path;
}

/// A detector that has learned nothing.
const std::filesystem::path& random_detector_file() {
  static const testing::TemporaryFolder folder;
  static const std::filesystem::path path = [] {
    save_detector_weights(folder / "hands.pt", random_detector(testing::small_detector(), 1));
    return folder / "hands.pt";
  }();
  return path;
}

/// What the table of a method needs beside its options.
std::string model_line(std::string_view name) {
  if (name == "forest") return "\nmodel = \"" + trusting_forest_file().string() + "\"";
  if (name == "detector") return "\nmodel = \"" + random_detector_file().string() + "\"";
  return "";
}

class SegmenterTest : public ::testing::TestWithParam<Setup> {
 protected:
  static std::unique_ptr<Segmenter> segmenter() {
    return create_segmenter(OptionTable::parse(GetParam().toml + model_line(GetParam().name), "test.toml"));
  }
  static bool finds_several_hands() { return GetParam().toml.find("\"all\"") == std::string::npos; }
};

/// Box and mask agree, the mask holds measured pixels only, everything is finite.
void expect_sound(const Segmentation& found, const Frame& frame) {
  EXPECT_EQ(found.hands.empty(), !found.reason.empty()) << found.reason;
  for (const HandRegion& hand : found.hands) {
    const Box frame_box{0, 0, frame.depth_mm.width(), frame.depth_mm.height()};
    ASSERT_EQ(intersection(hand.box, frame_box), hand.box);
    ASSERT_EQ(hand.mask.width(), hand.box.width);
    ASSERT_EQ(hand.mask.height(), hand.box.height);
    EXPECT_TRUE(hand.centre.allFinite());
    EXPECT_GT(hand.score, 0.0);
    EXPECT_TRUE(std::isfinite(hand.score));
    Box tight{hand.box.width, hand.box.height, 0, 0};
    for (int row = 0; row < hand.box.height; ++row) {
      for (int column = 0; column < hand.box.width; ++column) {
        if (hand.mask(column, row) == 0) continue;
        ASSERT_EQ(hand.mask(column, row), 1);
        ASSERT_TRUE(is_measured(frame.depth_mm(hand.box.x + column, hand.box.y + row)));
        tight.x = std::min(tight.x, column);
        tight.y = std::min(tight.y, row);
        tight.width = std::max(tight.width, column + 1);
        tight.height = std::max(tight.height, row + 1);
      }
    }
    EXPECT_EQ(tight, (Box{0, 0, hand.box.width, hand.box.height}));
  }
}

void expect_same(const Segmentation& a, const Segmentation& b, double tolerance_mm) {
  ASSERT_EQ(a.hands.size(), b.hands.size());
  for (std::size_t i = 0; i < a.hands.size(); ++i) {
    EXPECT_LE((a.hands[i].centre - b.hands[i].centre).norm(), tolerance_mm);
    EXPECT_EQ(a.hands[i].box, b.hands[i].box);
    EXPECT_EQ(a.hands[i].mask, b.hands[i].mask);
  }
}

TEST_P(SegmenterTest, FindsNoHandInABlankFrame) {
  for (const float value : {0.0f, -1.0f, kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
    Frame frame = blank_frame(quarter_vga_camera());
    std::ranges::fill(frame.depth_mm.pixels(), value);
    const Segmentation found = segmenter()->segment(frame, std::nullopt, 1);
    EXPECT_TRUE(found.hands.empty());
    EXPECT_FALSE(found.reason.empty());
    EXPECT_TRUE(segmenter()->segment(frame, Point3(0, 0, 500), 1).hands.empty());
  }
}

TEST_P(SegmenterTest, FindsNoHandInAFrameWithoutPixels) {
  const Segmentation found = segmenter()->segment(Frame{}, std::nullopt, 1);
  EXPECT_TRUE(found.hands.empty());
  EXPECT_FALSE(found.reason.empty());
}

TEST_P(SegmenterTest, SurvivesNoise) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Frame frame = blank_frame(quarter_vga_camera());
    Random random(seed);
    for (float& depth : frame.depth_mm.pixels()) {
      const double kind = random.uniform();
      depth = static_cast<float>(random.uniform(-100, 3000));
      if (kind < 0.02) depth = kInfinity;
      if (kind > 0.98) depth = std::numeric_limits<float>::quiet_NaN();
      if (kind > 0.5 && seed % 2 == 0) depth = 0.0f;
    }
    const Segmentation found = segmenter()->segment(frame, std::nullopt, 4);
    expect_sound(found, frame);
    expect_sound(segmenter()->segment(frame, Point3(0, 0, 700), 1), frame);
  }
}

TEST_P(SegmenterTest, FindsABall) {
  Frame frame = blank_frame(quarter_vga_camera());
  const Point3 centre(-40, 30, 520);
  draw_ball(frame, centre, 60);
  for (const std::optional<Point3>& start : {std::optional<Point3>(), std::optional<Point3>({0, 0, 500})}) {
    const Segmentation found = segmenter()->segment(frame, start, 1);
    expect_sound(found, frame);
    ASSERT_EQ(found.hands.size(), 1u);
    const HandRegion& hand = found.hands[0];
    int pixels = 0;
    for (const float depth : frame.depth_mm.pixels()) pixels += is_measured(depth) ? 1 : 0;
    int masked = 0;
    for (const std::uint8_t pixel : hand.mask.pixels()) masked += pixel;
    EXPECT_EQ(masked, pixels);  // all of it, nothing else
    // The centre lies on the line of sight to the ball's, in its front half.
    EXPECT_LT(hand.centre.cross(centre.normalized()).norm(), 1.5);
    EXPECT_LT(hand.centre.z(), centre.z());
    EXPECT_GT(hand.centre.z(), centre.z() - 60);
  }
}

TEST_P(SegmenterTest, IgnoresSpecklesInFrontOfTheHand) {
  Frame frame = blank_frame(quarter_vga_camera());
  draw_ball(frame, Point3(0, 0, 720), 60);
  const Segmentation clean = segmenter()->segment(frame, std::nullopt, 1);
  frame.depth_mm(20, 20) = 130.0f;
  frame.depth_mm(300, 200) = 150.0f;
  for (int i = 0; i < 25; ++i) frame.depth_mm(100 + i % 5, 30 + i / 5) = 200.0f;  // survives the median
  expect_same(segmenter()->segment(frame, std::nullopt, 1), clean, 0.02);
}

TEST_P(SegmenterTest, FindsAHandThatTheBorderCuts) {
  for (const Point3& centre :
       {Point3(-330, 0, 500), Point3(330, 0, 500), Point3(0, -248, 500), Point3(0, 240, 500)}) {
    Frame frame = blank_frame(quarter_vga_camera());
    draw_ball(frame, centre, 60);
    const Segmentation found = segmenter()->segment(frame, std::nullopt, 1);
    expect_sound(found, frame);
    EXPECT_EQ(found.hands.size(), 1u) << centre.transpose();
  }
}

TEST_P(SegmenterTest, CallsNothingAHandThatIsTooSmall) {
  Frame frame = blank_frame(quarter_vga_camera());
  draw_ball(frame, Point3(0, 0, 500), 12);
  EXPECT_TRUE(segmenter()->segment(frame, std::nullopt, 1).hands.empty());
  const Segmentation found = segmenter()->segment(frame, Point3(0, 0, 500), 1);
  EXPECT_TRUE(found.hands.empty());
  EXPECT_THAT(found.reason, HasSubstr("mm^2"));
}

TEST_P(SegmenterTest, FindsAtMostTheHandsAskedFor) {
  Frame frame = blank_frame(quarter_vga_camera());
  draw_ball(frame, Point3(-220, 0, 500), 60);
  draw_ball(frame, Point3(200, 20, 520), 55);
  for (int max_hands = 1; max_hands <= 3; ++max_hands) {
    const Segmentation found = segmenter()->segment(frame, std::nullopt, max_hands);
    expect_sound(found, frame);
    const int expected = finds_several_hands() ? std::min(max_hands, 2) : 1;
    ASSERT_EQ(std::ssize(found.hands), expected);
    if (expected == 2) {
      EXPECT_TRUE(intersection(found.hands[0].box, found.hands[1].box).empty());
      EXPECT_GE(found.hands[0].score, found.hands[1].score);
    }
  }
}

TEST_P(SegmenterTest, GivesTheMirroredResultForTheMirroredFrame) {
  for (std::uint64_t seed = 20; seed < 24; ++seed) {
    const Frame frame = hand_frame(seed);
    const Segmentation found = segmenter()->segment(frame, std::nullopt, 1);
    ASSERT_EQ(found.hands.size(), 1u);
    Segmentation mirror = segmenter()->segment(mirrored(frame), std::nullopt, 1);
    for (HandRegion& hand : mirror.hands) hand = mirrored(hand, frame.depth_mm.width());
    ASSERT_EQ(mirror.hands.size(), 1u);
    EXPECT_LT((mirror.hands[0].centre - found.hands[0].centre).norm(), 0.05);
    EXPECT_EQ(mirror.hands[0].box, found.hands[0].box);
  }
}

TEST_P(SegmenterTest, SeesADistortedCamerasHandWhereItIs) {
  Camera camera = quarter_vga_camera();
  camera.distortion = {-0.25, 0.06, 0.001, -0.001, 0, 0, 0, 0};
  const Point3 centre(150, 100, 500);
  Frame frame = blank_frame(camera);
  draw_ball(frame, centre, 60);
  const Segmentation found = segmenter()->segment(frame, std::nullopt, 1);
  ASSERT_EQ(found.hands.size(), 1u);
  EXPECT_LT(found.hands[0].centre.cross(centre.normalized()).norm(), 1.5);
}

TEST_P(SegmenterTest, WorksWithAnOrthographicCamera) {
  Camera camera = quarter_vga_camera();
  camera.model = CameraModel::orthographic;
  camera.fx = camera.fy = 0.5;
  Frame frame = blank_frame(camera);
  draw_ball(frame, Point3(50, -40, 500), 60);
  const Segmentation found = segmenter()->segment(frame, std::nullopt, 1);
  ASSERT_EQ(found.hands.size(), 1u);
  EXPECT_NEAR(found.hands[0].centre.x(), 50.0, 0.5);
  EXPECT_NEAR(found.hands[0].centre.y(), -40.0, 0.5);
}

TEST_P(SegmenterTest, GivesTheSameOnAllThreads) {
  std::vector<Frame> frames;
  for (std::uint64_t seed = 0; seed < 4; ++seed) frames.push_back(hand_frame(seed));
  frames[1].camera.cx += 1.0;  // so that the threads do not agree on one camera
  const std::unique_ptr<Segmenter> shared = segmenter();
  std::vector<Segmentation> found(64);
  parallel_for(64, [&](std::int64_t i) { found[i] = shared->segment(frames[i % 4], std::nullopt, 1); });
  for (std::size_t i = 0; i < found.size(); ++i) {
    expect_same(found[i], segmenter()->segment(frames[i % 4], std::nullopt, 1), 0.0);
  }
}

TEST_P(SegmenterTest, NamesTheFrameThatDoesNotFit) {
  Frame frame = hand_frame(0);
  for (const double bad : {kNaN, std::numeric_limits<double>::infinity()}) {
    const std::string message = error_of([&] { (void)segmenter()->segment(frame, Point3(0, bad, 500), 1); });
    EXPECT_THAT(message, HasSubstr(frame.name));
    EXPECT_THAT(message, HasSubstr("finite"));
  }
  frame.camera.width = 321;
  EXPECT_THAT(error_of([&] { (void)segmenter()->segment(frame, std::nullopt, 1); }),
              HasSubstr("the depth image is 320 x 240 pixels, its camera 321 x 240"));
}

TEST_P(SegmenterTest, RefusesImpossibleNumbersOfHands) {
  EXPECT_THAT(
      error_of([] { (void)segmenter()->segment(blank_frame(quarter_vga_camera()), std::nullopt, 0); }),
      HasSubstr("max_hands is 0"));
  EXPECT_THAT(
      error_of([] { (void)segmenter()->segment(blank_frame(quarter_vga_camera()), std::nullopt, 17); }),
      HasSubstr("max_hands is 17"));
}

INSTANTIATE_TEST_SUITE_P(AllMethods, SegmenterTest,
                         ::testing::Values(Setup{"mean_shift", ""},
                                           Setup{"threshold_all", "method = \"threshold\"\npixels = \"all\""},
                                           Setup{"threshold_component",
                                                 "method = \"threshold\"\npixels = \"component\""},
                                           Setup{"forest", "method = \"forest\"\nmedian_px = 1"}),
                         [](const auto& setup) { return setup.param.name; });

TEST(SegmenterFactory, MakesEveryMethodByName) {
  for (const std::string_view name : segmenter_names()) {
    EXPECT_NE(create_segmenter(name, OptionTable::parse(model_line(name), "a.toml")), nullptr) << name;
    const std::string toml = "method = \"" + std::string(name) + "\"" + model_line(name);
    EXPECT_NE(create_segmenter(OptionTable::parse(toml, "a.toml")), nullptr) << name;
  }
}

TEST(SegmenterFactory, EveryMethodReadsTheKeysThatAreDocumented) {
  const auto keys_of = [](std::string_view name) {
    const OptionTable table = OptionTable::parse(model_line(name), "a.toml");
    (void)create_segmenter(name, table);
    std::vector<std::string> keys;
    std::istringstream lines(table.resolved_toml());
    for (std::string line; std::getline(lines, line);) keys.push_back(line.substr(0, line.find(' ')));
    return keys;
  };
  using ::testing::UnorderedElementsAre;
  EXPECT_THAT(keys_of("mean_shift"),
              UnorderedElementsAre("bandwidth_mm", "tolerance_mm", "max_iterations", "kernel_cutoff",
                                   "min_area_mm2", "max_area_mm2", "separation_mm", "max_candidates"));
  EXPECT_THAT(keys_of("threshold"), UnorderedElementsAre("interval", "range_mm", "tolerance_mm", "near_mm",
                                                         "far_mm", "pixels", "min_area_mm2"));
  EXPECT_THAT(keys_of("forest"), UnorderedElementsAre("model", "probability", "median_px", "closing_px",
                                                      "opening_px", "edge_step_mm", "min_area_mm2"));
  EXPECT_THAT(keys_of("detector"), UnorderedElementsAre("model", "min_score", "separation_mm", "margin_mm",
                                                        "min_area_mm2", "cut_surface"));
}

TEST(SegmenterFactory, NamesTheFaultAndTheKnown) {
  using ::testing::AllOf;
  const auto error_from = [](const char* toml) {
    return error_of([&] { (void)create_segmenter(OptionTable::parse(toml, "a.toml")); });
  };
  EXPECT_THAT(error_from("method = \"magic\""), AllOf(HasSubstr("a.toml"), HasSubstr("magic"),
                                                      HasSubstr("mean_shift"), HasSubstr("threshold")));
  EXPECT_THAT(error_from("bandwith_mm = 3"), AllOf(HasSubstr("a.toml"), HasSubstr("bandwith_mm")));
  EXPECT_THAT(error_from("bandwidth_mm = 0"), HasSubstr("bandwidth_mm"));
  EXPECT_THAT(error_from("bandwidth_mm = \"wide\""), HasSubstr("bandwidth_mm"));
  EXPECT_THAT(error_from("kernel_cutoff = 1.0"), HasSubstr("kernel_cutoff"));
  EXPECT_THAT(error_from("method = \"threshold\"\nrange_mm = -1"), HasSubstr("range_mm"));
  EXPECT_THAT(error_from("method = \"threshold\"\nbandwidth_mm = 10"), HasSubstr("bandwidth_mm"));
  EXPECT_THAT(error_from("method = \"threshold\"\nnear_mm = 700"), HasSubstr("near_mm < far_mm"));
  EXPECT_THAT(error_of([] { (void)create_segmenter("magic", OptionTable::parse("", "a.toml")); }),
              AllOf(HasSubstr("magic"), HasSubstr("mean_shift"), HasSubstr("threshold")));
}

}  // namespace
}  // namespace knuckle
