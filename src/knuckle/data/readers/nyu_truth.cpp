// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/nyu_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/limits.h"
#include "knuckle/data/readers/matlab_array.h"
#include "knuckle/data/truth.h"

namespace knuckle {
namespace {

constexpr const char* kArray = "joint_uvd";
constexpr std::size_t kJointCount = 36;
/// Where the 14 joints of the published evaluations lie among the 36, in the order of `nyu14`.
constexpr std::array<std::size_t, 14> kEvaluatedJoints{0, 3, 6, 9, 12, 15, 18, 21, 24, 25, 27, 30, 31, 32};
constexpr std::size_t kValuesPerNyuFrame = 3 * kEvaluatedJoints.size();

float checked_label(double value, const std::filesystem::path& path) {
  constexpr double kMost = 1e9;
  if (std::abs(value) > kMost)
    fail("{}: '{}' holds {}, expected at most {}", path.string(), kArray, value, kMost);
  return static_cast<float>(value);
}

/// joint_uvd: views x frames x 36 x 3 doubles (px, px, mm), as Matlab stores them: the view runs fastest.
struct Shape {
  std::size_t views = 0;
  std::size_t frames = 0;
};

Shape shape_of(const MatlabArray& array, const std::filesystem::path& path) {
  constexpr std::size_t kMostViews = 64;
  const std::vector<std::int64_t>& lengths = array.shape();
  if (lengths.size() != 4 || lengths[0] == 0 || lengths[1] == 0 ||
      static_cast<std::size_t>(lengths[2]) != kJointCount || lengths[3] != 3) {
    fail("{}: '{}' is not views x frames x {} x 3", path.string(), kArray, kJointCount);
  }
  const Shape shape{static_cast<std::size_t>(lengths[0]), static_cast<std::size_t>(lengths[1])};
  if (shape.views > kMostViews || shape.frames > static_cast<std::size_t>(limits::kFrames)) {
    fail("{}: '{}' has {} views of {} frames, expected at most {} of {}", path.string(), kArray, shape.views,
         shape.frames, kMostViews, limits::kFrames);
  }
  return shape;
}

/// Where a joint of the file lies among those that are kept, if it is.
std::optional<std::size_t> place_of(std::size_t joint) {
  const auto* const found = std::ranges::find(kEvaluatedJoints, joint);
  if (found == kEvaluatedJoints.end()) return std::nullopt;
  return static_cast<std::size_t>(found - kEvaluatedJoints.begin());
}

}  // namespace

NyuTruth::NyuTruth(std::filesystem::path path, int view) : path_(std::move(path)) {
  MatlabArray array(path_, kArray);
  const Shape shape = shape_of(array, path_);
  const auto view_index = static_cast<std::size_t>(view - 1);
  if (view_index >= shape.views) {
    fail("{}: has {} views, asked for view {}", path_.string(), shape.views, view);
  }
  uvd_.resize(shape.frames * kValuesPerNyuFrame);
  std::vector<double> values(shape.frames * shape.views);  // of one joint along one axis
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t joint = 0; joint < kJointCount; ++joint) {
      array.read(values);
      const std::optional<std::size_t> place = place_of(joint);
      if (!place) continue;
      for (std::size_t frame = 0; frame < shape.frames; ++frame) {
        uvd_[frame * kValuesPerNyuFrame + 3 * *place + axis] =
            checked_label(values[frame * shape.views + view_index], path_);
      }
    }
  }
  array.require_end();
  frame_count_ = static_cast<std::int64_t>(shape.frames);
}

HandPose NyuTruth::pose(std::int64_t frame) const {
  if (frame < 0 || frame >= frame_count_)
    fail("{}: labels {} frames, asked for frame {}", path_.string(), frame_count_, frame + 1);
  const auto first = uvd_.begin() + frame * static_cast<std::int64_t>(kValuesPerNyuFrame);
  const std::vector<double> uvd(first, first + kValuesPerNyuFrame);
  return pose_from_uvd(convention_from_name("nyu14"), uvd);
}

}  // namespace knuckle
