// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/msra15_source.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/file_listing.h"
#include "knuckle/data/truth.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little-endian");

constexpr Camera kMsra15Camera{CameraModel::projective, 320, 240, 241.42, 241.42, 160.0, 120.0, {}};
constexpr std::string_view kSuffix = "_depth.bin";
constexpr std::size_t kValuesAMsra15Frame = 63;

struct Header {
  std::int32_t width, height, left, top, right, bottom;
};

Header parse_header(const std::string& bytes, const fs::path& path) {
  Header header{};
  if (bytes.size() < sizeof(header)) fail("{}: is cut short, {} bytes", path.string(), bytes.size());
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.width != kMsra15Camera.width || header.height != kMsra15Camera.height) {
    fail("{}: is {}x{} pixels, expected {}x{}", path.string(), header.width, header.height,
         kMsra15Camera.width, kMsra15Camera.height);
  }
  const bool is_box = header.left >= 0 && header.left <= header.right && header.right <= header.width &&
                      header.top >= 0 && header.top <= header.bottom && header.bottom <= header.height;
  if (!is_box) {
    fail("{}: the box [{}, {}) x [{}, {}) does not lie in the image", path.string(), header.left,
         header.right, header.top, header.bottom);
  }
  const std::size_t box_area =
      static_cast<std::size_t>(header.right - header.left) * (header.bottom - header.top);
  const std::size_t expected = sizeof(header) + box_area * sizeof(float);
  if (bytes.size() != expected) fail("{}: has {} bytes, expected {}", path.string(), bytes.size(), expected);
  return header;
}

/// joint.txt, whose first line must count the others.
LineIndex open_joints(const fs::path& path) {
  LineIndex lines(path);
  if (lines.size() == 0) fail("{}: is empty", path.string());
  const long long count = parse_integer(trimmed(lines.line(0)), lines.where(0));
  if (count != lines.size() - 1)
    fail("{}: announces {} frames but labels {}", path.string(), count, lines.size() - 1);
  return lines;
}

}  // namespace

Image<float> read_msra15_depth(const fs::path& path) {
  const std::string bytes = read_text_file(path);
  const Header header = parse_header(bytes, path);
  Image<float> depth_mm(header.width, header.height);
  const std::size_t row_bytes = sizeof(float) * static_cast<std::size_t>(header.right - header.left);
  const char* row = bytes.data() + sizeof(header);
  for (int y = header.top; y < header.bottom && row_bytes > 0; ++y, row += row_bytes)
    std::memcpy(&depth_mm(header.left, y), row, row_bytes);
  for (float& depth : depth_mm.pixels())
    if (!std::isfinite(depth) || depth < 0) depth = 0;
  return depth_mm;
}

Msra15Source::Msra15Source(fs::path folder) : folder_(std::move(folder)), projection_(kMsra15Camera) {
  for (const std::string& path : list_files_below(folder_, kSuffix)) add(path);
  if (entries_.empty()) fail("{}: holds no *{}", folder_.string(), kSuffix);
}

void Msra15Source::add(const std::string& path) {
  const std::size_t name_start = path.rfind('/') + 1;  // 0 where there is no '/'
  const std::string folder = path.substr(0, name_start);
  if (gestures_.empty() || gestures_.back().folder != folder) {
    gestures_.push_back({folder, {}});
    const fs::path joints = folder_ / folder / "joint.txt";
    if (fs::exists(joints)) gestures_.back().joints = open_joints(joints);
  }
  entries_.push_back({gestures_.size() - 1, path.substr(name_start)});
}

std::optional<Convention> Msra15Source::convention() const {
  for (const Gesture& gesture : gestures_)
    if (gesture.joints) return convention_from_name("msra21");
  return std::nullopt;
}

std::optional<HandPose> Msra15Source::read_truth(const Gesture& gesture, const std::string& name) const {
  if (!gesture.joints) return std::nullopt;
  // The first line counts the frames; the number in a file's name counts from 0.
  const std::string number = name.substr(0, name.size() - kSuffix.size());
  const std::int64_t line = 1 + parse_integer(number, (folder_ / gesture.folder / name).string());
  std::vector<double> xyz =
      parse_annotation(gesture.joints->line(line), kValuesAMsra15Frame, gesture.joints->where(line));
  for (std::size_t i = 0; i < xyz.size(); i += 3) {  // y points up and z towards the camera there
    xyz[i + 1] = -xyz[i + 1];
    xyz[i + 2] = -xyz[i + 2];
  }
  return known_or_nothing(pose_from_camera(convention_from_name("msra21"), xyz, projection_));
}

std::string Msra15Source::name_of(const Entry& entry) const {
  return gestures_[entry.gesture].folder + entry.name.substr(0, entry.name.size() - kSuffix.size());
}

FrameLabel Msra15Source::read_label(std::int64_t index) const {
  const Entry& entry = entries_.at(static_cast<std::size_t>(index));
  return {kMsra15Camera, read_truth(gestures_[entry.gesture], entry.name), std::nullopt,
          static_cast<int>(entry.gesture), name_of(entry)};
}

Frame Msra15Source::read(std::int64_t index) const {
  const Entry& entry = entries_.at(static_cast<std::size_t>(index));
  const Gesture& gesture = gestures_[entry.gesture];
  const fs::path path = folder_ / gesture.folder / entry.name;
  Frame frame;
  frame.name = name_of(entry);
  frame.camera = kMsra15Camera;
  frame.depth_mm = read_msra15_depth(path);
  frame.truth = read_truth(gesture, entry.name);
  frame.sequence = static_cast<int>(entry.gesture);
  return frame;
}

}  // namespace knuckle
