// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/cube_view.h"

#include <cmath>
#include <numbers>

namespace knuckle {
namespace {

constexpr int kCoordinates = 3;

/// A sum of the four bytes of a random word, with mean 0 and deviation 1: near enough to normal for noise,
/// and ten times as fast.
float quick_normal(std::uint32_t word) {
  constexpr float kMean = 4 * 127.5f;
  constexpr float kDeviation = 147.8f;  // sqrt(4 (256^2 - 1) / 12)
  const std::uint32_t sum = (word & 0xFF) + ((word >> 8) & 0xFF) + ((word >> 16) & 0xFF) + (word >> 24);
  return (static_cast<float>(sum) - kMean) / kDeviation;
}

/// Of the words that decide on loss and noise: a share of all 2^32.
std::uint32_t threshold_of(double share) {
  return static_cast<std::uint32_t>(share * 4294967295.0);
}

struct Mean {
  double u = 0.0;
  double v = 0.0;
  double d = 0.0;
};

/// The mean of the joints that are known; zero where none is.
Mean mean_of(std::span<const float> joints) {
  Mean sum;
  int count = 0;
  for (std::size_t i = 0; i + 2 < joints.size(); i += kCoordinates) {
    if (!std::isfinite(joints[i] + joints[i + 1] + joints[i + 2])) continue;
    sum = {sum.u + joints[i], sum.v + joints[i + 1], sum.d + joints[i + 2]};
    ++count;
  }
  if (count == 0) return {};
  return {sum.u / count, sum.v / count, sum.d / count};
}

}  // namespace

double CubeViewer::crop_px_per_patch_px(const CubeSample& sample, const CubeView& view) const {
  const double crop_half_mm = 0.5 * samples_.crop().side_mm;
  const double centre_z = sample.centre_mm.z();
  return view.scale * centre_z / (centre_z + view.centre_d * crop_half_mm);
}

void CubeViewer::view_pixels(const CubeSample& sample, const CubeView& view, const PixelFaults& faults,
                             Random& random, std::span<float> pixels) const {
  const int size = samples_.patch().size_px;
  const int crop = samples_.crop().size_px;
  const double k = crop_px_per_patch_px(sample, view);
  const auto step_u = static_cast<float>(k * std::cos(view.rotation));
  const auto step_v = static_cast<float>(k * std::sin(view.rotation));
  const float half = 0.5f * static_cast<float>(size - 1);
  const float crop_half = 0.5f * static_cast<float>(crop - 1) + 0.5f;  // the half rounds to the nearest
  const auto first_u = static_cast<float>(view.centre_u) + crop_half;
  const auto first_v = static_cast<float>(view.centre_v) + crop_half;
  // Depths in halves of the view's cube.
  const auto ratio = static_cast<float>(samples_.crop().side_mm / (samples_.patch().side_mm * view.scale));
  const auto centre_d = static_cast<float>(view.centre_d);
  const auto noise = static_cast<float>(faults.noise_mm / (0.5 * samples_.patch().side_mm * view.scale));
  const std::uint32_t lost = threshold_of(faults.missing_share);
  const auto erased = static_cast<float>(faults.erased_radius * faults.erased_radius);
  for (int j = 0; j < size; ++j) {
    const float y = static_cast<float>(j) - half;
    const auto dv = static_cast<float>(j - faults.erased_v);
    float* const line = pixels.data() + static_cast<std::size_t>(j) * size;
    for (int i = 0; i < size; ++i) {
      const float x = static_cast<float>(i) - half;
      const float u = first_u + step_u * x - step_v * y;
      const float v = first_v + step_v * x + step_u * y;
      line[i] = kCubeBackground;
      if (!(u >= 0.0f && v >= 0.0f && u < static_cast<float>(crop) && v < static_cast<float>(crop))) continue;
      const std::uint8_t code =
          sample.codes[static_cast<std::size_t>(v) * crop + static_cast<std::size_t>(u)];
      if (code == CubeSamples::kBackgroundCode) continue;
      const auto du = static_cast<float>(i - faults.erased_u);
      if (du * du + dv * dv < erased) continue;
      float d = (CubeSamples::depth_of_code(code) - centre_d) * ratio;
      if (noise > 0.0f) d += noise * quick_normal(random());
      if (lost > 0 && random() < lost) continue;
      if (d > -1.0f && d < 1.0f) line[i] = d;
    }
  }
}

void CubeViewer::view_joints(const CubeSample& sample, const CubeView& view, std::span<float> joints) const {
  const double k = crop_px_per_patch_px(sample, view);
  const double half = 0.5 * (samples_.patch().size_px - 1);
  const double cosine = std::cos(view.rotation) / (k * half);
  const double sine = std::sin(view.rotation) / (k * half);
  const double ratio = samples_.crop().side_mm / (samples_.patch().side_mm * view.scale);
  for (std::size_t i = 0; i + 2 < joints.size(); i += kCoordinates) {
    const double u = sample.joints[i] - view.centre_u;
    const double v = sample.joints[i + 1] - view.centre_v;
    joints[i] = static_cast<float>(cosine * u + sine * v);
    joints[i + 1] = static_cast<float>(cosine * v - sine * u);
    joints[i + 2] = static_cast<float>((sample.joints[i + 2] - view.centre_d) * ratio);
  }
}

CubeView CubeViewer::around_mean_joint(const CubeSample& sample, const CubeView& view,
                                       std::span<const float> joints) const {
  const Mean mean = mean_of(joints);
  const double k = crop_px_per_patch_px(sample, view) * 0.5 * (samples_.patch().size_px - 1);
  const double cosine = k * std::cos(view.rotation);
  const double sine = k * std::sin(view.rotation);
  const double ratio = samples_.patch().side_mm * view.scale / samples_.crop().side_mm;
  CubeView moved = view;
  moved.centre_u += cosine * mean.u - sine * mean.v;
  moved.centre_v += sine * mean.u + cosine * mean.v;
  moved.centre_d += mean.d * ratio;
  return moved;
}

CubeView CubeViewer::around_true_joints(const CubeSample& sample) const {
  const Mean mean = mean_of(sample.joints);
  return {mean.u, mean.v, mean.d};
}

Point3 CubeViewer::in_camera(const CubeSample& sample, const CubeView& view,
                             std::span<const float, 3> joint) const {
  const double crop_mm = samples_.crop().side_mm;
  const double mm_per_crop_px = crop_mm / samples_.crop().size_px;  // at the depth of the crop's centre
  const CubeView at = around_mean_joint(sample, view, joint);
  const double z = sample.centre_mm.z() + at.centre_d * 0.5 * crop_mm;
  const double depth_ratio = z / sample.centre_mm.z();
  return {(sample.centre_mm.x() + at.centre_u * mm_per_crop_px) * depth_ratio,
          (sample.centre_mm.y() + at.centre_v * mm_per_crop_px) * depth_ratio, z};
}

void AugmentationOptions::visit(OptionVisitor& visitor) {
  visitor.real("rotation_deg", rotation_deg, closed(0, 180));
  visitor.real("shift_mm", shift_mm, closed(0, 100));
  visitor.real("recentred_share", recentred_share, closed(0, 1));
  visitor.real("scale_spread", scale_spread, closed(0, 0.5));
  visitor.real("noise_mm", noise_mm, closed(0, 50));
  visitor.real("missing_share", missing_share, closed(0, 0.9));
  visitor.real("erased_share", erased_share, closed(0, 1));
  visitor.real("erased_mm", erased_mm, closed(0, 200));
  visitor.real("mirrored_share", mirrored_share, closed(0, 0.9));
}

RandomView random_view(const CubeSample& sample, const CubeSamples& samples,
                       const AugmentationOptions& options, Random& random) {
  const double px_per_mm = samples.patch().size_px / samples.patch().side_mm;
  RandomView result;
  CubeView& view = result.view;
  if (random.uniform() < options.recentred_share) view = CubeViewer(samples).around_true_joints(sample);
  view.centre_u += random.normal() * options.shift_mm * px_per_mm;
  view.centre_v += random.normal() * options.shift_mm * px_per_mm;
  view.centre_d += random.normal() * options.shift_mm / (0.5 * samples.crop().side_mm);
  view.rotation = random.uniform(-1.0, 1.0) * options.rotation_deg * std::numbers::pi / 180.0;
  view.scale = 1.0 + random.uniform(-1.0, 1.0) * options.scale_spread;
  PixelFaults& faults = result.faults;
  faults.noise_mm = random.uniform() * options.noise_mm;
  faults.missing_share = random.uniform() * options.missing_share;
  if (random.uniform() < options.erased_share) {
    faults.erased_u = random.uniform() * samples.patch().size_px;
    faults.erased_v = random.uniform() * samples.patch().size_px;
    faults.erased_radius = random.uniform() * options.erased_mm * px_per_mm;
  }
  return result;
}

}  // namespace knuckle
