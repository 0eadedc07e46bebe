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
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/frame_log.h"
#include "knuckle/data/readers/frame_sums.h"
#include "knuckle/data/readers/h5_format.h"
#include "knuckle/data/truth.h"
#include "knuckle/storage/deflate.h"

namespace knuckle {
namespace {

constexpr std::uint64_t kIntrinsicsPerFrame = 4;
constexpr std::uint64_t kSumsPerFrame = 2;

Hdf5File open_whole(const std::filesystem::path& path) {
  constexpr std::string_view kUnfinished = "{}: is unfinished; let the run that writes it end";
  if (is_frame_log(path)) fail(kUnfinished, path.string());
  Hdf5File file = Hdf5File::open(path);
  const int version = file.require_format(kH5Format, kH5Version);
  if (version >= kH5VersionWithSums && !file.has(kH5FrameSums))
    fail("{}: {}: the array is missing; the file is damaged", path.string(), kH5FrameSums);
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

HandTruth hand_truth(const StoredHand& hand, const Projection& projection, std::string_view where) {
  HandTruth truth;
  const std::optional<HandSide> side = side_of(hand.side, where);
  if (!side) fail("{}: one of its hands has no side", where);
  truth.side = *side;
  const std::vector<double> xyz(hand.joints_mm.begin(), hand.joints_mm.end());
  check_coordinates(xyz, fmt::format("{}: {}", where, kH5HandsJoints));
  truth.pose = pose_from_camera(superset_convention(), xyz, projection);
  for (const std::uint8_t occluder : hand.occluders) {
    if (occluder > static_cast<std::uint8_t>(Occluder::border)) {
      fail("{}: {}: holds {}, expected 0 to {}", where, kH5HandsOccluders, occluder,
           static_cast<int>(Occluder::border));
    }
    truth.occluders.push_back(static_cast<Occluder>(occluder));
  }
  truth.visible_share = hand.visible_share;
  if (!(truth.visible_share >= 0.0 && truth.visible_share <= 1.0))
    fail("{}: {}: is {}, expected 0 to 1", where, kH5HandsVisible, truth.visible_share);
  return truth;
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
      has_labels_(file_.has(kH5Labels)),
      has_sums_(file_.has(kH5FrameSums)) {
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
  if (has_sums_) require_shape(kH5FrameSums, {count, kSumsPerFrame});
  size_ = static_cast<std::int64_t>(count);
  timeline_ = read_timeline();
  if (file_.has(kH5HandsEnd)) read_hands_ends();
  if (has_sums_) facts_sum_ = sum_of_facts(facts_of_all());
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

template <class T>
Image<T> H5Source::read_image(std::string_view array, std::uint64_t row) const {
  Image<T> pixels(camera_.width, camera_.height);
  file_.read_rows(array, row, 1, pixels.data());
  return pixels;
}

Image<std::uint8_t> H5Source::read_labels(std::uint64_t row) const {
  Image<std::uint8_t> labels = read_image<std::uint8_t>(kH5Labels, row);
  constexpr auto kLast = static_cast<std::uint8_t>(PixelLabel::object);
  const auto worst = std::ranges::max(labels.pixels());
  if (worst > kLast) {
    fail("{}: {}: frame {}: a pixel has the label {}, expected 0 to {}", file_.path().string(), kH5Labels,
         row, worst, kLast);
  }
  return labels;
}

StoredImages H5Source::read_images(std::uint64_t row) const {
  StoredImages images{.depth = read_image<std::uint16_t>(kH5Depth, row)};
  if (has_infrared_) images.infrared = read_image<std::uint16_t>(kH5Infrared, row);
  if (has_mask_) images.mask = read_image<std::uint8_t>(kH5Mask, row);
  if (has_labels_) images.labels = read_labels(row);
  return images;
}

std::vector<StoredHand> H5Source::read_stored_hands(std::uint64_t row) const {
  std::vector<StoredHand> hands;
  if (hands_ends_.empty()) return hands;
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

/// All of a frame but its images, as it stands in the file.
StoredFrame H5Source::read_numbers(std::uint64_t row) const {
  const auto index = static_cast<std::int64_t>(row);
  StoredFrame numbers;
  numbers.camera = read_frame_camera(row);
  numbers.side = code_of(std::nullopt);
  if (has_side_) file_.read_rows(kH5Side, row, 1, &numbers.side);
  numbers.time_s = timeline_.time_s(index).value_or(kNaN);
  numbers.sequence = timeline_.sequence(index);
  numbers.joints_mm.fill(std::numeric_limits<float>::quiet_NaN());
  if (has_joints_) file_.read_rows(kH5Joints, row, 1, numbers.joints_mm.data());
  numbers.hands = read_stored_hands(row);
  return numbers;
}

/// That a frame is what was written. What is impossible was refused before, in words that say more.
void H5Source::check_sums(std::uint64_t row, const StoredFrame& numbers, const StoredImages* images) const {
  require_unchanged();
  if (!has_sums_) return;
  std::array<std::uint64_t, kSumsPerFrame> sums{};
  file_.read_rows(kH5FrameSums, row, 1, sums.data());
  const auto require = [&](bool is_right, std::string_view what) {
    if (is_right) return;
    fail("{}: frame {}: its {} are not those that were written; the file is damaged: make or copy it again",
         file_.path().string(), row, what);
  };
  const std::int64_t number = first_index_ + static_cast<std::int64_t>(row);
  require(is_sum(sum_of_numbers(numbers, number, facts_sum_), sums[0]), "numbers");
  if (images != nullptr) require(is_sum(sum_of_images(*images), sums[1]), "images");
}

FrameLabel H5Source::label_of(std::uint64_t row, const StoredFrame& numbers) const {
  const auto index = static_cast<std::int64_t>(row);
  FrameLabel label{.camera = numbers.camera, .truth = std::nullopt};
  label.name = name_of(index);
  label.time_s = timeline_.time_s(index);
  label.sequence = numbers.sequence;
  label.side = side_of(numbers.side, fmt::format("{}: frame {}", file_.path().string(), row));
  if (has_joints_) {
    const std::vector<double> xyz(numbers.joints_mm.begin(), numbers.joints_mm.end());
    check_coordinates(xyz, fmt::format("{}: {}: frame {}", file_.path().string(), kH5Joints, row));
    label.truth = known_or_nothing(pose_from_camera(superset_convention(), xyz, Projection(numbers.camera)));
  }
  return label;
}

std::vector<HandTruth> H5Source::hands_of(std::uint64_t row, const StoredFrame& numbers) const {
  std::vector<HandTruth> hands;
  const std::string where = fmt::format("{}: frame {}", file_.path().string(), row);
  const Projection projection(numbers.camera);
  for (const StoredHand& hand : numbers.hands) hands.push_back(hand_truth(hand, projection, where));
  return hands;
}

H5Facts H5Source::facts_of_all() const {
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
  if (file_.has_attribute(kH5Generator)) facts.generator = file_.text_attribute(kH5Generator);
  facts.depth_unit_mm = depth_unit_mm_;
  facts.camera = camera_;
  facts.has_infrared = has_infrared_;
  facts.has_mask = has_mask_;
  facts.has_labels = has_labels_;
  facts.has_time = !timeline_.times_s.empty();
  return facts;
}

H5Facts H5Source::facts() const {
  H5Facts facts = facts_of_all();
  facts.camera = read_frame_camera(0);
  return facts;
}

StoredFrame H5Source::read_stored(std::int64_t index) const {
  const std::uint64_t row = row_of(index);
  StoredFrame stored = read_numbers(row);
  const StoredImages images = read_images(row);
  (void)label_of(row, stored);  // throws where something is impossible
  (void)hands_of(row, stored);
  check_sums(row, stored, &images);
  pack(images, stored);
  return stored;
}

std::string H5Source::name_of(std::int64_t index) const {
  return fmt::format("{:08}", first_index_ + index);
}

FrameLabel H5Source::read_label(std::int64_t index) const {
  const std::uint64_t row = row_of(index);
  const StoredFrame numbers = read_numbers(row);
  FrameLabel label = label_of(row, numbers);
  check_sums(row, numbers, nullptr);
  return label;
}

Frame H5Source::read(std::int64_t index) const {
  const std::uint64_t row = row_of(index);
  const StoredFrame numbers = read_numbers(row);
  StoredImages images = read_images(row);
  FrameLabel label = label_of(row, numbers);
  Frame frame;
  frame.hands = hands_of(row, numbers);
  check_sums(row, numbers, &images);
  frame.name = std::move(label.name);
  frame.camera = label.camera;
  frame.truth = std::move(label.truth);
  frame.side = label.side;
  frame.time_s = label.time_s;
  frame.sequence = label.sequence;
  frame.depth_mm = depth_from_counts(images.depth, depth_unit_mm_);
  frame.infrared = std::move(images.infrared);
  if (has_mask_) frame.mask = mask_from_pixels(std::move(images.mask));
  frame.labels = std::move(images.labels);
  return frame;
}

H5Facts check_h5(const std::filesystem::path& path) {
  const H5Source source(path);
  H5Facts facts = source.facts();
  Progress progress("check", "frames", source.size());
  parallel_for(source.size(), [&](std::int64_t index) {
    (void)source.read(index);
    progress.advance();
  });
  return facts;
}

}  // namespace knuckle
