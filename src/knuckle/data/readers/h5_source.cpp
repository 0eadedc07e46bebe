// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/h5_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/ranges.h>

#include "knuckle/camera/projection.h"
#include "knuckle/core/limits.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/frame_log.h"
#include "knuckle/data/readers/h5_format.h"
#include "knuckle/data/truth.h"

namespace knuckle {
namespace {

constexpr std::uint64_t kIntrinsicsPerFrame = 4;

Hdf5File open_whole(const std::filesystem::path& path) {
  constexpr std::string_view kUnfinished = "{}: is unfinished; let the run that writes it end";
  if (is_frame_log(path)) fail(kUnfinished, path.string());
  Hdf5File file = Hdf5File::open(path);
  file.require_format(kH5Format, kH5Version);
  if (file.number_attribute("complete") != 1) fail(kUnfinished, path.string());
  return file;
}

double depth_unit_of(const Hdf5File& file) {
  const double unit_mm = file.number_attribute("depth_unit_mm");
  if (!(unit_mm > 0 && unit_mm <= limits::kDepthUnitMm)) {
    fail("{}: the attribute 'depth_unit_mm' is {}, expected more than 0, at most {}", file.path().string(),
         unit_mm, limits::kDepthUnitMm);
  }
  return unit_mm;
}

std::int64_t whole_number(const Hdf5File& file, std::string_view attribute) {
  const double value = file.number_attribute(attribute);
  if (!(value >= 0 && value <= static_cast<double>(limits::kFrames) && value == std::floor(value))) {
    fail("{}: the attribute '{}' is {}, expected a whole number from 0 to {}", file.path().string(),
         attribute, value, limits::kFrames);
  }
  return static_cast<std::int64_t>(value);
}

/// Some arrays have a number per frame and are read whole; deflate makes a thousand zeros of a byte.
void require_frames_fit(std::uint64_t frames, std::uintmax_t bytes, const std::filesystem::path& path) {
  constexpr auto kMost = static_cast<std::uint64_t>(limits::kFrames);
  const std::uint64_t most = limits::kFewFrames + bytes / limits::kFrameBytes;
  if (frames > std::min(most, kMost)) {
    fail("{}: says that it holds {} frames, more than a file of {} bytes can; it is damaged", path.string(),
         frames, bytes);
  }
}

}  // namespace

H5Source::H5Source(const std::filesystem::path& path)
    : file_(open_whole(path)),
      bytes_(std::filesystem::file_size(path)),
      camera_(read_camera(file_)),
      depth_unit_mm_(depth_unit_of(file_)),
      first_index_(whole_number(file_, "first_index")),
      has_infrared_(file_.has(kH5Infrared)),
      has_mask_(file_.has(kH5Mask)),
      has_joints_(file_.has(kH5Joints)),
      has_intrinsics_(file_.has(kH5Intrinsics)),
      has_side_(file_.has(kH5Side)),
      has_labels_(file_.has(kH5Labels)) {
  const std::vector<std::uint64_t> shape = file_.shape(kH5Depth);
  const std::uint64_t count = shape.empty() ? 0 : shape[0];
  if (count == 0) fail("{}: holds no frame", path.string());
  require_frames_fit(count, bytes_, path);
  const std::vector<std::uint64_t> images{count, static_cast<std::uint64_t>(camera_.height),
                                          static_cast<std::uint64_t>(camera_.width)};
  require_shape(kH5Depth, images);
  if (has_infrared_) require_shape(kH5Infrared, images);
  if (has_mask_) require_shape(kH5Mask, images);
  if (has_joints_) require_shape(kH5Joints, {count, kSupersetSize, 3});
  if (has_intrinsics_) require_shape(kH5Intrinsics, {count, kIntrinsicsPerFrame});
  if (has_side_) require_shape(kH5Side, {count});
  if (has_labels_) require_shape(kH5Labels, images);
  if (file_.has(kH5Time)) require_shape(kH5Time, {count});
  if (file_.has(kH5Sequence)) require_shape(kH5Sequence, {count});
  size_ = static_cast<std::int64_t>(count);
  timeline_ = read_timeline();
  if (file_.has(kH5HandsEnd)) read_hands_ends();
}

void H5Source::read_hands_ends() {
  require_shape(kH5HandsEnd, {static_cast<std::uint64_t>(size_)});
  hands_ends_ = file_.read<std::int64_t>(kH5HandsEnd).values;
  std::int64_t before = 0;
  for (const std::int64_t end : hands_ends_) {
    if (end < before || end - before > limits::kHands) {
      fail("{}: {}: a frame has {} hands, expected 0 to {}", file_.path().string(), kH5HandsEnd, end - before,
           limits::kHands);
    }
    before = end;
  }
  const auto count = static_cast<std::uint64_t>(before);
  require_shape(kH5HandsSide, {count});
  require_shape(kH5HandsJoints, {count, kSupersetSize, 3});
  require_shape(kH5HandsOccluders, {count, kSupersetSize});
  require_shape(kH5HandsVisible, {count});
}

/// What is read of a file that somebody writes to may be half old and half new.
void H5Source::require_unchanged() const {
  std::error_code is_gone;  // then the open file is still whole
  const std::uintmax_t bytes = std::filesystem::file_size(file_.path(), is_gone);
  if (!is_gone && bytes != bytes_) {
    fail("{}: was changed while it was read: it has {} bytes, {} when it was opened", file_.path().string(),
         bytes, bytes_);
  }
}

Timeline H5Source::read_timeline() const {
  Timeline timeline;
  if (file_.has(kH5Time)) timeline.times_s = file_.read<double>(kH5Time).values;
  if (file_.has(kH5Sequence)) timeline.sequences = file_.read<std::int32_t>(kH5Sequence).values;
  if (const auto fault = fault_of(timeline))
    fail("{}: frame {}: {}", file_.path().string(), fault->frame, fault->message);
  return timeline;
}

void H5Source::require_shape(std::string_view array, const std::vector<std::uint64_t>& expected) const {
  const std::vector<std::uint64_t> shape = file_.shape(array);
  if (shape == expected) return;
  fail("{}: {}: has the shape {}, expected {}", file_.path().string(), array, fmt::join(shape, " x "),
       fmt::join(expected, " x "));
}

std::optional<Convention> H5Source::convention() const {
  if (!has_joints_) return std::nullopt;
  return superset_convention();
}

std::uint64_t H5Source::row_of(std::int64_t index) const {
  if (index < 0 || index >= size_)
    fail("{}: has {} frames, asked for frame {}", file_.path().string(), size_, index);
  return static_cast<std::uint64_t>(index);
}

Camera H5Source::read_frame_camera(std::uint64_t row) const {
  if (!has_intrinsics_) return camera_;
  std::array<double, kIntrinsicsPerFrame> values{};
  file_.read_rows(kH5Intrinsics, row, 1, values.data());
  Camera camera = camera_;
  camera.fx = values[0];
  camera.fy = values[1];
  camera.cx = values[2];
  camera.cy = values[3];
  try {
    check(camera);
  } catch (const Error& error) {
    fail("{}: {}: frame {}: {}", file_.path().string(), kH5Intrinsics, row, error.what());
  }
  return camera;
}

std::optional<HandPose> H5Source::read_truth(std::uint64_t row, const Camera& camera) const {
  if (!has_joints_) return std::nullopt;
  std::vector<float> joints_mm(std::size_t{kSupersetSize} * 3);
  file_.read_rows(kH5Joints, row, 1, joints_mm.data());
  const std::vector<double> xyz(joints_mm.begin(), joints_mm.end());
  check_coordinates(xyz, fmt::format("{}: {}: frame {}", file_.path().string(), kH5Joints, row));
  return known_or_nothing(pose_from_camera(superset_convention(), xyz, Projection(camera)));
}

std::optional<HandSide> H5Source::read_side(std::uint64_t row) const {
  if (!has_side_) return std::nullopt;
  std::int8_t code = 0;
  file_.read_rows(kH5Side, row, 1, &code);
  return side_of(code, fmt::format("{}: frame {}", file_.path().string(), row));
}

Image<std::uint8_t> H5Source::read_labels(std::uint64_t row) const {
  Image<std::uint8_t> labels(camera_.width, camera_.height);
  file_.read_rows(kH5Labels, row, 1, labels.data());
  constexpr auto kLast = static_cast<std::uint8_t>(PixelLabel::object);
  const auto worst = std::ranges::max(labels.pixels());
  if (worst > kLast) {
    fail("{}: {}: frame {}: a pixel has the label {}, expected 0 to {}", file_.path().string(), kH5Labels,
         row, worst, kLast);
  }
  return labels;
}

std::vector<HandTruth> H5Source::read_hands(std::uint64_t row, const Projection& projection) const {
  std::vector<HandTruth> hands;
  const std::string where = fmt::format("{}: frame {}", file_.path().string(), row);
  const std::int64_t first = row == 0 ? 0 : hands_ends_[row - 1];
  for (std::int64_t hand = first; hand < hands_ends_[row]; ++hand)
    hands.push_back(read_hand(static_cast<std::uint64_t>(hand), projection, where));
  return hands;
}

HandTruth H5Source::read_hand(std::uint64_t hand, const Projection& projection,
                              const std::string& where) const {
  HandTruth truth;
  std::int8_t side = 0;
  file_.read_rows(kH5HandsSide, hand, 1, &side);
  const std::optional<HandSide> known_side = side_of(side, where);
  if (!known_side) fail("{}: one of its hands has no side", where);
  truth.side = *known_side;
  std::array<float, std::size_t{kSupersetSize} * 3> joints_mm{};
  file_.read_rows(kH5HandsJoints, hand, 1, joints_mm.data());
  const std::vector<double> xyz(joints_mm.begin(), joints_mm.end());
  check_coordinates(xyz, fmt::format("{}: {}", where, kH5HandsJoints));
  truth.pose = pose_from_camera(superset_convention(), xyz, projection);
  std::array<std::uint8_t, kSupersetSize> occluders{};
  file_.read_rows(kH5HandsOccluders, hand, 1, occluders.data());
  for (const std::uint8_t occluder : occluders) {
    if (occluder > static_cast<std::uint8_t>(Occluder::border)) {
      fail("{}: {}: holds {}, expected 0 to {}", where, kH5HandsOccluders, occluder,
           static_cast<int>(Occluder::border));
    }
    truth.occluders.push_back(static_cast<Occluder>(occluder));
  }
  file_.read_rows(kH5HandsVisible, hand, 1, &truth.visible_share);
  if (!(truth.visible_share >= 0.0 && truth.visible_share <= 1.0))
    fail("{}: {}: is {}, expected 0 to 1", where, kH5HandsVisible, truth.visible_share);
  return truth;
}

H5Facts H5Source::facts() const {
  H5Facts facts;
  facts.frames = {first_index_, size_};
  if (file_.has_attribute(kH5PartOfFirst)) {
    facts.part_of = IndexRange{whole_number(file_, kH5PartOfFirst), whole_number(file_, kH5PartOfCount)};
    if (facts.part_of->first > facts.frames.first || facts.part_of->end() < facts.frames.end()) {
      fail("{}: holds frames {} to {}, but calls itself a part of {} to {}", file_.path().string(),
           facts.frames.first, facts.frames.end() - 1, facts.part_of->first, facts.part_of->end() - 1);
    }
  }
  facts.manifest = file_.text_attribute("manifest");
  facts.depth_unit_mm = depth_unit_mm_;
  facts.camera = read_frame_camera(0);
  facts.has_infrared = has_infrared_;
  facts.has_mask = has_mask_;
  facts.has_labels = has_labels_;
  facts.has_time = !timeline_.times_s.empty();
  return facts;
}

template <class T>
std::vector<std::uint8_t> H5Source::read_chunk(std::string_view array, std::uint64_t row) const {
  Image<T> pixels(camera_.width, camera_.height);
  file_.read_rows(array, row, 1, pixels.data());
  return chunk_of(pixels);
}

std::vector<StoredHand> H5Source::read_stored_hands(std::uint64_t row) const {
  std::vector<StoredHand> hands;
  const std::int64_t first = row == 0 ? 0 : hands_ends_[row - 1];
  for (std::int64_t i = first; i < hands_ends_[row]; ++i) {
    const auto number = static_cast<std::uint64_t>(i);
    StoredHand& hand = hands.emplace_back();
    file_.read_rows(kH5HandsSide, number, 1, &hand.side);
    file_.read_rows(kH5HandsJoints, number, 1, hand.joints_mm.data());
    file_.read_rows(kH5HandsOccluders, number, 1, hand.occluders.data());
    file_.read_rows(kH5HandsVisible, number, 1, &hand.visible_share);
  }
  return hands;
}

StoredFrame H5Source::read_stored(std::int64_t index) const {
  const std::uint64_t row = row_of(index);
  StoredFrame stored;
  stored.camera = read_frame_camera(row);
  stored.side = code_of(read_side(row));
  stored.time_s = timeline_.time_s(index).value_or(kNaN);
  stored.sequence = timeline_.sequence(index);
  stored.joints_mm.fill(std::numeric_limits<float>::quiet_NaN());
  if (has_joints_) file_.read_rows(kH5Joints, row, 1, stored.joints_mm.data());
  stored.depth = read_chunk<std::uint16_t>(kH5Depth, row);
  if (has_infrared_) stored.infrared = read_chunk<std::uint16_t>(kH5Infrared, row);
  if (has_mask_) stored.mask = read_chunk<std::uint8_t>(kH5Mask, row);
  if (has_labels_) stored.labels = chunk_of(read_labels(row));
  if (!hands_ends_.empty()) {
    (void)read_hands(row, Projection(stored.camera));  // throws where one is impossible
    stored.hands = read_stored_hands(row);
  }
  require_unchanged();
  return stored;
}

std::string H5Source::name_of(std::int64_t index) const {
  return fmt::format("{:08}", first_index_ + index);
}

FrameLabel H5Source::read_label(std::int64_t index) const {
  const std::uint64_t row = row_of(index);
  const Camera camera = read_frame_camera(row);
  std::optional<HandPose> truth = read_truth(row, camera);
  const std::optional<HandSide> side = read_side(row);
  require_unchanged();
  return {camera, std::move(truth), timeline_.time_s(index), timeline_.sequence(index), name_of(index), side};
}

Frame H5Source::read(std::int64_t index) const {
  const std::uint64_t row = row_of(index);
  Frame frame;
  frame.name = name_of(index);
  frame.camera = read_frame_camera(row);
  Image<std::uint16_t> counts(camera_.width, camera_.height);
  file_.read_rows(kH5Depth, row, 1, counts.data());
  frame.depth_mm = depth_from_counts(counts, depth_unit_mm_);
  if (has_infrared_) {
    frame.infrared = Image<std::uint16_t>(camera_.width, camera_.height);
    file_.read_rows(kH5Infrared, row, 1, frame.infrared.data());
  }
  if (has_mask_) {
    frame.mask = Image<std::uint8_t>(camera_.width, camera_.height);
    file_.read_rows(kH5Mask, row, 1, frame.mask.data());
    frame.mask = mask_from_pixels(std::move(frame.mask));
  }
  if (has_labels_) frame.labels = read_labels(row);
  if (!hands_ends_.empty()) frame.hands = read_hands(row, Projection(frame.camera));
  frame.truth = read_truth(row, frame.camera);
  frame.side = read_side(row);
  frame.time_s = timeline_.time_s(index);
  frame.sequence = timeline_.sequence(index);
  require_unchanged();
  return frame;
}

}  // namespace knuckle
