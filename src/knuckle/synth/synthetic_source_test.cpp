// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/synthetic_source.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/testing_body.h"
#include "knuckle/synth/sensor/sensor_presets.h"

namespace knuckle {
namespace {

Manifest small_manifest() {
  Manifest manifest;
  manifest.path = "test.toml";
  manifest.seed = 11;
  manifest.frames = 24;
  manifest.body.people = 3;
  manifest.camera.camera = {.width = 80, .height = 60, .fx = 56, .fy = 56, .cx = 39.5, .cy = 29.5};
  manifest.placement.nearest_mm = 300;
  manifest.placement.farthest_mm = 400;
  return manifest;
}

std::unique_ptr<FrameSource> box_hand_source(const Manifest& manifest) {
  return create_synthetic(manifest, std::make_shared<const Body>(testing::box_hand_body()));
}

void expect_equal(const Frame& a, const Frame& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.camera, b.camera);
  EXPECT_EQ(a.depth_mm, b.depth_mm);
  EXPECT_EQ(a.infrared, b.infrared);
  EXPECT_EQ(a.mask, b.mask);
  for (int k = 0; k < kSupersetSize; ++k) {
    EXPECT_EQ(a.truth->joints[k].u, b.truth->joints[k].u);
    EXPECT_EQ(a.truth->joints[k].v, b.truth->joints[k].v);
    EXPECT_EQ(a.truth->joints[k].depth_mm, b.truth->joints[k].depth_mm);
  }
}

class SyntheticSourceTest : public ::testing::TestWithParam<std::string> {
 protected:
  Manifest manifest() const {
    Manifest manifest = small_manifest();
    manifest.motion.motion = GetParam();
    return manifest;
  }
};

TEST_P(SyntheticSourceTest, AFrameIsAFunctionOfManifestAndIndex) {
  const Manifest wanted = manifest();
  std::vector<Frame> forwards;
  const auto source = box_hand_source(wanted);
  for (int i = 0; i < wanted.frames; ++i) forwards.push_back(source->read(i));
  const auto other = box_hand_source(wanted);  // nobody cached yet
  for (int i = wanted.frames - 1; i >= 0; --i) expect_equal(other->read(i), forwards[i]);
}

TEST_P(SyntheticSourceTest, OneAndTwoThreadsGiveTheSameBits) {
  const Manifest wanted = manifest();
  const auto read_all = [&](int threads) {
    set_thread_count(threads);
    const auto source = box_hand_source(wanted);
    std::vector<Frame> frames(wanted.frames);
    parallel_for(wanted.frames, [&](std::int64_t i) { frames[i] = source->read(i); });
    set_thread_count(0);
    return frames;
  };
  const auto one = read_all(1);
  const auto two = read_all(2);
  for (int i = 0; i < wanted.frames; ++i) expect_equal(one[i], two[i]);
}

TEST_P(SyntheticSourceTest, SoDoesEverySensor) {
  for (const std::string_view name : sensor_preset_names()) {
    Manifest wanted = manifest();
    wanted.frames = 4;
    wanted.sensor = sensor_preset(name).sensor;
    set_thread_count(1);
    const auto one = box_hand_source(wanted);
    std::vector<Frame> frames;
    for (int i = 0; i < wanted.frames; ++i) frames.push_back(one->read(i));
    set_thread_count(2);
    const auto two = box_hand_source(wanted);
    parallel_for(wanted.frames, [&](std::int64_t i) { expect_equal(two->read(3 - i), frames[3 - i]); });
    set_thread_count(0);
    EXPECT_EQ(frames[0].infrared.empty(), name == "paper") << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, SyntheticSourceTest, ::testing::Values("none", "smooth"));

TEST(SyntheticSource, TruthAndMaskFitThePicture) {
  Manifest manifest = small_manifest();
  manifest.sensor.noise.sigma_mm = 0;
  manifest.sensor.quantisation_mm = 0;
  manifest.placement.border_share = 0;
  const auto source = box_hand_source(manifest);
  EXPECT_EQ(source->size(), 24);
  EXPECT_EQ(source->convention(), superset_convention());
  for (int i = 0; i < 24; ++i) {
    const Frame frame = source->read(i);
    int hand = 0;
    for (std::size_t p = 0; p < frame.mask.size(); ++p) {
      if (frame.mask.data()[p] == 0) continue;
      ++hand;
      EXPECT_GT(frame.depth_mm.data()[p], 0.0f);
    }
    EXPECT_GT(hand, 60);
    for (const ImagePoint& joint : frame.truth->joints) {
      EXPECT_TRUE(frame.depth_mm.contains(static_cast<int>(std::lround(joint.u)),
                                          static_cast<int>(std::lround(joint.v))));
    }
    // The palm's centre lies inside the hand: the camera sees its skin, or a finger before it.
    const ImagePoint& palm = frame.truth->joints[static_cast<std::size_t>(Landmark::palm)];
    const int column = static_cast<int>(std::lround(palm.u));
    const int row = static_cast<int>(std::lround(palm.v));
    EXPECT_EQ(frame.mask(column, row), 1);
    EXPECT_LT(frame.depth_mm(column, row), palm.depth_mm);
    EXPECT_GT(frame.depth_mm(column, row), palm.depth_mm - 140.0);
  }
}

TEST(SyntheticSource, FramesDiffer) {
  const auto source = box_hand_source(small_manifest());
  EXPECT_NE(source->read(0).depth_mm, source->read(1).depth_mm);
  Manifest other = small_manifest();
  other.seed = 12;
  EXPECT_NE(source->read(0).depth_mm, box_hand_source(other)->read(0).depth_mm);
}

TEST(SyntheticSource, SmoothMotionIsSmooth) {
  Manifest manifest = small_manifest();
  manifest.frames = 60;
  manifest.motion.motion = "smooth";
  manifest.motion.frames_a_pose = 12;
  const auto source = box_hand_source(manifest);
  const Frame first = source->read(0);
  double farthest = 0.0;
  Frame last = first;
  for (int i = 1; i < manifest.frames; ++i) {
    const Frame frame = source->read(i);
    for (int k = 0; k < kSupersetSize; ++k) {
      const double step = std::hypot(frame.truth->joints[k].u - last.truth->joints[k].u,
                                     frame.truth->joints[k].v - last.truth->joints[k].v);
      EXPECT_LT(step, 8.0) << "frame " << i;
      farthest = std::max(farthest, std::hypot(frame.truth->joints[k].u - first.truth->joints[k].u,
                                               frame.truth->joints[k].v - first.truth->joints[k].v));
    }
    last = frame;
  }
  EXPECT_GT(farthest, 8.0);
}

TEST(SyntheticSource, FramesFollowOneAnotherAtTheRateOfTheManifest) {
  Manifest manifest = small_manifest();
  manifest.rate_hz = 25.0;
  const auto still = box_hand_source(manifest);
  EXPECT_EQ(still->read(0).time_s, 0.0);
  EXPECT_EQ(still->read(3).time_s, 3.0 / 25.0);
  EXPECT_EQ(still->read(3).sequence, 3) << "every frame is another scene";
  manifest.motion.motion = "smooth";
  const auto moving = box_hand_source(manifest);
  EXPECT_EQ(moving->read(3).time_s, 3.0 / 25.0);
  EXPECT_EQ(moving->read(3).sequence, 0);
}

TEST(SyntheticSource, EachFrameHasNoiseOfItsOwn) {
  Manifest manifest = small_manifest();
  manifest.frames = 8;
  manifest.sensor.quantisation_mm = 0;
  manifest.sensor.noise.sigma_mm = 2.0;
  Manifest exact = manifest;
  exact.sensor.noise.sigma_mm = 0.0;
  const auto noisy = box_hand_source(manifest);
  const auto clean = box_hand_source(exact);
  const auto noise_of = [&](std::int64_t index) {
    Image<float> noise = noisy->read(index).depth_mm;
    const Image<float> depth = clean->read(index).depth_mm;
    for (std::size_t i = 0; i < noise.size(); ++i)
      noise.data()[i] =
          noise.data()[i] > 0.0f && depth.data()[i] > 0.0f ? noise.data()[i] - depth.data()[i] : 0.0f;
    return noise;
  };
  double products = 0.0;
  double squares = 0.0;
  for (std::int64_t frame = 0; frame + 1 < manifest.frames; ++frame) {
    const Image<float> one = noise_of(frame);
    const Image<float> next = noise_of(frame + 1);
    for (std::size_t i = 0; i < one.size(); ++i) {
      if (one.data()[i] == 0.0f || next.data()[i] == 0.0f) continue;
      products += double{one.data()[i]} * next.data()[i];
      squares += 0.5 * (double{one.data()[i]} * one.data()[i] + double{next.data()[i]} * next.data()[i]);
    }
  }
  ASSERT_GT(squares, 1000.0);
  EXPECT_LT(std::abs(products / squares), 0.2) << "the noise of neighbouring frames is the same";
}

TEST(SyntheticSource, FocalLengthsSpreadAsAskedFor) {
  Manifest manifest = small_manifest();
  manifest.camera.focal_spread = 0.2;
  const auto source = box_hand_source(manifest);
  double low = 1e9;
  double high = 0.0;
  for (int i = 0; i < 24; ++i) {
    low = std::min(low, source->read(i).camera.fx);
    high = std::max(high, source->read(i).camera.fx);
    EXPECT_EQ(source->read(i).camera.fy, source->read(i).camera.fx);  // as in the manifest
  }
  EXPECT_GE(low, 56 * 0.8);
  EXPECT_LE(high, 56 * 1.2);
  EXPECT_GT(high - low, 56 * 0.2);
}

/// A camera that is not its own mirror image, without noise.
Manifest one_sided_manifest(const std::string& side) {
  Manifest manifest = small_manifest();
  manifest.camera.camera.cx = 33;
  manifest.camera.camera.distortion[3] = 0.01;
  manifest.sensor.noise.sigma_mm = 0;
  manifest.sensor.quantisation_mm = 0;
  manifest.body.side = side;
  return manifest;
}

TEST(SyntheticSource, ALeftHandIsTheMirrorImageOfARightOne) {
  const auto left = box_hand_source(one_sided_manifest("left"));
  Manifest mirror = one_sided_manifest("right");
  mirror.camera.camera = mirrored(mirror.camera.camera);
  const auto right = box_hand_source(mirror);
  for (int i = 0; i < mirror.frames; ++i) {
    const Frame frame = left->read(i);
    EXPECT_EQ(frame.side, HandSide::left);
    EXPECT_EQ(frame.camera, one_sided_manifest("left").camera.camera);
    const Frame reflected = mirrored(right->read(i));
    EXPECT_EQ(reflected.side, HandSide::left);
    expect_equal(frame, reflected);
  }
}

TEST(SyntheticSource, BothSidesOccurAndEachIsWhatItsSideAloneShows) {
  const auto both = box_hand_source(one_sided_manifest("both"));
  const auto left = box_hand_source(one_sided_manifest("left"));
  const auto right = box_hand_source(one_sided_manifest("right"));
  int left_hands = 0;
  for (int i = 0; i < both->size(); ++i) {
    const Frame frame = both->read(i);
    ASSERT_TRUE(frame.side.has_value());
    const bool is_left = *frame.side == HandSide::left;
    left_hands += is_left ? 1 : 0;
    expect_equal(frame, (is_left ? left : right)->read(i));
  }
  EXPECT_GT(left_hands, 4);
  EXPECT_LT(left_hands, 20);
}

TEST(SyntheticSource, AFrameThatIsNotThereIsRefused) {
  const auto source = box_hand_source(small_manifest());
  EXPECT_THAT(testing::error_of([&] { source->read(24); }), ::testing::HasSubstr("test.toml: frame 24"));
  EXPECT_THAT(testing::error_of([&] { source->read(-1); }), ::testing::HasSubstr("frame -1"));
}

}  // namespace
}  // namespace knuckle
