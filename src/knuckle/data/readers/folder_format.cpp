// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/folder_format.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "knuckle/core/limits.h"
#include "knuckle/core/own_convention.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 2> kModels{"projective", "orthographic"};
constexpr std::array<std::string_view, 2> kOrigins{"centre", "corner"};
constexpr std::array<std::string_view, 3> kHands{"right", "left", "both"};
constexpr std::size_t kDistortionCount = 8;

Camera camera_from(const CameraOptions& options) {
  Camera camera;
  camera.model = options.model == "orthographic" ? CameraModel::orthographic : CameraModel::projective;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = options.fx;
  camera.fy = options.fy;
  camera.cx = options.cx;
  camera.cy = options.cy;
  std::ranges::copy(options.distortion, camera.distortion.begin());
  return camera;
}

CameraOptions options_from(const Camera& camera) {
  CameraOptions options{camera.model == CameraModel::orthographic ? "orthographic" : "projective",
                        camera.width,
                        camera.height,
                        camera.fx,
                        camera.fy,
                        camera.cx,
                        camera.cy,
                        {}};
  if (camera.is_distorted()) options.distortion.assign(camera.distortion.begin(), camera.distortion.end());
  return options;
}

/// `options` as the table has set them.
Camera checked_camera(const OptionTable& table, const CameraOptions& options) {
  for (const std::string_view key : {"width", "height", "fx", "fy", "cx", "cy"})
    if (!table.has(key)) fail("{}: [camera] lacks '{}'", table.origin(), key);
  const Camera camera = camera_from(options);
  try {
    check(camera);
  } catch (const Error& error) {
    fail("{}: [camera]: {}", table.origin(), error.what());
  }
  return camera;
}

/// The keys outside the table; those that are not known are left out.
std::string top_as_toml(const FolderDescription& description) {
  const bool is_corner = description.pixel_origin == PixelOrigin::corner;
  std::string text = fmt::format("convention = \"{}\"\ndepth_unit_mm = {}\npixel_origin = \"{}\"\n",
                                 description.convention ? description.convention->name : "",
                                 description.depth_unit_mm, kOrigins[is_corner ? 1 : 0]);
  if (!description.side.empty()) text += fmt::format("side = \"{}\"\n", description.side);
  if (description.rate_hz > 0.0) text += fmt::format("rate_hz = {}\n", description.rate_hz);
  return text;
}

/// One's own convention is a file beside the description: a data set is whole by itself.
Convention convention_of_folder(const std::string& text, const std::filesystem::path& folder) {
  if (!text.ends_with(".toml")) return convention_from_name(text);
  const std::filesystem::path file(text);
  if (file != file.filename()) fail("is \"{}\"; expected the name of a file in the same folder", text);
  return convention_from_file(folder / file);
}

}  // namespace

void CameraOptions::visit(OptionVisitor& visitor) {
  visitor.choice("model", model, kModels);
  visitor.integer("width", width, closed(1, limits::kImageSide));
  visitor.integer("height", height, closed(1, limits::kImageSide));
  visitor.real("fx", fx, {});
  visitor.real("fy", fy, {});
  visitor.real("cx", cx, {});
  visitor.real("cy", cy, {});
  visitor.reals("distortion", distortion, {}, 0, kDistortionCount);
}

void FolderOptions::visit(OptionVisitor& visitor) {
  visitor.text("convention", convention);
  visitor.real("depth_unit_mm", depth_unit_mm, open_closed(0, limits::kDepthUnitMm));
  visitor.choice("pixel_origin", pixel_origin, kOrigins);
  visitor.choice("side", side, kHands);
  visitor.real("rate_hz", rate_hz, open_closed(0, 10000));
}

std::optional<HandSide> FolderDescription::hand_side() const {
  if (side == "right") return HandSide::right;
  if (side == "left") return HandSide::left;
  return std::nullopt;
}

FolderDescription read_folder_description(const std::filesystem::path& path) {
  const OptionTable table = OptionTable::load(path);
  FolderOptions options;
  table.read(options);
  const OptionTable camera_table = table.table("camera");
  CameraOptions camera;
  camera_table.read(camera);
  table.finish();  // a mistyped key is named as such before the one that is missing for it
  if (!table.has("camera")) fail("{}: lacks the table [camera]", table.origin());
  FolderDescription description;
  description.camera = checked_camera(camera_table, camera);
  description.side = options.side;
  description.rate_hz = options.rate_hz;
  description.depth_unit_mm = options.depth_unit_mm;
  description.pixel_origin = options.pixel_origin == "corner" ? PixelOrigin::corner : PixelOrigin::centre;
  description.camera = with_pixel_origin(description.camera, description.pixel_origin, PixelOrigin::centre);
  if (options.convention.empty()) return description;
  try {
    description.convention = convention_of_folder(options.convention, path.parent_path());
  } catch (const Error& error) {
    table.fail_at("convention", error.what());
  }
  return description;
}

Camera read_camera_file(const std::filesystem::path& path) {
  return read_folder_description(path).camera;
}

std::string folder_description_as_toml(const FolderDescription& description) {
  const Camera camera = with_pixel_origin(description.camera, PixelOrigin::centre, description.pixel_origin);
  return top_as_toml(description) + "\n[camera]\n" + options_as_toml(options_from(camera));
}

}  // namespace knuckle
