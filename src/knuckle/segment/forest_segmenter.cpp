// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/forest_segmenter.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/segment/components.h"
#include "knuckle/segment/hand_region.h"
#include "knuckle/segment/mask_filters.h"

namespace knuckle {
namespace {

using PixelList = std::vector<std::int32_t>;

constexpr double kAtStart = 20.0;  // [mm]

void check_odd(int size, std::string_view name) {
  if (size % 2 == 0) fail("forest segmentation: {} is {}, expected an odd number", name, size);
}

/// Majority, closing, opening: each a square of that many pixels.
void clean(Image<std::uint8_t>& mask, const ForestSegmenterOptions& options) {
  const int closing = options.closing_px;
  const int opening = options.opening_px;
  if (options.median_px > 1) mask = majority(mask, options.median_px);
  if (closing > 1) mask = eroded(dilated(mask, closing), closing);
  if (opening > 1) mask = dilated(eroded(mask, opening), opening);
}

/// Whether the surface ends beside this pixel of the image: the neighbour's depth is much larger, or missing.
bool is_at_edge(const Image<float>& depth_mm, int column, int row, float step_mm) {
  const float bound = depth_mm(column, row) + step_mm;
  constexpr std::array<std::pair<int, int>, 4> kNeighbours{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
  return std::ranges::any_of(kNeighbours, [&](const std::pair<int, int>& step) {
    const int x = column + step.first;
    const int y = row + step.second;
    return depth_mm.contains(x, y) && !(is_measured(depth_mm(x, y)) && depth_mm(x, y) <= bound);
  });
}

void trim_edges(Image<std::uint8_t>& mask, const Image<float>& depth_mm, double step_mm) {
  for (int row = 0; row < mask.height(); ++row) {
    for (int column = 0; column < mask.width(); ++column) {
      std::uint8_t& pixel = mask(column, row);
      if (pixel != 0 && is_at_edge(depth_mm, column, row, static_cast<float>(step_mm))) pixel = 0;
    }
  }
}

Image<std::uint8_t> hand_mask(const PixelForest& forest, const Frame& frame,
                              const ForestSegmenterOptions& options) {
  const Image<float>& depth_mm = frame.depth_mm;
  Image<std::uint8_t> mask = forest.above(depth_mm, frame.camera, static_cast<float>(options.probability));
  clean(mask, options);
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (!is_measured(depth_mm.data()[i])) mask.data()[i] = 0;
  }
  if (options.edge_step_mm > 0.0) trim_edges(mask, depth_mm, options.edge_step_mm);
  return mask;
}

double distance_to(const Point3& start, const PixelList& pixels, const RayTable& rays, const Frame& frame) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const std::int32_t pixel : pixels) {
    nearest = std::min(nearest, (mean_point({pixel}, rays, frame.depth_mm) - start).norm());
  }
  return nearest;
}

}  // namespace

void ForestSegmenterOptions::visit(OptionVisitor& visitor) {
  visitor.real("probability", probability, closed_open(0, 1));
  visitor.integer("median_px", median_px, closed(1, 31));
  visitor.integer("closing_px", closing_px, closed(1, 31));
  visitor.integer("opening_px", opening_px, closed(1, 31));
  visitor.real("edge_step_mm", edge_step_mm, closed(0, 1000));
  visitor.real("min_area_mm2", min_area_mm2, closed(0, 1e6));
}

ForestSegmenter::ForestSegmenter(PixelForest forest, const ForestSegmenterOptions& options)
    : forest_(std::move(forest)), options_(options) {
  check_options(options_, "forest segmentation");
  check_odd(options_.median_px, "median_px");
  check_odd(options_.closing_px, "closing_px");
  check_odd(options_.opening_px, "opening_px");
}

Segmentation ForestSegmenter::segment(const Frame& frame, const std::optional<Point3>& start,
                                      int max_hands) const {
  check_size(frame);
  check_start(frame, start);
  check_max_hands(max_hands);
  Segmentation result;
  result.reason = "no surface was measured in the frame";
  if (frame.depth_mm.empty()) return result;
  const std::shared_ptr<const RayTable> rays = ray_cache_.rays_of(frame.camera);

  std::vector<std::pair<double, HandRegion>> found;  // with the distance from the start
  for (const PixelList& pixels : components_of(hand_mask(forest_, frame, options_))) {
    const double area = area_mm2(pixels, frame.camera, frame.depth_mm);
    if (area < options_.min_area_mm2) continue;
    HandRegion region = region_of_pixels(pixels, frame.depth_mm.width());
    region.centre = mean_point(pixels, *rays, frame.depth_mm);
    region.score = area;
    const double distance = start ? std::max(distance_to(*start, pixels, *rays, frame), kAtStart) : 0.0;
    found.emplace_back(distance, std::move(region));
  }
  std::ranges::stable_sort(found, {},
                           [](const auto& hand) { return std::pair(hand.first, -hand.second.score); });
  if (std::ssize(found) > max_hands) found.resize(static_cast<std::size_t>(max_hands));
  for (auto& [distance, region] : found) result.hands.push_back(std::move(region));
  result.reason.clear();
  if (result.hands.empty()) {
    result.reason = fmt::format("no surface of at least {:.0f} mm^2 that the forest takes for a hand",
                                options_.min_area_mm2);
  }
  return result;
}

}  // namespace knuckle
