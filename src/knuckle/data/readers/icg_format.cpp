// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/icg_format.h"

#include <algorithm>
#include <vector>

#include <fmt/ranges.h>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/core/text.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

constexpr std::string_view kDepthTag = "_depth";
constexpr std::string_view kAnnotationTag = "_anno_";

/// Whether the text is "_" and digits.
bool is_number_tag(std::string_view text) {
  return text.size() > 1 && text[0] == '_' &&
         text.find_first_not_of("0123456789", 1) == std::string_view::npos;
}

}  // namespace

std::optional<IcgFrameName> parse_icg_depth_name(std::string_view path) {
  const std::size_t tag = path.rfind(kDepthTag);
  if (tag == std::string_view::npos || tag == 0 || path[tag - 1] == '/') return std::nullopt;
  const std::string_view stem = path.substr(0, tag);
  std::string_view rest = path.substr(tag + kDepthTag.size());
  if (rest == ".csv") return IcgFrameName{stem, "", false};
  if (!rest.ends_with(".exr")) return std::nullopt;
  rest.remove_suffix(4);
  if (!rest.empty() && !is_number_tag(rest)) return std::nullopt;
  return IcgFrameName{stem, rest, true};
}

std::string_view icg_annotator_of(std::string_view path) {
  const std::size_t tag = path.rfind(kAnnotationTag);
  if (tag == std::string_view::npos || !path.ends_with(".txt")) return {};
  const std::size_t start = tag + kAnnotationTag.size();
  const std::string_view annotator = path.substr(start, path.size() - 4 - start);
  return annotator.find('/') == std::string_view::npos ? annotator : std::string_view{};
}

fs::path find_icg_calibration(const fs::path& folder) {
  for (fs::path above = fs::absolute(folder).lexically_normal();; above = above.parent_path()) {
    for (const std::string_view name : kIcgCalibrationNames)
      if (fs::is_regular_file(above / name)) return above / name;
    if (above == above.root_path()) {
      fail("{}: neither {} nor {} is in this folder or one above", folder.string(), kIcgCalibrationNames[0],
           kIcgCalibrationNames[1]);
    }
  }
}

Camera read_icg_calibration(const fs::path& path) {
  constexpr std::size_t kIntrinsics = 4;
  Camera camera;
  const std::vector<double> numbers =
      parse_numbers(read_regular_file(path, limits::kDocumentBytes), path.string());
  if (numbers.size() < kIntrinsics || numbers.size() > kIntrinsics + camera.distortion.size()) {
    fail("{}: has {} numbers, expected fx fy cx cy and up to {} of distortion", path.string(), numbers.size(),
         camera.distortion.size());
  }
  camera.fx = numbers[0];
  camera.fy = numbers[1];
  camera.cx = numbers[2];
  camera.cy = numbers[3];
  std::copy(numbers.begin() + kIntrinsics, numbers.end(), camera.distortion.begin());
  Camera any_size = camera;
  any_size.width = any_size.height = 1;
  try {
    check(any_size);
  } catch (const Error& error) {
    fail("{}: {}", path.string(), error.what());
  }
  return with_pixel_origin(camera, PixelOrigin::corner, PixelOrigin::centre);
}

std::string icg_calibration_text(const Camera& camera) {
  const Camera stored = with_pixel_origin(camera, PixelOrigin::centre, PixelOrigin::corner);
  std::string text = fmt::format("{} {}\n{} {}\n", stored.fx, stored.fy, stored.cx, stored.cy);
  if (stored.is_distorted()) text += fmt::format("{}\n", fmt::join(stored.distortion, " "));
  return text;
}

}  // namespace knuckle
