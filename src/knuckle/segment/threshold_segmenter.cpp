// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/threshold_segmenter.h"

#include <algorithm>
#include <array>
#include <functional>
#include <string_view>

#include "knuckle/core/error.h"
#include "knuckle/segment/components.h"
#include "knuckle/segment/depth_interval.h"
#include "knuckle/segment/hand_region.h"
#include "knuckle/segment/nearest_pixel.h"

namespace knuckle {
namespace {

constexpr int kMostCandidates = 20;  // speckles left out before giving up

using PixelList = std::vector<std::int32_t>;

/// Parts the pixels of an image of that size into 8-connected components.
std::vector<PixelList> connected_parts(const PixelList& pixels, int width, int height) {
  Image<std::uint8_t> mask(width, height);
  for (const std::int32_t pixel : pixels) mask.data()[pixel] = 1;
  return components_of(mask);
}

}  // namespace

void ThresholdSegmenterOptions::visit(OptionVisitor& visitor) {
  static constexpr std::array<std::string_view, 2> kIntervals{"nearest", "fixed"};
  static constexpr std::array<std::string_view, 2> kPixels{"all", "component"};
  visitor.choice("interval", interval, kIntervals);
  visitor.real("range_mm", range_mm, open_closed(0, 10000));
  visitor.real("tolerance_mm", tolerance_mm, closed(0, 1000));
  visitor.real("near_mm", near_mm, closed(0, 20000));
  visitor.real("far_mm", far_mm, open_closed(0, 20000));
  visitor.choice("pixels", pixels, kPixels);
  visitor.real("min_area_mm2", min_area_mm2, closed(0, 1e6));
}

ThresholdSegmenter::ThresholdSegmenter(const ThresholdSegmenterOptions& options) : options_(options) {
  check_options(options_, "threshold segmentation");
  if (options_.near_mm >= options_.far_mm) {
    fail("threshold segmentation: near_mm is {} and far_mm {}, expected near_mm < far_mm", options_.near_mm,
         options_.far_mm);
  }
}

HandRegion ThresholdSegmenter::region_of(const PixelList& pixels, const Frame& frame) const {
  HandRegion region = region_of_pixels(pixels, frame.depth_mm.width());
  region.centre = mean_point(pixels, *ray_cache_.rays_of(frame.camera), frame.depth_mm);
  region.score = area_mm2(pixels, frame.camera, frame.depth_mm);
  return region;
}

std::vector<HandRegion> ThresholdSegmenter::hands_between(const Frame& frame, const Image<float>& depth_mm,
                                                          double near_mm, double far_mm,
                                                          int max_hands) const {
  const PixelList all = pixels_between(depth_mm, near_mm, far_mm);
  std::vector<PixelList> parts{all};
  if (options_.pixels == "component") parts = connected_parts(all, depth_mm.width(), depth_mm.height());
  const auto area_of = [&](const PixelList& part) { return area_mm2(part, frame.camera, frame.depth_mm); };
  std::erase_if(parts,
                [&](const PixelList& part) { return part.empty() || area_of(part) < options_.min_area_mm2; });
  std::ranges::stable_sort(parts, std::greater{}, area_of);
  if (std::ssize(parts) > max_hands) parts.resize(static_cast<std::size_t>(max_hands));
  std::vector<HandRegion> hands;
  for (const PixelList& part : parts) hands.push_back(region_of(part, frame));
  return hands;
}

Segmentation ThresholdSegmenter::segment(const Frame& frame, const std::optional<Point3>& start,
                                         int max_hands) const {
  check_size(frame);
  check_start(frame, start);
  check_max_hands(max_hands);
  Segmentation result;
  if (options_.interval == "fixed") {
    result.hands = hands_between(frame, frame.depth_mm, options_.near_mm, options_.far_mm, max_hands);
  } else if (start) {
    const double half = 0.5 * options_.range_mm;
    result.hands = hands_between(frame, frame.depth_mm, start->z() - half, start->z() + half, max_hands);
  } else {
    Image<float> rest = frame.depth_mm;
    for (int i = 0; i < kMostCandidates && result.hands.empty(); ++i) {
      const std::optional<NearestPixel> nearest = nearest_pixel(rest);
      if (!nearest) break;
      const double near_mm = nearest->depth_mm - options_.tolerance_mm;
      const double far_mm = nearest->depth_mm + options_.range_mm;
      result.hands = hands_between(frame, rest, near_mm, far_mm, max_hands);
      for (const std::int32_t pixel : pixels_between(rest, near_mm, far_mm)) rest.data()[pixel] = 0.0f;
    }
  }
  if (result.hands.empty()) {
    result.reason =
        fmt::format("no surface of at least {:.0f} mm^2 in the depth interval", options_.min_area_mm2);
  }
  return result;
}

}  // namespace knuckle
