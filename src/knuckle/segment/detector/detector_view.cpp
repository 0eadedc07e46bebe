// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detector_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "knuckle/camera/projection.h"
#include "knuckle/core/frame.h"

namespace knuckle {
namespace {

constexpr int kSamplesPerSide = 3;  // of a cell
constexpr int kSamples = kSamplesPerSide * kSamplesPerSide;
constexpr double kMillimetresPerMetre = 1000.0;
constexpr int kBorderSteps = 32;  // places looked at along each border of the image

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double middle() const { return 0.5 * (low + high); }
  double length() const { return high - low; }
};

}  // namespace

DetectorView::DetectorView(const DetectorOptions& options, const Camera& camera)
    : options_(options),
      camera_(camera),
      sign_x_(camera.fx < 0.0 ? -1.0 : 1.0),
      sign_y_(camera.fy < 0.0 ? -1.0 : 1.0) {
  center_on_field();
  choose_samples();
}

void DetectorView::center_on_field() {
  const Projection projection(camera_);
  Range x;
  Range y;
  const auto include = [&](double u, double v) {
    const Point3 point = projection.to_camera(ImagePoint{u, v, kMillimetresPerMetre});
    x.include(point.x() / kMillimetresPerMetre);
    y.include(point.y() / kMillimetresPerMetre);
  };
  const double right = camera_.width - 0.5;  // the outer edges of the pixels
  const double bottom = camera_.height - 0.5;
  for (int i = 0; i <= kBorderSteps; ++i) {
    const double part = static_cast<double>(i) / kBorderSteps;
    const double u = -0.5 + part * (right + 0.5);
    const double v = -0.5 + part * (bottom + 0.5);
    include(u, -0.5);
    include(u, bottom);
    include(-0.5, v);
    include(right, v);
  }
  middle_x_ = x.middle();
  middle_y_ = y.middle();
  const double fits = std::min(options_.width / (options_.focal_cells * x.length()),
                               options_.height / (options_.focal_cells * y.length()));
  scale_ = std::clamp(fits, kSmallestScale, 1.0);
}

double DetectorView::ray_x(double u) const {
  return middle_x_ + sign_x_ * (u - 0.5 * (options_.width - 1)) / (options_.focal_cells * scale_);
}

double DetectorView::ray_y(double v) const {
  return middle_y_ + sign_y_ * (v - 0.5 * (options_.height - 1)) / (options_.focal_cells * scale_);
}

ViewPlace DetectorView::to_view(const Point3& point) const {
  const double distance = camera_.model == CameraModel::orthographic ? kMillimetresPerMetre : point.z();
  const double cells = options_.focal_cells * scale_;
  return {sign_x_ * (point.x() / distance - middle_x_) * cells + 0.5 * (options_.width - 1),
          sign_y_ * (point.y() / distance - middle_y_) * cells + 0.5 * (options_.height - 1),
          scale_ * kMillimetresPerMetre / point.z()};
}

Point3 DetectorView::to_camera(const ViewPlace& place) const {
  const double z = scale_ * kMillimetresPerMetre / place.inverse_depth;
  const double distance = camera_.model == CameraModel::orthographic ? kMillimetresPerMetre : z;
  return {ray_x(place.u) * distance, ray_y(place.v) * distance, z};
}

void DetectorView::choose_samples() {
  const Projection projection(camera_);
  samples_.reserve(static_cast<std::size_t>(kSamples) * options_.width * options_.height);
  for (int k = 0; k < kSamples; ++k) {
    const int sample_row = k / kSamplesPerSide;
    const double du = (k % kSamplesPerSide - 1) / static_cast<double>(kSamplesPerSide);
    const double dv = (sample_row - 1) / static_cast<double>(kSamplesPerSide);
    for (int row = 0; row < options_.height; ++row) {
      for (int column = 0; column < options_.width; ++column) {
        const Point3 point(ray_x(column + du) * kMillimetresPerMetre, ray_y(row + dv) * kMillimetresPerMetre,
                           kMillimetresPerMetre);
        const ImagePoint pixel = projection.to_image(point);
        const double u = std::round(pixel.u);
        const double v = std::round(pixel.v);
        const bool is_inside = u >= 0.0 && u < camera_.width && v >= 0.0 && v < camera_.height;
        samples_.push_back(
            is_inside ? static_cast<std::int32_t>(v) * camera_.width + static_cast<std::int32_t>(u) : -1);
      }
    }
  }
}

DetectorInput DetectorView::shrink(const Image<float>& depth_mm) const {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  const std::size_t cells = static_cast<std::size_t>(options_.width) * options_.height;
  std::vector<float> nearest(cells, kFar);
  std::vector<float> second(cells, kFar);
  DetectorInput input{Image<float>(options_.width, options_.height),
                      Image<float>(options_.width, options_.height)};
  float* const share = input.measured_share.data();
  const float* const depths = depth_mm.data();
  for (int k = 0; k < kSamples; ++k) {
    const std::int32_t* const pixels = samples_.data() + static_cast<std::size_t>(k) * cells;
    for (std::size_t i = 0; i < cells; ++i) {
      const float depth = pixels[i] >= 0 ? depths[pixels[i]] : 0.0f;
      const bool is_seen = depth > 0.0f && depth <= std::numeric_limits<float>::max();
      const float candidate = is_seen ? depth : kFar;
      second[i] = std::min(second[i], std::max(nearest[i], candidate));
      nearest[i] = std::min(nearest[i], candidate);
      share[i] += is_seen ? 1.0f / kSamples : 0.0f;
    }
  }
  const auto unit = static_cast<float>(scale_ * kMillimetresPerMetre);
  float* const inverse = input.inverse_depth.data();
  for (std::size_t i = 0; i < cells; ++i) {
    const float depth = second[i] < kFar ? second[i] : nearest[i];
    inverse[i] = std::min(unit / depth, static_cast<float>(kMostInverseDepth));  // 0 of infinitely far
  }
  return input;
}

}  // namespace knuckle
