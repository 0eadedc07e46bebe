// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detector_segmenter.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "knuckle/segment/detector/surface_behind.h"
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

using Pixels = std::vector<std::int32_t>;

/// Pixels of the points that lie before a surface.
Pixels pixels_before(const SurfaceBehind& surface, const PointCloud& cloud) {
  const float thickness_mm = surface.thickness_mm();
  Pixels pixels;
  for (int i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f point(cloud.x[i], cloud.y[i], cloud.z[i]);
    if (surface.height_mm(point) > thickness_mm) pixels.push_back(cloud.pixels[i]);
  }
  return pixels;
}

}  // namespace

void DetectorSegmenterOptions::visit(OptionVisitor& visitor) {
  detection.visit(visitor);
  visitor.real("margin_mm", margin_mm, closed(0, 500));
  visitor.real("min_area_mm2", min_area_mm2, closed(0, 1e6));
  visitor.flag("cut_surface", cut_surface);
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
  const double radius_mm = hand.extent_mm + options_.margin_mm;
  PointCloud ball = points_around(frame.depth_mm, *rays, hand.centre, radius_mm);
  const auto area_of = [&](const Pixels& pixels) { return area_mm2(pixels, frame.camera, frame.depth_mm); };
  const double area = area_of(ball.pixels);
  if (ball.pixels.empty() || area < options_.min_area_mm2) {
    result.reason = ball.pixels.empty()
                        ? "no measurement near the start"
                        : fmt::format("the surface found covers {:.0f} mm^2, a hand at least {:.0f}", area,
                                      options_.min_area_mm2);
    return;
  }
  Pixels pixels;
  if (options_.cut_surface) {
    const auto surface = surface_behind(frame.depth_mm, *rays, hand.centre, radius_mm);
    if (surface) pixels = pixels_before(*surface, ball);
  }
  if (pixels.empty() || area_of(pixels) < options_.min_area_mm2) pixels = std::move(ball.pixels);
  HandRegion region = region_of_pixels(pixels, frame.depth_mm.width());
  region.centre = hand.centre;
  region.score = hand.score;
  if (hand.score > kScoreOfGivenStart) region.side = hand.side;
  if (!is_given) region.likelihood = hand.score;
  result.hands.push_back(std::move(region));
}

}  // namespace knuckle
