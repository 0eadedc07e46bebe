// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/mean_shift_segmenter.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/segment/hand_region.h"
#include "knuckle/segment/nearest_pixel.h"

namespace knuckle {
namespace {

constexpr double kSpeckleRadius = 3.0;  // [bandwidths]
constexpr double kNoBound = std::numeric_limits<double>::infinity();

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

struct Ball {
  Point3 centre;
  double radius_mm = 0.0;
};

void take_out(Image<float>& depth_mm, const RayTable& rays, const Ball& ball) {
  for (const std::int32_t pixel : points_around(depth_mm, rays, ball.centre, ball.radius_mm).pixels) {
    depth_mm.data()[pixel] = 0.0f;
  }
}

/// What mean shift found from one start.
struct Candidate {
  std::optional<HandRegion> region;  ///< nothing where it is no hand
  std::string reason;                ///< then why
  Ball used;                         ///< to be taken out before the next candidate
};

/// Why a region of that area is no hand; empty where it may be one.
std::string fault_of(double area, double min_area, double max_area) {
  if (area == 0.0) return "no measurement near the start";
  if (area < min_area)
    return fmt::format("the surface found covers {:.0f} mm^2, a hand at least {:.0f}", area, min_area);
  if (area > max_area)
    return fmt::format("the surface found covers {:.0f} mm^2, a hand at most {:.0f}", area, max_area);
  return "";
}

/// `depth_mm` is the frame's, without what was taken out.
Candidate candidate_at(const Camera& camera, const Image<float>& depth_mm, const RayTable& rays,
                       const Point3& start, double max_area_mm2, const MeanShiftSegmenterOptions& options) {
  const auto points_near = [&](const Point3& centre, double radius_mm) {
    return points_around(depth_mm, rays, centre, radius_mm);
  };
  const MeanShiftResult found = mean_shift(points_near, start, options.mean_shift);
  const double h = options.mean_shift.bandwidth_mm;
  const double reach_mm = -std::log(options.kernel_cutoff) * h;  // where the kernel falls below its cutoff
  const std::vector<std::int32_t> pixels = pixels_within(found.cloud, found.centre, reach_mm);
  const double area = area_mm2(pixels, camera, depth_mm);

  Candidate candidate;
  candidate.reason = fault_of(area, options.min_area_mm2, max_area_mm2);
  if (!candidate.reason.empty()) {
    // A trunk may have a hand in front of it: only the speckle at the start is taken out there.
    candidate.used = area > max_area_mm2 ? Ball{start, kSpeckleRadius * h} : Ball{found.centre, reach_mm};
    return candidate;
  }
  candidate.used = Ball{found.centre, reach_mm + options.separation_mm};
  candidate.region = region_of_pixels(pixels, depth_mm.width());
  candidate.region->centre = found.centre;
  const double unbounded_plane = 2.0 * std::numbers::pi * h * h;
  candidate.region->score = found.mass * pixel_area_mm2(camera, found.centre.z()) / unbounded_plane;
  return candidate;
}

}  // namespace

void MeanShiftSegmenterOptions::visit(OptionVisitor& visitor) {
  mean_shift.visit(visitor);
  visitor.real("kernel_cutoff", kernel_cutoff, open_interval(0, 1));
  visitor.real("min_area_mm2", min_area_mm2, closed(0, 1e6));
  visitor.real("max_area_mm2", max_area_mm2, open_closed(0, 1e6));
  visitor.real("separation_mm", separation_mm, closed(0, 1000));
  visitor.integer("max_candidates", max_candidates, closed(1, 1000));
}

MeanShiftSegmenter::MeanShiftSegmenter(const MeanShiftSegmenterOptions& options) : options_(options) {
  check_options(options_, "mean shift segmentation");
  if (options_.min_area_mm2 > options_.max_area_mm2) {
    fail(
        "mean shift segmentation: min_area_mm2 is {} and max_area_mm2 {}, expected min_area_mm2 <= "
        "max_area_mm2",
        options_.min_area_mm2, options_.max_area_mm2);
  }
}

Segmentation MeanShiftSegmenter::segment(const Frame& frame, const std::optional<Point3>& start,
                                         int max_hands) const {
  check_size(frame);
  check_start(frame, start);
  check_max_hands(max_hands);
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
    Candidate candidate = candidate_at(frame.camera, depth_mm, *rays, *from,
                                       is_start_given ? kNoBound : options_.max_area_mm2, options_);
    const bool is_hand = candidate.region.has_value();
    result.reason = candidate.reason;
    if (is_hand) result.hands.push_back(*std::move(candidate.region));
    if (std::ssize(result.hands) == max_hands || (is_start_given && !is_hand)) break;
    if (rest.empty()) rest = frame.depth_mm;
    take_out(rest, *rays, candidate.used);
  }
  if (!result.hands.empty()) result.reason.clear();
  std::ranges::stable_sort(result.hands, std::greater{}, &HandRegion::score);
  return result;
}

}  // namespace knuckle
