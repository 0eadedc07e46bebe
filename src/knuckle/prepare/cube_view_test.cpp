// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/cube_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knuckle/camera/projection.h"
#include "knuckle/core/testing.h"
#include "knuckle/net/net_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::kTestCentre;
using testing::kTestCropPx;
using testing::kTestCube;
using testing::kTestJoints;

constexpr int kPatchSize = 32;

class CubeViewTest : public ::testing::Test {
 protected:
  std::vector<float> pixels(const CubeView& view, const PixelFaults& faults = {},
                            std::uint64_t seed = 1) const {
    std::vector<float> result(kPatchSize * kPatchSize);
    Random random(seed);
    viewer_.view_pixels(samples_.sample(0), view, faults, random, result);
    return result;
  }
  std::vector<float> joints(const CubeView& view) const {
    std::vector<float> result(kTestJoints * 3);
    viewer_.view_joints(samples_.sample(0), view, result);
    return result;
  }
  std::int64_t hand_pixels(const std::vector<float>& view) const {
    return std::ranges::count_if(view, [](float d) { return d < kCubeBackground; });
  }

  CubeSamples samples_ = testing::made_up_samples(3);
  CubeViewer viewer_{samples_};
};

/// The pixel at a joint's place; background where that is outside of the patch.
float pixel_at(const std::vector<float>& pixels, const float* joint) {
  const int column = static_cast<int>(std::lround(0.5 * (kPatchSize - 1) * (joint[0] + 1.0)));
  const int row = static_cast<int>(std::lround(0.5 * (kPatchSize - 1) * (joint[1] + 1.0)));
  if (column < 0 || row < 0 || column >= kPatchSize || row >= kPatchSize) return kCubeBackground;
  return pixels[static_cast<std::size_t>(row) * kPatchSize + column];
}

TEST_F(CubeViewTest, TheIdentityShowsTheMiddleOfTheCropExactly) {
  const std::vector<float> seen = pixels({});
  const CubeSample sample = samples_.sample(0);
  for (int row = 0; row < kPatchSize; ++row) {
    for (int column = 0; column < kPatchSize; ++column) {
      const std::uint8_t code = sample.codes[static_cast<std::size_t>(row + 8) * kTestCropPx + column + 8];
      const float expected =
          code == CubeSamples::kBackgroundCode ? kCubeBackground : 1.5f * CubeSamples::depth_of_code(code);
      EXPECT_EQ(seen[static_cast<std::size_t>(row) * kPatchSize + column], expected) << column << ", " << row;
    }
  }
  const std::vector<float> at = joints({});
  for (int i = 0; i < kTestJoints; ++i) {
    EXPECT_FLOAT_EQ(at[3 * i], sample.joints[3 * i] / 15.5f);
    EXPECT_FLOAT_EQ(at[3 * i + 2], sample.joints[3 * i + 2] * 1.5f);
  }
}

TEST_F(CubeViewTest, JointsMoveAsPixelsDoInAnyView) {
  AugmentationOptions options;
  options.noise_mm = options.missing_share = options.erased_share = 0.0;
  int checked = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const CubeView view = random_view(samples_.sample(0), samples_, options, random).view;
    const std::vector<float> seen = pixels(view);
    const std::vector<float> at = joints(view);
    const double step = 0.5 / 127.0 * 1.5 / view.scale;  // of the stored depths
    for (std::size_t i = 0; i < at.size(); i += 3) {
      const bool is_inside =
          std::abs(at[i]) < 1.0f && std::abs(at[i + 1]) < 1.0f && std::abs(at[i + 2]) < 0.98f;
      if (!is_inside) continue;
      EXPECT_NEAR(pixel_at(seen, &at[i]), at[i + 2], step + 1e-5) << "seed " << seed << ", joint " << i / 3;
      ++checked;
    }
  }
  EXPECT_GT(checked, 2000);
}

TEST_F(CubeViewTest, AQuarterTurnIsAQuarterTurn) {
  const std::vector<float> upright = pixels({});
  const std::vector<float> turned = pixels({.rotation = 0.5 * std::numbers::pi});
  for (int row = 0; row < kPatchSize; ++row) {
    for (int column = 0; column < kPatchSize; ++column) {
      EXPECT_EQ(turned[static_cast<std::size_t>(row) * kPatchSize + column],
                upright[static_cast<std::size_t>(column) * kPatchSize + (kPatchSize - 1 - row)]);
    }
  }
}

TEST_F(CubeViewTest, AShiftedViewLiesWhereExtractCubeCutsAroundTheShiftedCentre) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 500.0;
  camera.cx = 320.0;
  camera.cy = 240.0;
  const Projection projection(camera);
  const Point3 shifted = kTestCentre + Point3(12.0, -7.0, 20.0);
  const PatchGeometry crop = cube_geometry(camera, projection.to_image(kTestCentre), samples_.crop());
  const PatchGeometry patch = cube_geometry(camera, projection.to_image(shifted), kTestCube);
  CubeView view;
  view.centre_u = (patch.centre_u - crop.centre_u) / crop.image_px_per_patch_px;
  view.centre_v = (patch.centre_v - crop.centre_v) / crop.image_px_per_patch_px;
  view.centre_d = (shifted.z() - kTestCentre.z()) / (0.5 * samples_.crop().side_mm);
  const testing::MadeUpHand hand = testing::made_up_hand(0);
  const std::vector<float> at = joints(view);
  for (int i = 0; i < kTestJoints; ++i) {
    const ImagePoint image = crop.to_image(hand.joints[static_cast<std::size_t>(i)]);
    const PatchPoint expected = patch.to_patch(image);
    EXPECT_NEAR(at[3 * i], expected.u, 1e-5);
    EXPECT_NEAR(at[3 * i + 1], expected.v, 1e-5);
    EXPECT_NEAR(at[3 * i + 2], expected.d, 1e-5);
    const Point3 found =
        viewer_.in_camera(samples_.sample(0), view, std::span<const float, 3>(&at[3 * i], 3));
    EXPECT_LT((found - projection.to_camera(image)).norm(), 1e-2);
  }
}

TEST_F(CubeViewTest, AJointStaysWhereItIsWhateverTheView) {
  const std::vector<float> upright = joints({});
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const CubeView view = random_view(samples_.sample(0), samples_, {}, random).view;
    const std::vector<float> at = joints(view);
    for (std::size_t i = 0; i < at.size(); i += 3) {
      const CubeSample sample = samples_.sample(0);
      const Point3 found = viewer_.in_camera(sample, view, std::span<const float, 3>(&at[i], 3));
      const Point3 expected = viewer_.in_camera(sample, {}, std::span<const float, 3>(&upright[i], 3));
      EXPECT_LT((found - expected).norm(), 1e-2);
    }
  }
}

TEST_F(CubeViewTest, TheSecondLookIsAroundTheMeanOfTheJoints) {
  const CubeSample sample = samples_.sample(0);
  const CubeView start{.centre_u = 2.0, .centre_v = -1.0, .centre_d = 0.1, .rotation = 0.3, .scale = 1.1};
  for (const CubeView& view :
       {viewer_.around_true_joints(sample), viewer_.around_mean_joint(sample, start, joints(start))}) {
    const std::vector<float> at = joints(view);
    double sum[3] = {};
    for (std::size_t i = 0; i < at.size(); ++i) sum[i % 3] += at[i] / kTestJoints;
    for (const double mean : sum) EXPECT_NEAR(mean, 0.0, 1e-5);
  }
}

TEST_F(CubeViewTest, JointsThatAreNotKnownStayUnknownAndDoNotMoveTheMean) {
  CubeSamples samples(1, 3, kTestCube, kTestCropPx);
  const std::vector<PatchPoint> joints = {{0.1, 0.0, 0.2}, {}, {0.3, 0.0, 0.4}};
  samples.set(0, testing::made_up_hand(0).crop, joints, kTestCentre);
  samples.finish();
  const CubeViewer viewer(samples);
  const CubeView view = viewer.around_true_joints(samples.sample(0));
  EXPECT_NEAR(view.centre_u, 0.2 * 23.5, 1e-5);
  EXPECT_NEAR(view.centre_d, 0.3, 1e-6);
  std::vector<float> at(9);
  viewer.view_joints(samples.sample(0), view, at);
  EXPECT_TRUE(std::isnan(at[3]) && std::isnan(at[4]) && std::isnan(at[5]));
  EXPECT_TRUE(std::isfinite(at[0]) && std::isfinite(at[8]));
}

TEST_F(CubeViewTest, FaultsTouchThePixelsOfTheHandAlone) {
  const std::vector<float> whole = pixels({});
  const std::vector<float> noisy = pixels({}, {.noise_mm = 2.0});
  const std::vector<float> holed = pixels({}, {.missing_share = 0.5});
  const std::vector<float> erased = pixels({}, {.erased_u = 8, .erased_v = 8, .erased_radius = 6});
  double squares = 0.0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (whole[i] == kCubeBackground) {
      EXPECT_TRUE(noisy[i] == kCubeBackground && holed[i] == kCubeBackground && erased[i] == kCubeBackground);
      continue;
    }
    squares += std::pow((noisy[i] - whole[i]) * 0.5 * kTestCube.side_mm, 2);
    EXPECT_TRUE(holed[i] == kCubeBackground || holed[i] == whole[i]);
    const bool is_erased = std::hypot(i % kPatchSize - 8.0, i / kPatchSize - 8.0) < 6.0;
    EXPECT_EQ(erased[i], is_erased ? kCubeBackground : whole[i]);
  }
  const auto count = static_cast<double>(hand_pixels(whole));
  EXPECT_NEAR(std::sqrt(squares / count), 2.0, 0.3);
  EXPECT_NEAR(static_cast<double>(hand_pixels(holed)) / count, 0.5, 0.1);
}

TEST_F(CubeViewTest, NoiseHasMeanZeroAndTheDeviationAskedFor) {
  constexpr int kSeeds = 60;
  constexpr double kNoiseMm = 2.0;
  const std::vector<float> whole = pixels({});
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const std::vector<float> noisy = pixels({}, {.noise_mm = kNoiseMm}, static_cast<std::uint64_t>(seed));
    for (std::size_t i = 0; i < whole.size(); ++i) {
      if (noisy[i] == kCubeBackground) continue;
      const double deviations = (noisy[i] - whole[i]) * 0.5 * kTestCube.side_mm / kNoiseMm;
      sum += deviations;
      squares += deviations * deviations;
      ++count;
    }
  }
  ASSERT_GT(count, 5000.0);
  EXPECT_NEAR(sum / count, 0.0, 4.0 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(squares / count), 1.0, 4.0 / std::sqrt(2.0 * count));
}

TEST_F(CubeViewTest, WhatIsErasedLiesWhereItSays) {
  const std::vector<float> whole = pixels({});
  const std::vector<float> erased = pixels({}, {.erased_u = 20, .erased_v = 9, .erased_radius = 5});
  int changed = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const bool is_erased = std::hypot(i % kPatchSize - 20.0, i / kPatchSize - 9.0) < 5.0;
    EXPECT_EQ(erased[i], is_erased ? kCubeBackground : whole[i]) << i % kPatchSize << ", " << i / kPatchSize;
    changed += erased[i] != whole[i] ? 1 : 0;
  }
  EXPECT_GT(changed, 10);
}

TEST_F(CubeViewTest, TheSameSeedGivesTheSameView) {
  const PixelFaults faults{.noise_mm = 3.0, .missing_share = 0.2};
  EXPECT_EQ(pixels({}, faults, 7), pixels({}, faults, 7));
  EXPECT_NE(pixels({}, faults, 7), pixels({}, faults, 8));
}

TEST(AugmentationOptions, RandomViewsKeepToTheirRangesAndNoneIsTheIdentity) {
  const CubeSamples samples = testing::made_up_samples(1);
  double largest = 0.0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(seed);
    const RandomView seen = random_view(samples.sample(0), samples, {.rotation_deg = 30.0}, random);
    EXPECT_LE(std::abs(seen.view.rotation), std::numbers::pi / 6.0);
    EXPECT_LE(std::abs(seen.view.scale - 1.0), 0.15);
    EXPECT_LE(seen.faults.noise_mm, 2.0);
    largest = std::max(largest, std::abs(seen.view.rotation));
    const RandomView plain = random_view(samples.sample(0), samples, testing::no_augmentation(), random);
    EXPECT_EQ(plain.view.centre_u, 0.0);
    EXPECT_EQ(plain.view.centre_d, 0.0);
    EXPECT_EQ(plain.view.rotation, 0.0);
    EXPECT_EQ(plain.view.scale, 1.0);
    EXPECT_EQ(plain.faults.erased_radius, 0.0);
  }
  EXPECT_GT(largest, 0.8 * std::numbers::pi / 6.0);
}

/// Means and deviations of 4,000 drawn numbers lie within four of their own standard errors.
struct Drawn {
  double sum = 0.0, squares = 0.0;
  void add(double x) {
    sum += x;
    squares += x * x;
  }
  void expect(double mean, double deviation) const {
    constexpr double kCount = 4000.0;
    EXPECT_NEAR(sum / kCount, mean, 4.0 * deviation / std::sqrt(kCount));
    EXPECT_NEAR(std::sqrt(squares / kCount - sum / kCount * sum / kCount), deviation, 0.05 * deviation);
  }
};

TEST(AugmentationOptions, EachNumberIsDrawnOfItsOwn) {
  const CubeSamples samples = testing::made_up_samples(1);
  const AugmentationOptions options{.rotation_deg = 90.0,
                                    .shift_mm = 8.0,
                                    .recentred_share = 0.0,
                                    .scale_spread = 0.2,
                                    .noise_mm = 3.0,
                                    .missing_share = 0.4,
                                    .erased_share = 1.0,
                                    .erased_mm = 30.0};
  Drawn u, v, d, uv, rotation, scale, noise, missing, erased_u, erased_v, erased_uv, radius;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    Random random(seed, 9);
    const auto [view, faults] = random_view(samples.sample(0), samples, options, random);
    u.add(view.centre_u);
    v.add(view.centre_v);
    uv.add(view.centre_u + view.centre_v);
    d.add(view.centre_d);
    rotation.add(view.rotation);
    scale.add(view.scale);
    noise.add(faults.noise_mm);
    missing.add(faults.missing_share);
    erased_u.add(faults.erased_u);
    erased_v.add(faults.erased_v);
    erased_uv.add(faults.erased_u - faults.erased_v);
    radius.add(faults.erased_radius);
  }
  // Patches of 32 px and 200 mm: 0.16 px per mm; the crop's cube has 300 mm. Uniform: width / sqrt(12).
  const double uniform = 1.0 / std::sqrt(12.0);
  u.expect(0.0, 1.28);
  v.expect(0.0, 1.28);
  uv.expect(0.0, 1.28 * std::numbers::sqrt2);
  d.expect(0.0, 8.0 / 150.0);
  rotation.expect(0.0, std::numbers::pi * uniform);
  scale.expect(1.0, 0.4 * uniform);
  noise.expect(1.5, 3.0 * uniform);
  missing.expect(0.2, 0.4 * uniform);
  erased_u.expect(16.0, 32.0 * uniform);
  erased_v.expect(16.0, 32.0 * uniform);
  erased_uv.expect(0.0, 32.0 * uniform * std::numbers::sqrt2);
  radius.expect(2.4, 4.8 * uniform);
}

TEST(AugmentationOptions, AreChecked) {
  AugmentationOptions options;
  options.scale_spread = 0.6;
  EXPECT_THAT(error_of([&] { check_options(options, "augmentation"); }), HasSubstr("scale_spread"));
  options = {};
  options.missing_share = kNaN;
  EXPECT_THAT(error_of([&] { check_options(options, "augmentation"); }), HasSubstr("missing_share"));
}

}  // namespace
}  // namespace knuckle
