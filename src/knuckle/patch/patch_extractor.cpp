// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/patch_extractor.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/patch/cube_patch.h"

namespace knuckle {
namespace {

constexpr std::string_view kModes[] = {"hand", "cube"};

/// Of each column (or row) of the patch the nearest column (or row) of the image; -1 where it is outside of
/// the box or of the image.
std::vector<int> nearest_places(double centre, const PatchGeometry& geometry, int box_first, int box_end,
                                int end) {
  std::vector<int> places(static_cast<std::size_t>(geometry.size_px));
  for (int i = 0; i < geometry.size_px; ++i) {
    const double place = centre + (i - 0.5 * (geometry.size_px - 1)) * geometry.image_px_per_patch_px;
    const int nearest = static_cast<int>(std::lround(place));
    const bool is_inside = nearest >= std::max(box_first, 0) && nearest < std::min(box_end, end);
    places[i] = is_inside ? nearest : -1;
  }
  return places;
}

/// The hand's depths, resized; 0 elsewhere.
Image<float> resized_hand(const Frame& frame, const HandRegion& hand, const PatchGeometry& geometry) {
  const Box& box = hand.box;
  const std::vector<int> columns =
      nearest_places(geometry.centre_u, geometry, box.x, box.right(), frame.depth_mm.width());
  const std::vector<int> rows =
      nearest_places(geometry.centre_v, geometry, box.y, box.bottom(), frame.depth_mm.height());
  Image<float> patch(geometry.size_px, geometry.size_px);
  for (int j = 0; j < geometry.size_px; ++j) {
    if (rows[j] < 0) continue;
    const float* const depth = frame.depth_mm.row(rows[j]).data();
    const std::uint8_t* const mask = hand.mask.row(rows[j] - box.y).data();
    float* const line = patch.row(j).data();
    for (int i = 0; i < geometry.size_px; ++i) {
      if (columns[i] < 0 || mask[columns[i] - box.x] == 0) continue;
      if (is_measured(depth[columns[i]])) line[i] = depth[columns[i]];
    }
  }
  return patch;
}

struct DepthMoments {
  int count = 0;
  double mean_mm = 0.0;
  double deviation_mm = 0.0;  ///< of the pixels themselves, not of a sample
};

/// Over the pixels that are not 0.
DepthMoments depth_moments(const Image<float>& patch) {
  DepthMoments moments;
  double sum = 0.0;
  for (const float depth : patch.pixels()) {
    sum += depth;
    moments.count += depth > 0.0f ? 1 : 0;
  }
  if (moments.count == 0) return moments;
  moments.mean_mm = sum / moments.count;
  double squares = 0.0;
  for (const float depth : patch.pixels()) {
    const double difference = depth > 0.0f ? depth - moments.mean_mm : 0.0;
    squares += difference * difference;
  }
  moments.deviation_mm = std::sqrt(squares / moments.count);
  return moments;
}

void normalise(Image<float>& patch, const PatchGeometry& geometry) {
  const auto mean = static_cast<float>(geometry.mean_depth_mm);
  const auto scale = static_cast<float>(1.0 / geometry.depth_deviation_mm);
  for (float& pixel : patch.pixels()) {
    const float deviations = std::clamp((pixel - mean) * scale, -kPatchBackground, kPatchBackground);
    pixel = pixel > 0.0f ? deviations : kPatchBackground;
  }
}

void apply(const PatchStatistics& statistics, Image<float>& patch) {
  if (!statistics.mean.empty()) {
    for (std::size_t i = 0; i < patch.size(); ++i) patch.data()[i] -= statistics.mean.data()[i];
  }
  if (statistics.whitening.empty()) return;
  const auto size = static_cast<Eigen::Index>(patch.size());
  using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const Matrix> whitening(statistics.whitening.data(), size, size);
  Eigen::Map<Eigen::VectorXf> pixels(patch.data(), size);
  pixels = (whitening * pixels).eval();
}

}  // namespace

void PatchOptions::visit(OptionVisitor& visitor) {
  visitor.integer("size_px", size_px, closed(2, 1024));
  visitor.choice("mode", mode, kModes);
  visitor.real("cube_mm", cube_mm, closed(10, 2000));
}

PatchGeometry patch_geometry(const Box& box, int size_px) {
  PatchGeometry geometry;
  geometry.size_px = size_px;
  geometry.centre_u = box.x + 0.5 * (box.width - 1);
  geometry.centre_v = box.y + 0.5 * (box.height - 1);
  geometry.image_px_per_patch_px = static_cast<double>(std::max(box.width, box.height)) / size_px;
  return geometry;
}

PatchExtractor::PatchExtractor(const PatchOptions& options)
    : PatchExtractor(options, PatchStatistics{options.size_px, {}, {}}) {}

PatchExtractor::PatchExtractor(const PatchOptions& options, PatchStatistics statistics)
    : options_(options), statistics_(std::move(statistics)) {
  check_options(options, "patch");
  check(statistics_);
  if (statistics_.size_px != options.size_px) {
    fail("patch: size_px is {}, but the model was trained on patches of {}", options.size_px,
         statistics_.size_px);
  }
  if (options.is_cube() && !(statistics_.mean.empty() && statistics_.whitening.empty())) {
    fail("patch: patches of a cube take no mean patch and no whitening");
  }
}

std::optional<HandPatch> PatchExtractor::extract(const Frame& frame, const HandRegion& hand) const {
  if (hand.mask.width() != hand.box.width || hand.mask.height() != hand.box.height) {
    fail("frame {}: the hand's mask is {} x {} pixels, its box {} x {}", frame.name, hand.mask.width(),
         hand.mask.height(), hand.box.width, hand.box.height);
  }
  if (hand.box.empty()) return std::nullopt;
  if (options_.is_cube()) return extract_around(frame, Projection(frame.camera).to_image(hand.centre));
  HandPatch patch;
  patch.camera = frame.camera;
  patch.geometry = patch_geometry(hand.box, statistics_.size_px);
  patch.pixels = resized_hand(frame, hand, patch.geometry);
  const DepthMoments moments = depth_moments(patch.pixels);
  if (moments.count == 0) return std::nullopt;
  patch.geometry.mean_depth_mm = moments.mean_mm;
  patch.geometry.depth_deviation_mm = std::max(moments.deviation_mm, kSmallestDeviationMm);
  normalise(patch.pixels, patch.geometry);
  apply(statistics_, patch.pixels);
  return patch;
}

std::optional<HandPatch> PatchExtractor::extract_around(const Frame& frame, const ImagePoint& centre) const {
  if (!options_.is_cube()) fail("patch: only patches of the mode \"cube\" can be cut around a point");
  return extract_cube(frame, centre, {options_.size_px, options_.cube_mm});
}

}  // namespace knuckle
