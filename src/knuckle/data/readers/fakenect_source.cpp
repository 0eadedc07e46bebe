// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/fakenect_source.h"

#include <algorithm>
#include <array>
#include <utility>

#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/file_listing.h"
#include "knuckle/data/readers/folder_format.h"
#include "knuckle/data/readers/pgm_image.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 3> kFakenectDepths{"auto", "raw", "mm"};

std::vector<FakenectImage> read_fakenect_index(const std::filesystem::path& folder) {
  require_folder(folder);
  const std::filesystem::path path = folder / "INDEX.txt";
  return parse_fakenect_index(read_text_file(path), path.string());
}

}  // namespace

void FakenectOptions::visit(OptionVisitor& visitor) {
  visitor.text("camera", camera);
  visitor.choice("depth", depth, kFakenectDepths);
}

FakenectSource::FakenectSource(std::filesystem::path folder, const FakenectOptions& options)
    : folder_(std::move(folder)),
      camera_(options.camera.empty() ? kinect_camera() : read_camera_file(options.camera)),
      images_(read_fakenect_index(folder_)),
      format_(find_format(options.depth == "auto" ? "" : options.depth)) {}

Image<std::uint16_t> FakenectSource::read_stored(std::int64_t index) const {
  const std::filesystem::path path = folder_ / images_.at(static_cast<std::size_t>(index)).name;
  const std::string bytes = read_regular_file(path, limits::kImageFileBytes);
  if (path.extension() == ".dump") {
    return decode_plain16(bytes, camera_.width, camera_.height, path.string());
  }
  Image<std::uint16_t> stored = decode_pgm16(bytes, path.string());
  require_size(stored, camera_.width, camera_.height, path);
  return stored;
}

KinectDepthFormat FakenectSource::find_format(std::string_view unit) const {
  constexpr std::int64_t kTries = 8;
  std::string fault;
  for (std::int64_t i = 0; i < std::min(size(), kTries); ++i) {
    try {
      const Image<std::uint16_t> stored = read_stored(i);
      if (shows_kinect_format(stored)) {
        return kinect_format_of(stored, unit, (folder_ / images_[static_cast<std::size_t>(i)].name).string());
      }
    } catch (const Error& error) {  // one bad image does not spoil the recording
      if (fault.empty()) fault = error.what();
    }
  }
  if (!fault.empty()) throw Error(fault);
  return {unit == "raw" ? KinectDepthUnit::raw : KinectDepthUnit::millimetre, false};
}

FrameLabel FakenectSource::read_label(std::int64_t index) const {
  const FakenectImage& image = images_.at(static_cast<std::size_t>(index));
  return {camera_, std::nullopt, image.time_s, image.sequence, without_extension(image.name), std::nullopt};
}

Frame FakenectSource::read(std::int64_t index) const {
  const FakenectImage& image = images_.at(static_cast<std::size_t>(index));
  Frame frame;
  frame.name = without_extension(image.name);
  frame.camera = camera_;
  frame.depth_mm = kinect_depth_mm(read_stored(index), format_, (folder_ / image.name).string());
  frame.time_s = image.time_s;
  frame.sequence = image.sequence;
  return frame;
}

}  // namespace knuckle
