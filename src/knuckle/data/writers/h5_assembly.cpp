// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/h5_assembly.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/frame_sums.h"
#include "knuckle/data/readers/h5_format.h"
#include "knuckle/data/readers/timeline.h"
#include "knuckle/storage/file_io.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

std::string landmark_names() {
  std::vector<std::string> names;
  for (const Landmark landmark : superset_convention().landmarks) names.emplace_back(name_of(landmark));
  return joined(names);
}

/// Collects the small arrays of a file, a row per frame, and writes them many rows at a time.
template <class T>
class RowBlock {
 public:
  RowBlock(Hdf5Writer& file, std::string_view array) : file_(file), array_(array) {}

  template <class Row>
  void add(const Row& row) {
    constexpr std::uint64_t kRowsAtOnce = 4096;
    values_.insert(values_.end(), row.begin(), row.end());
    if (++rows_ == kRowsAtOnce) write();
  }
  void write() {
    if (rows_ > 0) file_.write_rows(array_, first_, rows_, values_.data());
    first_ += std::exchange(rows_, 0);
    values_.clear();
  }

 private:
  Hdf5Writer& file_;
  std::string_view array_;
  std::uint64_t first_ = 0;
  std::uint64_t rows_ = 0;
  std::vector<T> values_;
};

/// All hands of all frames: 300 bytes each.
class HandsOfFrames {
 public:
  void add(const std::vector<StoredHand>& hands) {
    for (const StoredHand& hand : hands) {
      sides_.push_back(hand.side);
      joints_mm_.insert(joints_mm_.end(), hand.joints_mm.begin(), hand.joints_mm.end());
      occluders_.insert(occluders_.end(), hand.occluders.begin(), hand.occluders.end());
      visible_shares_.push_back(hand.visible_share);
    }
    ends_.push_back(std::ssize(sides_));
  }
  /// Nothing where no frame has a hand.
  void write(Hdf5Writer& file) const {
    if (sides_.empty()) return;
    const std::uint64_t count = sides_.size();
    file.write(kH5HandsEnd, {ends_.size()}, ends_.data());
    file.write(kH5HandsSide, {count}, sides_.data());
    file.write(kH5HandsJoints, {count, kSupersetSize, 3}, joints_mm_.data());
    file.write(kH5HandsOccluders, {count, kSupersetSize}, occluders_.data());
    file.write(kH5HandsVisible, {count}, visible_shares_.data());
  }

 private:
  std::vector<std::int64_t> ends_;
  std::vector<std::int8_t> sides_;
  std::vector<float> joints_mm_;
  std::vector<std::uint8_t> occluders_;
  std::vector<double> visible_shares_;
};

std::vector<StoredFrame> read_several(const ReadStoredFrame& read, std::int64_t first, std::int64_t count) {
  std::vector<StoredFrame> frames(static_cast<std::size_t>(count));
  parallel_for(count, [&](std::int64_t i) { frames[static_cast<std::size_t>(i)] = read(first + i); });
  return frames;
}

/// A file in the making.
class H5Assembly {
 public:
  H5Assembly(Hdf5Writer& file, const H5Facts& facts, std::string where)
      : file_(file), facts_(facts), facts_sum_(sum_of_facts(facts)), where_(std::move(where)) {}

  void write(const ReadStoredFrame& read) {
    write_head();
    create_arrays();
    write_frames(read);
    file_.set_attribute("complete", 1);
  }

 private:
  std::uint64_t rows() const { return static_cast<std::uint64_t>(facts_.frames.count); }

  void write_head() {
    file_.set_attribute("format", kH5Format);
    file_.set_attribute("version", kH5Version);
    file_.set_attribute("complete", 0);
    file_.set_attribute("first_index", static_cast<double>(facts_.frames.first));
    if (facts_.part_of) {
      file_.set_attribute(kH5PartOfFirst, static_cast<double>(facts_.part_of->first));
      file_.set_attribute(kH5PartOfCount, static_cast<double>(facts_.part_of->count));
    }
    file_.set_attribute("manifest", facts_.manifest);
    if (!facts_.generator.empty()) file_.set_attribute(kH5Generator, facts_.generator);
    file_.set_attribute("depth_unit_mm", facts_.depth_unit_mm);
    file_.set_attribute("joints_unit", "mm, in camera coordinates: x right, y down, z forward");
    file_.set_attribute("landmarks", landmark_names());
    write_camera(file_, facts_.camera);
  }

  void create_arrays() {
    const std::vector<std::uint64_t> images{rows(), static_cast<std::uint64_t>(facts_.camera.height),
                                            static_cast<std::uint64_t>(facts_.camera.width)};
    constexpr Hdf5Writer::Storage kOneFramePerChunk{1, 1};
    file_.create_dataset<std::uint16_t>(kH5Depth, images, kOneFramePerChunk);
    if (facts_.has_infrared) file_.create_dataset<std::uint16_t>(kH5Infrared, images, kOneFramePerChunk);
    if (facts_.has_mask) file_.create_dataset<std::uint8_t>(kH5Mask, images, kOneFramePerChunk);
    if (facts_.has_labels) file_.create_dataset<std::uint8_t>(kH5Labels, images, kOneFramePerChunk);
    file_.create_dataset<float>(kH5Joints, {rows(), kSupersetSize, 3}, {});
    file_.create_dataset<double>(kH5Intrinsics, {rows(), 4}, {});
    file_.create_dataset<std::int8_t>(kH5Side, {rows()}, {});
    if (facts_.has_time) file_.create_dataset<double>(kH5Time, {rows()}, {});
    file_.create_dataset<std::int32_t>(kH5Sequence, {rows()}, {});
    file_.create_dataset<std::uint64_t>(kH5FrameSums, {rows(), 2}, {});
  }

  void write_frames(const ReadStoredFrame& read) {
    constexpr std::int64_t kFramesAtOnce = 256;
    const std::int64_t count = facts_.frames.count;
    RowBlock<float> joints(file_, kH5Joints);
    RowBlock<double> intrinsics(file_, kH5Intrinsics);
    RowBlock<std::int8_t> sides(file_, kH5Side);
    RowBlock<std::uint64_t> sums(file_, kH5FrameSums);
    HandsOfFrames hands;
    Timeline timeline;
    Progress progress("assemble", "frames", count);
    for (std::int64_t first = 0; first < count; first += kFramesAtOnce) {
      const std::int64_t block = std::min(kFramesAtOnce, count - first);
      std::int64_t index = first;
      for (const StoredFrame& frame : read_several(read, facts_.frames.first + first, block)) {
        write_images(static_cast<std::uint64_t>(index), frame);
        hands.add(frame.hands);
        joints.add(frame.joints_mm);
        intrinsics.add(std::array{frame.camera.fx, frame.camera.fy, frame.camera.cx, frame.camera.cy});
        sides.add(std::array{frame.side});
        const std::int64_t number = facts_.frames.first + index++;
        sums.add(std::array{sum_of_numbers(frame, number, facts_sum_), frame.images_sum});
        if (facts_.has_time) timeline.times_s.push_back(frame.time_s);
        timeline.sequences.push_back(frame.sequence);
        progress.advance();
      }
    }
    joints.write();
    intrinsics.write();
    sides.write();
    sums.write();
    hands.write(file_);
    write_timeline(timeline);
  }

  void write_images(std::uint64_t row, const StoredFrame& frame) {
    file_.write_chunk(kH5Depth, row, frame.depth);
    if (!frame.infrared.empty()) file_.write_chunk(kH5Infrared, row, frame.infrared);
    if (!frame.mask.empty()) file_.write_chunk(kH5Mask, row, frame.mask);
    if (!frame.labels.empty()) file_.write_chunk(kH5Labels, row, frame.labels);
  }

  void write_timeline(const Timeline& timeline) {
    if (const auto fault = fault_of(timeline))
      fail("{}: frame {}: {}", where_, facts_.frames.first + fault->frame, fault->message);
    if (!timeline.times_s.empty()) file_.write_rows(kH5Time, 0, rows(), timeline.times_s.data());
    file_.write_rows(kH5Sequence, 0, rows(), timeline.sequences.data());
  }

  Hdf5Writer& file_;
  const H5Facts& facts_;
  std::uint64_t facts_sum_;
  std::string where_;
};

void write_whole(const fs::path& path, const H5Facts& facts, const std::string& where,
                 const ReadStoredFrame& read) {
  Hdf5Writer file = Hdf5Writer::create(path);
  H5Assembly(file, facts, where).write(read);
  file.close();
}

}  // namespace

void write_camera(Hdf5Writer& file, const Camera& camera) {
  file.set_attribute("pixel_origin", "centre");
  file.set_attribute("camera_model",
                     camera.model == CameraModel::orthographic ? "orthographic" : "projective");
  file.set_attribute("width", camera.width);
  file.set_attribute("height", camera.height);
  file.set_attribute("fx", camera.fx);
  file.set_attribute("fy", camera.fy);
  file.set_attribute("cx", camera.cx);
  file.set_attribute("cy", camera.cy);
  file.set_attribute("distortion", std::vector<double>(camera.distortion.begin(), camera.distortion.end()));
}

void assemble_h5(const fs::path& path, const H5Facts& facts, const ReadStoredFrame& read) {
  fs::path whole = path;
  whole += ".assembled";
  try {
    write_whole(whole, facts, path.string(), read);
    publish_file(whole, path);
  } catch (...) {
    std::error_code ignored;
    fs::remove(whole, ignored);
    throw;
  }
}

}  // namespace knuckle
