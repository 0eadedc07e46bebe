// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/nyu_truth.h"

#include <array>
#include <memory>
#include <utility>

#include <matio.h>

#include "knuckle/core/error.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/data/truth.h"

namespace knuckle {
namespace {

constexpr const char* kArray = "joint_uvd";
constexpr std::size_t kJointCount = 36;
/// Where the 14 joints of the published evaluations lie among the 36, in the order of `nyu14`.
constexpr std::array<std::size_t, 14> kEvaluatedJoints{0, 3, 6, 9, 12, 15, 18, 21, 24, 25, 27, 30, 31, 32};
constexpr std::size_t kValuesAFrame = 3 * kEvaluatedJoints.size();

struct MatCloser {
  void operator()(mat_t* file) const { Mat_Close(file); }
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

/// The views x frames x 36 x 3 doubles' place in the file. Throws unless the array is that.
std::unique_ptr<matvar_t, MatCloser> find_array(mat_t* file, const std::string& name, int view) {
  std::unique_ptr<matvar_t, MatCloser> array(Mat_VarReadInfo(file, kArray));
  if (!array) fail("{}: has no array '{}'", name, kArray);
  if (array->class_type != MAT_C_DOUBLE || array->isComplex)
    fail("{}: '{}' is no array of doubles", name, kArray);
  const std::size_t* dims = array->dims;
  if (array->rank != 4 || dims[1] == 0 || dims[2] != kJointCount || dims[3] != 3)
    fail("{}: '{}' is not views x frames x {} x 3", name, kArray, kJointCount);
  if (static_cast<std::size_t>(view) > dims[0])
    fail("{}: has {} views, asked for view {}", name, dims[0], view);
  return array;
}

/// One view as frames x 36 x 3, column-major as Matlab stores it: the frame runs fastest.
std::vector<double> read_view(const std::filesystem::path& path, int view) {
  const std::string name = path.string();
  const std::unique_ptr<mat_t, MatCloser> file(Mat_Open(name.c_str(), MAT_ACC_RDONLY));
  if (!file) fail("{}: cannot be opened as a Matlab file", name);
  const auto array = find_array(file.get(), name, view);
  const std::size_t count = array->dims[1] * kJointCount * 3;
  if (std::filesystem::file_size(path) < count / 64)
    fail("{}: is cut short", name);  // deflate gains far less
  std::vector<double> values(count, kNaN);
  const int views = static_cast<int>(array->dims[0]);
  if (Mat_VarReadDataLinear(file.get(), array.get(), values.data(), view - 1, views,
                            static_cast<int>(count)) != 0)
    fail("{}: '{}' is cut short or damaged", name, kArray);
  return values;
}

}  // namespace

NyuTruth::NyuTruth(std::filesystem::path path, int view) : path_(std::move(path)) {
  const std::vector<double> values = read_view(path_, view);
  const std::size_t frames = values.size() / (kJointCount * 3);
  uvd_.resize(frames * kValuesAFrame);
  for (std::size_t frame = 0; frame < frames; ++frame)
    for (std::size_t joint = 0; joint < kEvaluatedJoints.size(); ++joint)
      for (std::size_t axis = 0; axis < 3; ++axis)
        uvd_[frame * kValuesAFrame + 3 * joint + axis] =
            static_cast<float>(values[(axis * kJointCount + kEvaluatedJoints[joint]) * frames + frame]);
  frame_count_ = static_cast<std::int64_t>(frames);
}

HandPose NyuTruth::pose(std::int64_t frame) const {
  if (frame < 0 || frame >= frame_count_)
    fail("{}: labels {} frames, asked for frame {}", path_.string(), frame_count_, frame + 1);
  const auto first = uvd_.begin() + frame * static_cast<std::int64_t>(kValuesAFrame);
  const std::vector<double> uvd(first, first + kValuesAFrame);
  return pose_from_uvd(convention_from_name("nyu14"), uvd);
}

}  // namespace knuckle
