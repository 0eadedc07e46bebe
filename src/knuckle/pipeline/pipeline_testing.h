// SPDX-License-Identifier: Apache-2.0
// A plate as a frame, and parts of a pipeline that say what they see there; for tests only.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "knuckle/core/testing.h"
#include "knuckle/pipeline/pipeline.h"
#include "knuckle/segment/hand_region.h"

namespace knuckle::testing {

inline constexpr int kPlateFrameWidth = 40;
inline constexpr int kPlateFrameHeight = 30;

/// A plate at the left of the image; row 12 is nearer than the others.
inline Frame plate() {
  Frame frame;
  frame.camera = {
      .width = kPlateFrameWidth, .height = kPlateFrameHeight, .fx = 30.0, .fy = 30.0, .cx = 19.5, .cy = 14.5};
  frame.depth_mm = Image<float>(kPlateFrameWidth, kPlateFrameHeight);
  for (int row = 10; row < 20; ++row) {
    for (int column = 4; column < 14; ++column) frame.depth_mm(column, row) = row == 12 ? 490.0f : 500.0f;
  }
  return frame;
}

/// Calls all that is measured a hand.
class AllSegmenter final : public Segmenter {
 public:
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start,
                       int /*max_hands*/) const override {
    std::vector<std::int32_t> pixels;
    for (std::size_t i = 0; i < frame.depth_mm.size(); ++i) {
      if (is_measured(frame.depth_mm.data()[i])) pixels.push_back(static_cast<std::int32_t>(i));
    }
    if (pixels.empty()) return {{}, "nothing there"};
    HandRegion region = region_of_pixels(pixels, frame.depth_mm.width());
    region.centre = start.value_or(Point3(1.0, 2.0, 3.0));
    return {{region}, ""};
  }
};

/// Sees the palm in the upper left corner of every patch, at its mean depth.
class CornerEstimator final : public Estimator {
 public:
  Convention convention() const override { return {"corner1", kPalm}; }
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch& patch) const override {
    EXPECT_EQ(patch.pixels.width(), patches_.options().size_px);
    return {{{-1.0, -1.0, 0.0}}, {0.5f}};
  }

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchExtractor patches_{{.size_px = 10}};
};

/// Calls all that is measured a hand, and sees its palm in the corner.
inline PipelineParts corner_parts(const HandOptions& hand = {}) {
  return {HandFinder(std::make_unique<AllSegmenter>(), hand), std::make_unique<CornerEstimator>()};
}

/// Finds the given columns of the image, as many as are asked for.
class ColumnSegmenter final : public Segmenter {
 public:
  explicit ColumnSegmenter(std::vector<int> columns) : columns_(std::move(columns)) {}
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override {
    Segmentation found;
    for (const int column : columns_) {
      if (std::ssize(found.hands) == max_hands) break;
      const std::vector<std::int32_t> pixels{15 * frame.depth_mm.width() + column};
      HandRegion region = region_of_pixels(pixels, frame.depth_mm.width());
      region.centre = start.value_or(Point3(100.0 * (column - 4) - 250.0, 0.0, 500.0));
      region.score = 0.25;
      found.hands.push_back(region);
    }
    return found;
  }

 private:
  std::vector<int> columns_;
};

/// As sure as the column of the patch says: 0.4 in column 4.
class ColumnEstimator final : public Estimator {
 public:
  explicit ColumnEstimator(bool has_confidence = true) : has_confidence_(has_confidence) {}
  Convention convention() const override { return {"corner1", kPalm}; }
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch& patch) const override {
    ++calls;
    const double column = patch.geometry.to_image({0.0, 0.0, 0.0}).u;
    const std::vector<float> confidence{static_cast<float>(0.1 * std::round(column))};
    return {{{0.0, 0.0, 0.0}}, has_confidence_ ? confidence : std::vector<float>{}};
  }

  mutable int calls = 0;

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchExtractor patches_{{.size_px = 10}};
  bool has_confidence_;
};

/// Tries up to four of the columns; is sure of a hand from column 5 on, with a ColumnEstimator.
inline Pipeline column_pipeline(std::vector<int> columns, std::unique_ptr<Estimator> estimator) {
  const HandOptions hand{.candidates = 4, .sure_confidence = 0.5};
  return Pipeline(
      {HandFinder(std::make_unique<ColumnSegmenter>(std::move(columns)), hand), std::move(estimator)});
}

/// The left edges of the hands' boxes [px].
inline std::vector<int> columns_of(const FrameEstimate& found) {
  std::vector<int> columns;
  for (const HandEstimate& hand : found.hands) columns.push_back(hand.region.box.x);
  return columns;
}

/// Looks twice at a cube; the first time it sees the palm at pixel (12, 16), 495 mm away, wherever it looks.
class MovingEstimator final : public Estimator {
 public:
  Convention convention() const override { return {"corner1", kPalm}; }
  const PatchExtractor& patches() const override { return patches_; }
  int passes() const override { return 2; }
  PatchPose estimate(const HandPatch& patch) const override {
    return {{patch.geometry.to_patch({12.0, 16.0, 495.0})}, {}};
  }

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchExtractor patches_{{.size_px = 10, .mode = "cube", .cube_mm = 100.0}};
};

/// Finds these columns, and moves from each to the same palm.
inline PipelineParts moving_parts(std::vector<int> columns, int max_hands) {
  return {HandFinder(std::make_unique<ColumnSegmenter>(std::move(columns)), {.max_hands = max_hands}),
          std::make_unique<MovingEstimator>()};
}

}  // namespace knuckle::testing
