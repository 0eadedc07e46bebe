// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/nyu_truth.h"

#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <utility>

#include <matio.h>

#include "knuckle/core/error.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/data/truth.h"

namespace knuckle {
namespace {

constexpr const char* kArray = "joint_uvd";
constexpr std::size_t kJointCount = 36;
/// Where the 14 joints of the published evaluations lie among the 36, in the order of `nyu14`.
constexpr std::array<std::size_t, 14> kEvaluatedJoints{0, 3, 6, 9, 12, 15, 18, 21, 24, 25, 27, 30, 31, 32};
constexpr std::size_t kValuesPerNyuFrame = 3 * kEvaluatedJoints.size();

struct MatCloser {
  void operator()(mat_t* file) const { Mat_Close(file); }
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

/// joint_uvd: views x frames x 36 x 3 doubles, column-major as Matlab stores them (the view runs fastest).
struct Labels {
  std::unique_ptr<matvar_t, MatCloser> array;
  std::size_t views = 0;
  std::size_t frames = 0;

  double operator()(std::size_t view, std::size_t frame, std::size_t joint, std::size_t axis) const {
    const auto* values = static_cast<const double*>(array->data);
    return values[((axis * kJointCount + joint) * frames + frame) * views + view];
  }
};

/// Throws unless the file's header says version 5. Files of version 7.3 are HDF5, whose library matio would
/// call, and that crashes on damaged ones.
void require_version_5(const std::filesystem::path& path) {
  constexpr std::streamoff kVersionPlace = 124;
  std::array<char, 4> version_and_order{};
  std::ifstream file(path, std::ios::binary);
  file.seekg(kVersionPlace);
  file.read(version_and_order.data(), version_and_order.size());
  constexpr std::array<char, 4> kVersion5{0x00, 0x01, 'I', 'M'};  // 0x0100, little-endian
  if (!file || version_and_order != kVersion5) {
    fail("{}: expected a little-endian Matlab file of version 5 (save it with -v7 or -v6)", path.string());
  }
}

/// Throws where the last element of a Matlab 5 file runs over its end, which matio does not notice. Such a
/// file is a header of 128 bytes, then elements of 4 bytes of type, 4 bytes of length, and that many bytes.
void require_whole(const std::filesystem::path& path) {
  constexpr std::uint64_t kHeaderBytes = 128;
  constexpr std::uint64_t kTagBytes = 8;
  const std::uint64_t file_bytes = std::filesystem::file_size(path);
  std::ifstream file(path, std::ios::binary);
  std::uint64_t place = kHeaderBytes;
  while (file && place + kTagBytes <= file_bytes) {
    std::array<std::uint32_t, 2> tag{};
    file.seekg(static_cast<std::streamoff>(place));
    file.read(reinterpret_cast<char*>(tag.data()), kTagBytes);
    place += kTagBytes + tag[1];
  }
  if (!file || place != file_bytes) fail("{}: is cut short or damaged", path.string());
}

bool silence_library() {
  return Mat_LogInitFunc("knuckle", [](int, char*) {}) == 0;
}

/// Throws where a file is too small for so many labels, however well they are compressed; before memory is
/// taken.
void require_room(const std::filesystem::path& path, std::size_t views, std::size_t frames) {
  constexpr std::size_t kDeflatesLimit = 1032;
  constexpr std::size_t kMostViews = 64;
  const std::size_t most =
      std::filesystem::file_size(path) * kDeflatesLimit / (kJointCount * 3 * sizeof(double));
  if (views > kMostViews || frames > static_cast<std::size_t>(limits::kFrames) || views * frames > most) {
    fail("{}: '{}' says that it has {} views of {} frames, more than the file can hold; it is damaged",
         path.string(), kArray, views, frames);
  }
}

/// Reads the array whole, 190 MB for the training set, for the time of opening: one frame's labels are
/// spread over all of it, and a compressed array must be inflated from its start.
Labels read_labels(const std::filesystem::path& path) {
  const std::string name = path.string();
  require_regular_file(path);
  require_version_5(path);
  [[maybe_unused]] static const bool is_silent = silence_library();
  const std::unique_ptr<mat_t, MatCloser> file(Mat_Open(name.c_str(), MAT_ACC_RDONLY));
  if (!file) fail("{}: cannot be opened as a Matlab file", name);
  require_whole(path);
  Labels labels{std::unique_ptr<matvar_t, MatCloser>(Mat_VarReadInfo(file.get(), kArray))};
  const matvar_t* array = labels.array.get();
  if (array == nullptr) fail("{}: has no array '{}', or is cut short", name, kArray);
  if (array->class_type != MAT_C_DOUBLE || array->isComplex != 0)
    fail("{}: '{}' is not an array of doubles", name, kArray);
  if (array->rank != 4 || array->dims[0] == 0 || array->dims[1] == 0 || array->dims[2] != kJointCount ||
      array->dims[3] != 3)
    fail("{}: '{}' is not views x frames x {} x 3", name, kArray, kJointCount);
  labels.views = array->dims[0];
  labels.frames = array->dims[1];
  require_room(path, array->dims[0], array->dims[1]);
  if (Mat_VarReadDataAll(file.get(), labels.array.get()) != 0 || array->data == nullptr)
    fail("{}: '{}' is cut short or damaged", name, kArray);
  return labels;
}

float checked_label(double value, const std::filesystem::path& path) {
  constexpr double kMost = 1e9;
  if (std::abs(value) > kMost)
    fail("{}: '{}' holds {}, expected at most {}", path.string(), kArray, value, kMost);
  return static_cast<float>(value);
}

}  // namespace

NyuTruth::NyuTruth(std::filesystem::path path, int view) : path_(std::move(path)) {
  const Labels labels = read_labels(path_);
  const auto view_index = static_cast<std::size_t>(view - 1);
  if (view_index >= labels.views)
    fail("{}: has {} views, asked for view {}", path_.string(), labels.views, view);
  uvd_.reserve(labels.frames * kValuesPerNyuFrame);
  for (std::size_t frame = 0; frame < labels.frames; ++frame) {
    for (const std::size_t joint : kEvaluatedJoints) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        uvd_.push_back(checked_label(labels(view_index, frame, joint, axis), path_));
    }
  }
  frame_count_ = static_cast<std::int64_t>(labels.frames);
}

HandPose NyuTruth::pose(std::int64_t frame) const {
  if (frame < 0 || frame >= frame_count_)
    fail("{}: labels {} frames, asked for frame {}", path_.string(), frame_count_, frame + 1);
  const auto first = uvd_.begin() + frame * static_cast<std::int64_t>(kValuesPerNyuFrame);
  const std::vector<double> uvd(first, first + kValuesPerNyuFrame);
  return pose_from_uvd(convention_from_name("nyu14"), uvd);
}

}  // namespace knuckle
