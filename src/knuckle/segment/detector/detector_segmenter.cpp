// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detector_segmenter.h"

#include <algorithm>
#include <functional>

#include <fmt/format.h>

#include "knuckle/segment/hand_region.h"
#include "knuckle/segment/point_cloud.h"

namespace knuckle {
namespace {

constexpr double kStartReachMm = 80.0;
constexpr double kHalfOpenExtentMm = 90.0;
constexpr double kScoreOfGivenStart = 0.01;

/// The hand that a given start means; the others are left in `hands`.
DetectedHand hand_at_start(const Point3& start, std::vector<DetectedHand>& hands) {
  const auto near = std::ranges::find_if(
      hands, [&](const DetectedHand& hand) { return (hand.centre - start).norm() <= kStartReachMm; });
  if (near == hands.end()) {
    return {.centre = start, .extent_mm = kHalfOpenExtentMm, .score = kScoreOfGivenStart};
  }
  DetectedHand hand = *near;
  hands.erase(near);
  return hand;
}

}  // namespace

void DetectorSegmenterOptions::visit(OptionVisitor& visitor) {
  detection.visit(visitor);
  visitor.real("margin_mm", margin_mm, closed(0, 500));
  visitor.real("min_area_mm2", min_area_mm2, closed(0, 1e6));
}

DetectorSegmenter::DetectorSegmenter(const DetectorWeights& weights, const DetectorSegmenterOptions& options)
    : detector_(weights), options_(options) {
  check_options(options_, "segmentation by a detector");
}

Segmentation DetectorSegmenter::segment(const Frame& frame, const std::optional<Point3>& start,
                                        int max_hands) const {
  check_size(frame);
  check_start(frame, start);
  check_max_hands(max_hands);
  Segmentation result;
  result.reason = "no surface was measured in the frame";
  if (std::ranges::none_of(frame.depth_mm.pixels(), is_measured)) return result;
  result.reason = "the detector sees no hand in the frame";
  std::vector<DetectedHand> hands = detector_.detect(frame, options_.detection);
  if (start) {
    add_region(frame, hand_at_start(*start, hands), true, result);
    if (result.hands.empty()) return result;
  }
  for (const DetectedHand& hand : hands) {
    if (std::ssize(result.hands) == max_hands) break;
    add_region(frame, hand, false, result);
  }
  if (!result.hands.empty()) result.reason.clear();
  std::ranges::stable_sort(result.hands, std::greater{}, &HandRegion::score);
  return result;
}

void DetectorSegmenter::add_region(const Frame& frame, const DetectedHand& hand, bool is_given,
                                   Segmentation& result) const {
  const std::shared_ptr<const RayTable> rays = ray_cache_.rays_of(frame.camera);
  const PointCloud cloud =
      points_around(frame.depth_mm, *rays, hand.centre, hand.extent_mm + options_.margin_mm);
  const double area = area_mm2(cloud.pixels, frame.camera, frame.depth_mm);
  if (cloud.pixels.empty() || area < options_.min_area_mm2) {
    result.reason = cloud.pixels.empty()
                        ? "no measurement near the start"
                        : fmt::format("the surface found covers {:.0f} mm^2, a hand at least {:.0f}", area,
                                      options_.min_area_mm2);
    return;
  }
  HandRegion region = region_of_pixels(cloud.pixels, frame.depth_mm.width());
  region.centre = hand.centre;
  region.score = hand.score;
  if (hand.score > kScoreOfGivenStart) region.side = hand.side;
  if (!is_given) region.likelihood = hand.score;
  result.hands.push_back(std::move(region));
}

}  // namespace knuckle
