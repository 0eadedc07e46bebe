// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/mean_shift_segmenter.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "knuckle/core/error.h"
#include "knuckle/segment/hand_region.h"
#include "knuckle/segment/nearest_pixel.h"

namespace knuckle {
namespace {

std::optional<Point3> nearest_point(const Image<float>& depth_mm, const RayTable& rays) {
  const std::optional<NearestPixel> nearest = nearest_pixel(depth_mm);
  if (!nearest) return std::nullopt;
  const auto [column, row, depth] = *nearest;
  return Point3(rays.x(column, row, depth), rays.y(column, row, depth), depth);
}

/// The numbers of the cloud's pixels whose points lie closer to `centre` than `radius_mm`.
std::vector<std::int32_t> pixels_within(const PointCloud& cloud, const Point3& centre, double radius_mm) {
  std::vector<std::int32_t> pixels;
  pixels.reserve(cloud.pixels.size());
  const Eigen::Array3f middle = centre.cast<float>();
  const auto squared_radius = static_cast<float>(radius_mm * radius_mm);
  for (int i = 0; i < cloud.size(); ++i) {
    const float dx = cloud.x[i] - middle.x();
    const float dy = cloud.y[i] - middle.y();
    const float dz = cloud.z[i] - middle.z();
    if (dx * dx + dy * dy + dz * dz < squared_radius) pixels.push_back(cloud.pixels[i]);
  }
  return pixels;
}

/// Takes the points within a ball out of a depth image.
void take_out(Image<float>& depth_mm, const RayTable& rays, const Point3& centre, double radius_mm) {
  for (const std::int32_t pixel : points_around(depth_mm, rays, centre, radius_mm).pixels) {
    depth_mm.data()[pixel] = 0.0f;
  }
}

}  // namespace

void MeanShiftSegmenterOptions::visit(OptionVisitor& visitor) {
  mean_shift.visit(visitor);
  visitor.real("kernel_cutoff", kernel_cutoff, open_interval(0, 1));
  visitor.real("min_area_mm2", min_area_mm2, closed(0, 1e6));
  visitor.real("separation_mm", separation_mm, closed(0, 1000));
  visitor.integer("max_candidates", max_candidates, closed(1, 1000));
}

MeanShiftSegmenter::MeanShiftSegmenter(const MeanShiftSegmenterOptions& options, int max_hands)
    : options_(options), max_hands_(max_hands) {
  check_options(options_, "mean shift segmentation");
  check_max_hands(max_hands);
}

double MeanShiftSegmenter::reach_mm() const {
  return -std::log(options_.kernel_cutoff) * options_.mean_shift.bandwidth_mm;
}

MeanShiftSegmenter::Candidate MeanShiftSegmenter::candidate_at(const Frame& frame,
                                                               const Image<float>& depth_mm,
                                                               const RayTable& rays,
                                                               const Point3& start) const {
  const auto points_near = [&](const Point3& centre, double radius_mm) {
    return points_around(depth_mm, rays, centre, radius_mm);
  };
  const MeanShiftResult found = mean_shift(points_near, start, options_.mean_shift);
  Candidate candidate;
  candidate.centre = found.centre;
  const std::vector<std::int32_t> pixels = pixels_within(found.cloud, found.centre, reach_mm());
  const double area = area_mm2(pixels, frame);
  if (pixels.empty() || area < options_.min_area_mm2) {
    candidate.reason = pixels.empty()
                           ? "no measurement near the start"
                           : fmt::format("what is there covers {:.0f} mm^2, a hand at least {:.0f} mm^2",
                                         area, options_.min_area_mm2);
    return candidate;
  }
  const double h = options_.mean_shift.bandwidth_mm;
  candidate.region = region_of_pixels(pixels, depth_mm.width());
  candidate.region->centre = found.centre;
  candidate.region->score =
      found.mass * pixel_area_mm2(frame.camera, found.centre.z()) / (2 * std::numbers::pi * h * h);
  return candidate;
}

Segmentation MeanShiftSegmenter::segment(const Frame& frame, const std::optional<Point3>& start) const {
  check_size(frame);
  check_start(frame, start);
  Segmentation result;
  result.reason = "no surface was measured in the frame";
  if (frame.depth_mm.empty()) return result;
  const std::shared_ptr<const RayTable> rays = ray_cache_.rays_of(frame.camera);

  Image<float> rest;  // the depth image without what was taken out; empty while that is nothing
  for (int i = 0; i < options_.max_candidates; ++i) {
    const Image<float>& depth_mm = rest.empty() ? frame.depth_mm : rest;
    const bool is_start_given = start && i == 0;
    const std::optional<Point3> from = is_start_given ? start : nearest_point(depth_mm, *rays);
    if (!from) break;
    Candidate candidate = candidate_at(frame, depth_mm, *rays, *from);
    const bool is_hand = candidate.region.has_value();
    if (is_hand) result.hands.push_back(*std::move(candidate.region));
    result.reason = is_hand ? "" : candidate.reason;
    if (std::ssize(result.hands) == max_hands_ || (is_start_given && !is_hand)) break;
    if (rest.empty()) rest = frame.depth_mm;
    take_out(rest, *rays, candidate.centre, reach_mm() + (is_hand ? options_.separation_mm : 0.0));
  }
  if (!result.hands.empty()) result.reason.clear();
  std::ranges::stable_sort(result.hands, std::greater{}, &HandRegion::score);
  return result;
}

}  // namespace knuckle
