// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/nyu_source.h"

#include <utility>

#include "knuckle/core/text.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/file_listing.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/data/truth.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

/// The intrinsics that the set's own code uses. Its y axis points up; ours down, so fy is positive.
constexpr Camera kNyuCamera{CameraModel::projective, 640, 480, 588.036865, 587.075073, 320.0, 240.0, {}};
constexpr int kNoMeasurement = 2001;

Image<float> decoded(const Image<Rgb>& pixels) {
  Image<float> depth_mm(pixels.width(), pixels.height());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Rgb pixel = pixels.data()[i];
    const int depth = pixel.green * 256 + pixel.blue;
    depth_mm.data()[i] = depth == kNoMeasurement ? 0.0f : static_cast<float>(depth);
  }
  return depth_mm;
}

}  // namespace

NyuSource::NyuSource(fs::path folder, const NyuOptions& options)
    : folder_(std::move(folder)), prefix_(fmt::format("depth_{}_", options.view)) {
  check_options(options, "nyu");
  names_ = list_files(folder_, prefix_, ".png");
  if (names_.empty()) fail("{}: holds no {}*.png", folder_.string(), prefix_);
  const fs::path truth = folder_ / "joint_data.mat";
  if (fs::exists(truth)) truth_.emplace(truth, options.view);
}

std::optional<Convention> NyuSource::convention() const {
  if (!truth_) return std::nullopt;
  return convention_from_name("nyu14");
}

std::optional<HandPose> NyuSource::read_truth(const std::string& name) const {
  if (!truth_) return std::nullopt;
  // The number in the name, which counts from 1, is the row of the label.
  const std::string digits = without_extension(name).substr(prefix_.size());
  const long long number = parse_integer(digits, (folder_ / name).string());
  return known_or_nothing(truth_->pose(number - 1));
}

FrameLabel NyuSource::read_label(std::int64_t index) const {
  const std::string& name = names_.at(static_cast<std::size_t>(index));
  return {kNyuCamera, read_truth(name), std::nullopt, 0, without_extension(name)};
}

Frame NyuSource::read(std::int64_t index) const {
  const std::string& name = names_.at(static_cast<std::size_t>(index));
  const fs::path path = folder_ / name;
  Frame frame;
  frame.name = without_extension(name);
  frame.camera = kNyuCamera;
  frame.depth_mm = decoded(read_png_rgb(path, ImageSize{kNyuCamera.width, kNyuCamera.height}));
  frame.truth = read_truth(name);
  return frame;
}

}  // namespace knuckle
