// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/poses_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/truth.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

constexpr std::string_view kConventionKey = "convention";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // some editors put it before UTF-8

/// Offset of a file's coordinates against the library's.
double origin_offset(PixelOrigin origin) {
  return origin == PixelOrigin::corner ? 0.5 : 0.0;
}

bool is_comment(std::string_view line) {
  return line.starts_with('#');
}

/// What the comments above the poses say of them.
struct PosesHead {
  std::optional<Convention> convention;
  PoseCoordinates coordinates;

  /// Takes note of a comment. False where it says nothing of the poses.
  bool take(std::string_view comment, std::string_view where) {
    const std::string_view text = comment.substr(1);
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos) return false;
    try {
      return set(trimmed(text.substr(0, colon)), trimmed(text.substr(colon + 1)));
    } catch (const Error& error) {
      fail("{}: {}", where, error.what());
    }
  }

  bool set(std::string_view key, std::string_view value) {
    if (key == kConventionKey) {
      convention = convention_from_name(value);
    } else if (key == "format") {
      coordinates.kind = coordinate_kind_from_text(value);
    } else if (key == "axes") {
      coordinates.axes = axes_from_text(value);
    } else if (key == "unit") {
      coordinates.unit_mm = unit_from_text(value);
    } else {
      return false;
    }
    return true;
  }
};

void append_joint(fmt::memory_buffer& text, const ImagePoint& joint, double offset) {
  if (joint.is_missing()) {
    fmt::format_to(std::back_inserter(text), "nan nan nan");
  } else {
    fmt::format_to(std::back_inserter(text), "{:.4f} {:.4f} {:.4f}", joint.u + offset, joint.v + offset,
                   joint.depth_mm);
  }
}

}  // namespace

PoseNumbers read_pose_numbers(const std::filesystem::path& path, const std::optional<Convention>& convention,
                              const PoseCoordinates& coordinates) {
  PosesHead head{convention, coordinates};
  PoseNumbers numbers{path.string(), {}, {}, {}};
  const auto add = [&](std::string_view line, const std::string& where) {
    if (is_comment(line)) {
      if (head.take(line, where) && !numbers.values.empty())
        fail("{}: what the poses are must stand before the first one", where);
      return;
    }
    if (!head.convention)
      fail("{}:1: expected '# convention: NAME', or the convention as an option", path.string());
    const std::vector<double> values = parse_annotation(line, 3 * head.convention->landmarks.size(), where);
    numbers.values.insert(numbers.values.end(), values.begin(), values.end());
  };
  std::string blank;  // where the first of blank lines is, which only the file's end may follow
  visit_lines(path, [&](const FileLine& line) {
    std::string_view text = line.text;
    if (line.number == 1 && text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    if (trimmed(text).empty()) {
      if (blank.empty()) blank = line.where();
      return;
    }
    if (!blank.empty()) add("", blank);
    add(text, line.where());
  });
  if (numbers.values.empty()) fail("{}: expected a pose a line, found none", path.string());
  numbers.convention = *head.convention;
  numbers.coordinates = head.coordinates;
  if (numbers.coordinates.kind == PoseCoordinates::Kind::uvd &&
      numbers.coordinates.axes != Eigen::Matrix3d::Identity())
    fail("{}: axes are told of x y z, but its format is u v d", path.string());
  return numbers;
}

PoseSequence poses_from(const PoseNumbers& numbers, std::span<const Projection> projections,
                        PixelOrigin origin) {
  const auto frames = static_cast<std::size_t>(numbers.frames());
  const bool is_seen = numbers.coordinates.kind == PoseCoordinates::Kind::uvd;
  if (!is_seen && projections.empty())
    fail("{}: holds x y z, which need a camera; expected u v d", numbers.origin);
  if (!is_seen && projections.size() != 1 && projections.size() != frames)
    fail("{}: {} frames predicted, but there are {}", numbers.origin, frames, projections.size());
  const double offset = is_seen ? origin_offset(origin) : 0.0;
  PoseSequence sequence{numbers.origin, numbers.convention, {}};
  sequence.poses.reserve(frames);
  const double* next = numbers.values.data();
  for (std::size_t i = 0; i < frames; ++i) {
    const Projection* const projection =
        projections.empty() ? nullptr : &projections[projections.size() == 1 ? 0 : i];
    HandPose pose = HandPose::missing(numbers.convention);
    for (ImagePoint& joint : pose.joints) {
      const ImagePoint point =
          image_point(Eigen::Map<const Eigen::Vector3d>(next), numbers.coordinates, projection);
      if (!point.is_missing()) joint = {point.u - offset, point.v - offset, point.depth_mm};
      next += 3;
    }
    sequence.poses.push_back(std::move(pose));
  }
  return sequence;
}

PoseSequence read_poses_file(const std::filesystem::path& path, const std::optional<Convention>& convention,
                             PixelOrigin origin) {
  return poses_from(read_pose_numbers(path, convention), {}, origin);
}

std::string poses_head(const Convention& convention) {
  return fmt::format("# {}: {}\n", kConventionKey, convention.name);
}

std::string pose_line(const HandPose& pose, PixelOrigin origin) {
  fmt::memory_buffer text;
  for (std::size_t j = 0; j < pose.joints.size(); ++j) {
    if (j > 0) text.push_back(' ');
    append_joint(text, pose.joints[j], origin_offset(origin));
  }
  text.push_back('\n');
  return fmt::to_string(text);
}

void write_poses_file(const std::filesystem::path& path, const Convention& convention,
                      std::span<const HandPose> poses, PixelOrigin origin) {
  std::string text = poses_head(convention);
  for (const HandPose& pose : poses) {
    if (pose.convention != convention || pose.joints.size() != convention.landmarks.size()) {
      fail("{}: expected poses of {}, found one of {}", path.string(), convention.name, pose.convention.name);
    }
    text += pose_line(pose, origin);
  }
  write_text_file(path, text);
}

}  // namespace knuckle
