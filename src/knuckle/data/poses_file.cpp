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

constexpr std::string_view kConventionKey = "convention:";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // some editors put it before UTF-8

/// Offset of a file's coordinates against the library's.
double origin_offset(PixelOrigin origin) {
  return origin == PixelOrigin::corner ? 0.5 : 0.0;
}

std::string place(const std::filesystem::path& path, std::size_t line_index) {
  return fmt::format("{}:{}", path.string(), line_index + 1);
}

bool is_comment(std::string_view line) {
  return line.starts_with('#');
}

/// The convention that a comment names; nothing where it says something else.
std::optional<Convention> convention_in(std::string_view comment, std::string_view where) {
  std::string_view text = trimmed(comment.substr(1));
  if (!text.starts_with(kConventionKey)) return std::nullopt;
  text.remove_prefix(kConventionKey.size());
  try {
    return convention_from_name(trimmed(text));
  } catch (const Error& error) {
    fail("{}: {}", where, error.what());
  }
}

HandPose pose_from_line(std::string_view line, const Convention& convention, double offset,
                        std::string_view where) {
  const std::vector<double> values = parse_annotation(line, 3 * convention.landmarks.size(), where);
  HandPose pose = HandPose::missing(convention);
  for (std::size_t j = 0; j < pose.joints.size(); ++j) {
    const ImagePoint joint{values[3 * j] - offset, values[3 * j + 1] - offset, values[3 * j + 2]};
    if (!joint.is_missing()) pose.joints[j] = joint;
  }
  return pose;
}

void append_joint(fmt::memory_buffer& text, const ImagePoint& joint, double offset) {
  if (joint.is_missing()) {
    fmt::format_to(std::back_inserter(text), "nan nan nan");
  } else {
    fmt::format_to(std::back_inserter(text), "{:.4f} {:.4f} {:.4f}", joint.u + offset, joint.v + offset,
                   joint.depth_mm);
  }
}

}  // namespace

PoseSequence read_poses_file(const std::filesystem::path& path, const std::optional<Convention>& convention,
                             PixelOrigin origin) {
  std::vector<std::string> lines = read_lines(path);
  while (!lines.empty() && trimmed(lines.back()).empty()) lines.pop_back();
  if (!lines.empty() && lines.front().starts_with(kByteOrderMark))
    lines.front().erase(0, kByteOrderMark.size());

  std::optional<Convention> named = convention;
  PoseSequence sequence{path.string(), {}, {}};
  sequence.poses.reserve(lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string where = place(path, i);
    if (is_comment(lines[i])) {
      const std::optional<Convention> found = convention_in(lines[i], where);
      if (found && !sequence.poses.empty())
        fail("{}: the convention must stand before the first pose", where);
      if (found) named = found;
      continue;
    }
    if (!named) fail("{}: expected '# convention: NAME', or the convention as an option", place(path, 0));
    sequence.poses.push_back(pose_from_line(lines[i], *named, origin_offset(origin), where));
  }
  if (sequence.poses.empty()) fail("{}: expected a pose a line, found none", path.string());
  sequence.convention = *named;
  return sequence;
}

std::string poses_head(const Convention& convention) {
  return fmt::format("# {} {}\n", kConventionKey, convention.name);
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
