// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/segmentation_metrics.h"

#include <algorithm>

#include "knuckle/core/error.h"
#include "knuckle/core/statistics.h"

namespace knuckle {
namespace {

constexpr int kCurveSteps = 100;

}  // namespace

Rectangle rectangle_of(const Box& box) {
  if (box.empty()) return {};
  return {box.x - 0.5, box.y - 0.5, box.right() - 0.5, box.bottom() - 0.5};
}

std::optional<Rectangle> rectangle_around(const HandPose& pose) {
  std::optional<Rectangle> around;
  for (const ImagePoint& joint : pose.joints) {
    if (joint.is_missing()) continue;
    if (!around) around = Rectangle{joint.u, joint.v, joint.u, joint.v};
    around->left = std::min(around->left, joint.u);
    around->top = std::min(around->top, joint.v);
    around->right = std::max(around->right, joint.u);
    around->bottom = std::max(around->bottom, joint.v);
  }
  return around;
}

double intersection_over_union(const Rectangle& a, const Rectangle& b) {
  const Rectangle common{std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right),
                         std::min(a.bottom, b.bottom)};
  const double united = a.area() + b.area() - common.area();
  return united > 0.0 ? common.area() / united : 0.0;
}

double intersection_over_union(const Box& a, const Box& b) {
  return intersection_over_union(rectangle_of(a), rectangle_of(b));
}

double mask_intersection_over_union(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  if (a.width() != b.width() || a.height() != b.height()) {
    fail("masks of different sizes: {}x{} and {}x{}", a.width(), a.height(), b.width(), b.height());
  }
  std::int64_t in_both = 0;
  std::int64_t in_either = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const bool in_a = a.pixels()[i] != 0;
    const bool in_b = b.pixels()[i] != 0;
    in_both += in_a && in_b ? 1 : 0;
    in_either += in_a || in_b ? 1 : 0;
  }
  return in_either == 0 ? 1.0 : static_cast<double>(in_both) / static_cast<double>(in_either);
}

SegmentationScore score_overlaps(const std::string& name, std::span<const double> overlaps,
                                 std::int64_t missing) {
  if (overlaps.empty()) fail("{}: no frame with a known hand to score against", name);
  SegmentationScore result;
  result.name = name;
  result.frames = static_cast<std::int64_t>(overlaps.size());
  result.missing = missing;
  result.mean_iou = mean(overlaps);
  result.median_iou = median({overlaps.begin(), overlaps.end()});
  for (int step = 0; step <= kCurveSteps; ++step) {
    const double threshold = static_cast<double>(step) / kCurveSteps;
    const auto above = std::ranges::count_if(overlaps, [&](double overlap) { return overlap > threshold; });
    result.threshold.push_back(threshold);
    result.fraction_above.push_back(static_cast<double>(above) / static_cast<double>(overlaps.size()));
  }
  return result;
}

SegmentationScore score_boxes(const std::string& name, std::span<const Box> boxes,
                              std::span<const HandPose> truth) {
  if (boxes.size() != truth.size()) {
    fail("{}: {} boxes, but the truth has {} frames", name, boxes.size(), truth.size());
  }
  std::vector<double> overlaps;
  std::int64_t missing = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const std::optional<Rectangle> expected = rectangle_around(truth[i]);
    if (!expected) continue;
    missing += boxes[i].empty() ? 1 : 0;
    overlaps.push_back(intersection_over_union(rectangle_of(boxes[i]), *expected));
  }
  return score_overlaps(name, overlaps, missing);
}

}  // namespace knuckle
