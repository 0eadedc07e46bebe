// SPDX-License-Identifier: Apache-2.0
// Helpers of this module's tests only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "knuckle/core/frame.h"
#include "knuckle/core/random.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {

inline Camera small_camera() {
  return {CameraModel::projective, 24, 18, 30.5, 31.25, 11.7, 8.4, {}};
}

/// The same with all kinds of distortion.
inline Camera distorted_camera() {
  Camera camera = small_camera();
  camera.distortion = {0.01, -0.02, 0.003, 0.0004, 0.1, 0.0, 0.0, 0.05};
  return camera;
}

/// A frame of noise around 500 mm with holes, infrared, a mask, and a truth that misses its second joint.
inline Frame noise_frame(const Camera& camera, const Convention& convention, std::uint64_t seed) {
  Random random(seed);
  Frame frame;
  frame.camera = camera;
  frame.depth_mm = Image<float>(camera.width, camera.height);
  frame.infrared = Image<std::uint16_t>(camera.width, camera.height);
  frame.mask = Image<std::uint8_t>(camera.width, camera.height);
  for (std::size_t i = 0; i < frame.depth_mm.size(); ++i) {
    frame.depth_mm.data()[i] = random.below(5) == 0 ? 0.0f : static_cast<float>(random.uniform(400, 900));
    frame.infrared.data()[i] = static_cast<std::uint16_t>(300 + random.below(60000));
    frame.mask.data()[i] = static_cast<std::uint8_t>(random.below(2));
  }
  frame.truth = HandPose::missing(convention);
  for (ImagePoint& joint : frame.truth->joints)
    joint = {random.uniform(0, camera.width), random.uniform(0, camera.height), random.uniform(400, 900)};
  frame.truth->joints[1] = {};
  return frame;
}

inline void expect_near(const HandPose& actual, const HandPose& expected, double tolerance_px,
                        double tolerance_mm) {
  ASSERT_EQ(actual.convention.name, expected.convention.name);
  for (std::size_t i = 0; i < expected.joints.size(); ++i) {
    ASSERT_EQ(actual.joints[i].is_missing(), expected.joints[i].is_missing()) << "joint " << i;
    if (expected.joints[i].is_missing()) continue;
    EXPECT_NEAR(actual.joints[i].u, expected.joints[i].u, tolerance_px) << "joint " << i;
    EXPECT_NEAR(actual.joints[i].v, expected.joints[i].v, tolerance_px) << "joint " << i;
    EXPECT_NEAR(actual.joints[i].depth_mm, expected.joints[i].depth_mm, tolerance_mm) << "joint " << i;
  }
}

inline void expect_near(const Image<float>& actual, const Image<float>& expected, double tolerance) {
  ASSERT_EQ(actual.width(), expected.width());
  ASSERT_EQ(actual.height(), expected.height());
  for (std::size_t i = 0; i < expected.size(); ++i)
    ASSERT_NEAR(actual.data()[i], expected.data()[i], tolerance) << "pixel " << i;
}

inline void expect_near(const Camera& actual, const Camera& expected) {
  EXPECT_EQ(actual.model, expected.model);
  EXPECT_EQ(actual.width, expected.width);
  EXPECT_EQ(actual.height, expected.height);
  EXPECT_DOUBLE_EQ(actual.fx, expected.fx);
  EXPECT_DOUBLE_EQ(actual.fy, expected.fy);
  EXPECT_NEAR(actual.cx, expected.cx, 1e-12);
  EXPECT_NEAR(actual.cy, expected.cy, 1e-12);
  EXPECT_EQ(actual.distortion, expected.distortion);
}

/// That `read_label` says what `read` says, in every frame.
inline void expect_labels_like_frames(const FrameSource& source) {
  for (std::int64_t i = 0; i < source.size(); ++i) {
    const Frame frame = source.read(i);
    const FrameLabel label = source.read_label(i);
    EXPECT_EQ(label.camera, frame.camera) << "frame " << i;
    EXPECT_EQ(label.time_s, frame.time_s) << "frame " << i;
    EXPECT_EQ(label.sequence, frame.sequence) << "frame " << i;
    EXPECT_EQ(label.name, frame.name) << "frame " << i;
    ASSERT_EQ(label.truth.has_value(), frame.truth.has_value()) << "frame " << i;
    if (frame.truth) expect_near(*label.truth, *frame.truth, 0.0, 0.0);
  }
}

inline void put_file(const std::filesystem::path& path, std::string_view content) {
  make_folder(path.parent_path());
  std::ofstream(path, std::ios::binary) << content;
}

/// Keeps the first `bytes` of a file.
inline void cut_file(const std::filesystem::path& path, std::uintmax_t bytes) {
  std::filesystem::resize_file(path, bytes);
}

/// Text of `count` numbers, first, first + 1, ...
inline std::string numbers_text(int count, double first, char separator = ' ') {
  std::string text;
  for (int i = 0; i < count; ++i)
    text += fmt::format("{}{}", i == 0 ? "" : std::string(1, separator), first + i);
  return text;
}

}  // namespace knuckle::testing
