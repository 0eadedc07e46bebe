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
#include "knuckle/segment/search_image.h"

namespace knuckle {
namespace {

constexpr double kSpeckleRadius = 3.0;  // [bandwidths]
constexpr double kNoBound = std::numeric_limits<double>::infinity();
// The first part of a search looks at no more points than this (of those in the depth interval), and no
// longer.
constexpr int kFewPoints = 16'384;
constexpr int kMostFirstIterations = 40;  // a hand takes 14 to 20

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
  Point3 centre = Point3::Zero();
  double score = 0.0;
  double area_mm2 = 0.0;
  std::vector<std::int32_t> pixels;  ///< of the searched image
  std::string reason;                ///< why it is not a hand; empty where it may be one
  Ball used;                         ///< to be taken out before the next candidate
};

/// Why a region of that area is not a hand; empty where it may be one.
std::string fault_of(double area, double min_area, double max_area) {
  if (area == 0.0) return "no measurement near the start";
  if (area < min_area)
    return fmt::format("the surface found covers {:.0f} mm^2, a hand at least {:.0f}", area, min_area);
  if (area > max_area)
    return fmt::format("the surface found covers {:.0f} mm^2, a hand at most {:.0f}", area, max_area);
  return "";
}

/// Mean shift in an image.
class CandidateSearch {
 public:
  CandidateSearch(const Image<float>& depth_mm, const RayTable& rays,
                  const MeanShiftSegmenterOptions& options)
      : depth_mm_(depth_mm),
        rays_(rays),
        options_(options),
        reach_mm_(-std::log(options.kernel_cutoff) * options.mean_shift.bandwidth_mm) {}

  /// From a start that was given: whatever area it leads to, it is trusted.
  Candidate from_given(const Point3& start) const { return candidate_at(over_all(start), kNoBound); }

  /// From the nearest point. The search goes on with few of the points until it is near its end: enough to
  /// tell a wall, which has many points and is not a hand.
  Candidate from_nearest(const Point3& start) const {
    MeanShiftOptions first = options_.mean_shift;
    first.max_iterations = std::min(first.max_iterations, kMostFirstIterations);
    const MeanShiftResult found = mean_shift(points_near(kFewPoints), start, first);
    Candidate candidate = candidate_at(found, options_.max_area_mm2);
    const bool is_over_all = found.cloud.thinning == 1 &&
                             (found.converged || first.max_iterations == options_.mean_shift.max_iterations);
    if (!is_over_all && candidate.area_mm2 <= options_.max_area_mm2) {
      candidate = candidate_at(over_all(found.centre), options_.max_area_mm2);
    }
    // A trunk may have a hand in front of it: only the speckle at the start is taken out there.
    if (candidate.area_mm2 > options_.max_area_mm2) {
      candidate.used = {start, kSpeckleRadius * options_.mean_shift.bandwidth_mm};
    }
    return candidate;
  }

  /// The pixels of the whole frame within reach of the candidate's centre, without those in the balls
  /// `taken`.
  std::vector<std::int32_t> pixels_of(const Candidate& candidate, const Frame& frame, const RayTable& rays,
                                      const std::vector<Ball>& taken) const {
    const PointCloud cloud = points_around(frame.depth_mm, rays, candidate.centre, reach_mm_);
    std::vector<std::int32_t> pixels;
    pixels.reserve(cloud.pixels.size());
    for (int i = 0; i < cloud.size(); ++i) {
      const Point3 point(cloud.x[i], cloud.y[i], cloud.z[i]);
      const auto holds_point = [&](const Ball& ball) {
        return (point - ball.centre).squaredNorm() <= ball.radius_mm * ball.radius_mm;
      };
      if (std::ranges::none_of(taken, holds_point))
        pixels.push_back(cloud.pixels[static_cast<std::size_t>(i)]);
    }
    return pixels;
  }

 private:
  PointsAround points_near(int most) const {
    return [this, most](const Point3& centre, double radius_mm) {
      return points_around(depth_mm_, rays_, centre, radius_mm, most);
    };
  }

  MeanShiftResult over_all(const Point3& start) const {
    return mean_shift(points_near(std::numeric_limits<int>::max()), start, options_.mean_shift);
  }

  Candidate candidate_at(const MeanShiftResult& found, double max_area_mm2) const {
    Candidate candidate;
    candidate.centre = found.centre;
    candidate.pixels = pixels_within(found.cloud, found.centre, reach_mm_);
    candidate.area_mm2 = found.cloud.thinning * area_mm2(candidate.pixels, rays_.camera(), depth_mm_);
    candidate.reason = fault_of(candidate.area_mm2, options_.min_area_mm2, max_area_mm2);
    const double h = options_.mean_shift.bandwidth_mm;
    const double unbounded_plane = 2.0 * std::numbers::pi * h * h;
    candidate.score = found.mass * pixel_area_mm2(rays_.camera(), found.centre.z()) / unbounded_plane;
    const bool is_hand = candidate.reason.empty();
    candidate.used = {found.centre, reach_mm_ + (is_hand ? options_.separation_mm : 0.0)};
    return candidate;
  }

  const Image<float>& depth_mm_;
  const RayTable& rays_;
  const MeanShiftSegmenterOptions& options_;
  double reach_mm_;  ///< where the kernel falls below its cutoff
};

HandRegion region_of(const Candidate& candidate, int width) {
  HandRegion region = region_of_pixels(candidate.pixels, width);
  region.centre = candidate.centre;
  region.score = candidate.score;
  return region;
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
  const int stride = search_stride(frame.depth_mm);
  const std::shared_ptr<const RayTable> rays = ray_cache_.rays_of(thinned(frame.camera, stride));

  // The depth image that is searched, without what was taken out; empty while that is all of the frame's.
  Image<float> rest = stride > 1 ? thinned(frame.depth_mm, stride) : Image<float>();
  std::vector<Ball> taken;
  for (int i = 0; i < options_.max_candidates; ++i) {
    const Image<float>& depth_mm = rest.empty() ? frame.depth_mm : rest;
    const bool is_start_given = start && i == 0;
    const std::optional<Point3> from = is_start_given ? start : nearest_point(depth_mm, *rays);
    if (!from) break;
    const CandidateSearch search(depth_mm, *rays, options_);
    Candidate candidate = is_start_given ? search.from_given(*from) : search.from_nearest(*from);
    result.reason = candidate.reason;
    const bool is_hand = candidate.reason.empty();
    if (is_hand) {
      if (stride > 1)
        candidate.pixels = search.pixels_of(candidate, frame, *ray_cache_.rays_of(frame.camera), taken);
      result.hands.push_back(region_of(candidate, frame.depth_mm.width()));
    }
    if (std::ssize(result.hands) == max_hands || (is_start_given && !is_hand)) break;
    if (rest.empty()) rest = frame.depth_mm;
    take_out(rest, *rays, candidate.used);
    taken.push_back(candidate.used);
  }
  if (!result.hands.empty()) result.reason.clear();
  std::ranges::stable_sort(result.hands, std::greater{}, &HandRegion::score);
  return result;
}

}  // namespace knuckle
