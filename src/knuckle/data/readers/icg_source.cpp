// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/icg_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/csv_image.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/exr_image.h"
#include "knuckle/data/readers/file_listing.h"
#include "knuckle/data/readers/icg_format.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/data/truth.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

/// Labels under these names were not looked at by a person; they come last, in this order.
constexpr std::array<std::string_view, 2> kUnverified{"extrapolated", "init"};
constexpr std::size_t kValuesPerIcgFrame = 60;
constexpr float kMmPerMetre = 1000.0f;

std::string_view folder_of(std::string_view path) {
  return path.substr(0, path.rfind('/') + 1);
}

auto rank_of(const std::string& annotator) {
  const auto place = std::ranges::find(kUnverified, annotator);
  return place == kUnverified.end() ? -1 : static_cast<int>(place - kUnverified.begin());
}

bool is_hand_colour(const Rgb& pixel) {
  return pixel.red >= 128 && pixel.green <= 32 && pixel.blue <= 32;
}

Image<std::uint16_t> infrared_from_values(const Image<float>& values, const fs::path& path) {
  constexpr float kHighest = std::numeric_limits<std::uint16_t>::max();
  Image<std::uint16_t> infrared(values.width(), values.height());
  std::ranges::transform(values.pixels(), infrared.pixels().begin(), [&](float value) {
    if (!std::isfinite(value)) fail("{}: holds the value {}, expected a number", path.string(), value);
    return static_cast<std::uint16_t>(std::clamp(std::round(value), 0.0f, kHighest));
  });
  return infrared;
}

}  // namespace

void IcgOptions::visit(OptionVisitor& visitor) {
  visitor.text("annotator", annotator);
  visitor.real("background_mm", background_mm, above(0));
  visitor.integer("minimum_infrared", minimum_infrared, closed(0, 65535));
}

IcgSource::IcgSource(fs::path folder, const IcgOptions& options)
    : folder_(std::move(folder)), options_(options) {
  check_options(options, "icg");
  std::set<std::string, std::less<>> annotators;
  visit_files_below(folder_, [&](std::string_view path) {
    if (parse_icg_depth_name(path)) {
      depth_files_.emplace_back(path);
    } else if (const std::string_view annotator = icg_annotator_of(path);
               !annotator.empty() && !annotators.contains(annotator)) {
      annotators.emplace(annotator);
    }
  });
  if (depth_files_.empty()) fail("{}: holds neither *_depth_*.exr nor *_depth.csv", folder_.string());
  std::ranges::sort(depth_files_);
  choose_annotators({annotators.begin(), annotators.end()});
  read_calibrations();
}

void IcgSource::choose_annotators(std::vector<std::string> found) {
  if (options_.annotator.empty()) {
    annotators_ = std::move(found);
    std::ranges::stable_sort(annotators_, {}, rank_of);
    return;
  }
  if (std::ranges::find(found, options_.annotator) == found.end()) {
    fail("{}: has no labels by '{}'; there are labels by: {}", folder_.string(), options_.annotator,
         joined(found));
  }
  annotators_ = {options_.annotator};
}

void IcgSource::read_calibrations() {
  for (const std::string& file : depth_files_) {
    const std::string_view folder = folder_of(file);
    if (!cameras_.contains(folder))
      cameras_.emplace(folder, read_icg_calibration(find_icg_calibration(folder_ / folder)));
  }
}

std::optional<Convention> IcgSource::convention() const {
  if (annotators_.empty()) return std::nullopt;
  return convention_from_name("icg20");
}

Image<float> IcgSource::read_depth(const std::string& file) const {
  const bool is_synthetic = file.ends_with(".exr");
  Image<float> depth = is_synthetic ? read_exr(folder_ / file) : read_csv_image(folder_ / file);
  const float unit_mm = is_synthetic ? kMmPerMetre : 1.0f;
  const auto background_mm = static_cast<float>(options_.background_mm);
  for (float& value : depth.pixels()) {
    value *= unit_mm;
    if (!(value >= 0 && value <= background_mm)) value = 0;
  }
  return depth;
}

void IcgSource::add_infrared(Frame& frame) const {
  const fs::path path = folder_ / (frame.name + "_infrared.csv");
  if (!fs::exists(path)) return;
  const Image<float> values = read_csv_image(path);
  require_size(values, frame.camera.width, frame.camera.height, path);
  frame.infrared = infrared_from_values(values, path);
  for (std::size_t i = 0; i < frame.depth_mm.size(); ++i)
    if (frame.infrared.data()[i] < options_.minimum_infrared) frame.depth_mm.data()[i] = 0;
}

void IcgSource::add_mask(Frame& frame, std::string_view number) const {
  const fs::path path = folder_ / fmt::format("{}_rgb{}.png", frame.name, number);
  if (!fs::exists(path)) return;
  const Image<Rgb> colours = read_png_rgb(path, ImageSize{frame.camera.width, frame.camera.height});
  frame.mask = Image<std::uint8_t>(colours.width(), colours.height());
  std::ranges::transform(colours.pixels(), frame.mask.pixels().begin(),
                         [](const Rgb& pixel) -> std::uint8_t { return is_hand_colour(pixel) ? 1 : 0; });
}

std::optional<HandPose> IcgSource::read_truth(const std::string& stem) const {
  for (const std::string& annotator : annotators_) {
    const fs::path path = folder_ / fmt::format("{}_anno_{}.txt", stem, annotator);
    if (!fs::exists(path)) continue;
    const std::vector<double> uvd =
        parse_annotation(read_regular_file(path, limits::kDocumentBytes), kValuesPerIcgFrame, path.string());
    return known_or_nothing(with_pixel_origin(pose_from_uvd(convention_from_name("icg20"), uvd),
                                              PixelOrigin::corner, PixelOrigin::centre));
  }
  return std::nullopt;
}

Frame IcgSource::read(std::int64_t index) const {
  const std::string& file = depth_files_.at(static_cast<std::size_t>(index));
  const IcgFrameName name = *parse_icg_depth_name(file);
  Frame frame;
  frame.name = name.stem;
  frame.depth_mm = read_depth(file);
  frame.camera = cameras_.find(folder_of(file))->second;
  frame.camera.width = frame.depth_mm.width();
  frame.camera.height = frame.depth_mm.height();
  add_infrared(frame);
  if (name.is_synthetic) add_mask(frame, name.number);
  frame.truth = read_truth(frame.name);
  return frame;
}

}  // namespace knuckle
