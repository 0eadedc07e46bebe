// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/h5_writer.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/h5_format.h"
#include "knuckle/storage/file_io.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

fs::path with_suffix(fs::path path, std::string_view suffix) {
  path += suffix;
  return path;
}

/// All that the frames of a run depend on.
std::string identity_of(const FrameWriterOptions& options) {
  return fmt::format("with hands and labels\nfirst {}\ncount {}\ndepth_unit_mm {}\n{}", options.first,
                     options.count, options.depth_unit_mm, options.manifest);
}

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

H5Writer::H5Writer(fs::path path, const FrameWriterOptions& options)
    : path_(std::move(path)),
      options_(options),
      ledger_(path_.string(), options, FrameCameras::of_one_size),
      log_(with_suffix(path_, ".partial"), identity_of(options)) {
  restore();
}

void H5Writer::restore() {
  const std::vector<std::int64_t> indices = log_.indices();
  if (indices.empty()) return;
  const StoredFrame frame = stored_frame_from(log_.read(indices.front()));
  ledger_.restore({frame.camera, !frame.infrared.empty(), !frame.mask.empty(), !frame.labels.empty(),
                   !std::isnan(frame.time_s)},
                  indices);
}

/// Of the frames of the set.
std::int64_t H5Writer::count() const {
  return options_.count > 0 ? options_.count : ledger_.size();
}

void H5Writer::write(std::int64_t index, const Frame& frame) {
  ledger_.enter(index, frame);
  const std::string where = fmt::format("{}: frame {}", path_.string(), index);
  log_.append(index, to_bytes(stored_frame(frame, options_.depth_unit_mm, where)));
  ledger_.note_written(index);
}

void H5Writer::create_arrays(Hdf5Writer& file) const {
  const FrameLayout layout = *ledger_.layout();
  const auto rows = static_cast<std::uint64_t>(count());
  const std::vector<std::uint64_t> images{rows, static_cast<std::uint64_t>(layout.camera.height),
                                          static_cast<std::uint64_t>(layout.camera.width)};
  constexpr Hdf5Writer::Storage kOneFramePerChunk{1, 1};
  file.create_dataset<std::uint16_t>(kH5Depth, images, kOneFramePerChunk);
  if (layout.has_infrared) file.create_dataset<std::uint16_t>(kH5Infrared, images, kOneFramePerChunk);
  if (layout.has_mask) file.create_dataset<std::uint8_t>(kH5Mask, images, kOneFramePerChunk);
  if (layout.has_labels) file.create_dataset<std::uint8_t>(kH5Labels, images, kOneFramePerChunk);
  file.create_dataset<float>(kH5Joints, {rows, kSupersetSize, 3}, {});
  file.create_dataset<double>(kH5Intrinsics, {rows, 4}, {});
  file.create_dataset<std::int8_t>(kH5Side, {rows}, {});
  if (layout.has_time) file.create_dataset<double>(kH5Time, {rows}, {});
  file.create_dataset<std::int32_t>(kH5Sequence, {rows}, {});
}

std::vector<StoredFrame> H5Writer::read_back(std::int64_t first, std::int64_t count) const {
  std::vector<StoredFrame> frames(static_cast<std::size_t>(count));
  parallel_for(count, [&](std::int64_t i) {
    frames[static_cast<std::size_t>(i)] = stored_frame_from(log_.read(options_.first + first + i));
  });
  return frames;
}

void H5Writer::write_frames(Hdf5Writer& file) const {
  constexpr std::int64_t kFramesAtOnce = 256;
  const bool has_time = ledger_.layout()->has_time;
  RowBlock<float> joints(file, kH5Joints);
  RowBlock<double> intrinsics(file, kH5Intrinsics);
  RowBlock<std::int8_t> sides(file, kH5Side);
  HandsOfFrames hands;
  Timeline timeline;
  Progress progress("assemble", "frames", count());
  for (std::int64_t first = 0; first < count(); first += kFramesAtOnce) {
    std::int64_t index = first;
    for (const StoredFrame& frame : read_back(first, std::min(kFramesAtOnce, count() - first))) {
      const auto row = static_cast<std::uint64_t>(index++);
      file.write_chunk(kH5Depth, row, frame.depth);
      if (!frame.infrared.empty()) file.write_chunk(kH5Infrared, row, frame.infrared);
      if (!frame.mask.empty()) file.write_chunk(kH5Mask, row, frame.mask);
      if (!frame.labels.empty()) file.write_chunk(kH5Labels, row, frame.labels);
      hands.add(frame.hands);
      joints.add(frame.joints_mm);
      intrinsics.add(std::array{frame.camera.fx, frame.camera.fy, frame.camera.cx, frame.camera.cy});
      sides.add(std::array{frame.side});
      if (has_time) timeline.times_s.push_back(frame.time_s);
      timeline.sequences.push_back(frame.sequence);
      progress.advance();
    }
  }
  joints.write();
  intrinsics.write();
  sides.write();
  hands.write(file);
  write_timeline(file, timeline);
}

void H5Writer::write_timeline(Hdf5Writer& file, const Timeline& timeline) const {
  if (const auto fault = fault_of(timeline))
    fail("{}: frame {}: {}", path_.string(), options_.first + fault->frame, fault->message);
  const auto rows = static_cast<std::uint64_t>(count());
  if (!timeline.times_s.empty()) file.write_rows(kH5Time, 0, rows, timeline.times_s.data());
  file.write_rows(kH5Sequence, 0, rows, timeline.sequences.data());
}

void H5Writer::write_whole(const fs::path& path) const {
  Hdf5Writer file = Hdf5Writer::create(path);
  file.set_attribute("format", kH5Format);
  file.set_attribute("version", kH5Version);
  file.set_attribute("complete", 0);
  file.set_attribute("first_index", static_cast<double>(options_.first));
  file.set_attribute("manifest", options_.manifest);
  file.set_attribute("depth_unit_mm", options_.depth_unit_mm);
  file.set_attribute("joints_unit", "mm, in camera coordinates: x right, y down, z forward");
  file.set_attribute("landmarks", landmark_names());
  write_camera(file, stored_frame_from(log_.read(options_.first)).camera);
  create_arrays(file);
  write_frames(file);
  file.set_attribute("complete", 1);
  file.close();
}

void H5Writer::finish() {
  ledger_.require_complete();
  for (std::int64_t i = 0; i < count(); ++i) {
    if (!has(options_.first + i)) fail("{}: frame {} was not written", path_.string(), options_.first + i);
  }
  const fs::path whole = with_suffix(path_, ".assembled");
  try {
    write_whole(whole);
    publish_file(whole, path_);
  } catch (...) {
    std::error_code ignored;
    fs::remove(whole, ignored);  // the log keeps the frames
    throw;
  }
  log_.remove();
}

}  // namespace knuckle
