// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/h5_writer.h"

#include <string>
#include <unordered_set>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/file_io.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/text.h"
#include "knuckle/data/depth_image.h"
#include "knuckle/data/h5_format.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

/// Frames between two times that the file is brought up to date on disk: what a kill can cost at most.
constexpr std::size_t kFramesACheckpoint = 256;

/// joints_mm of one frame: the 22 landmarks in camera coordinates.
std::vector<float> joints_in_camera(const Frame& frame) {
  const HandPose missing = HandPose::missing(superset_convention());
  const HandPose pose = frame.truth ? converted(*frame.truth, superset_convention()) : missing;
  const Projection projection(frame.camera);
  std::vector<float> joints_mm;
  for (const ImagePoint& joint : pose.joints) {
    const Point3 point = joint.is_missing() ? Point3::Constant(kNaN) : projection.to_camera(joint);
    for (const double value : point) joints_mm.push_back(static_cast<float>(value));
  }
  return joints_mm;
}

std::string landmark_names() {
  std::vector<std::string> names;
  for (const Landmark landmark : superset_convention().landmarks) names.emplace_back(name_of(landmark));
  return joined(names);
}

}  // namespace

H5Writer::H5Writer(fs::path path, const FrameWriterOptions& options)
    : path_(std::move(path)), partial_(path_), options_(options), ledger_(path_.string(), options) {
  if (options.count < 1) fail("{}: the number of frames must be known before the first", path_.string());
  partial_ += ".partial";
  if (fs::exists(partial_)) {
    resume();
  } else {
    Hdf5File::create(partial_).close();  // a folder that cannot be written shows before any work
  }
}

H5Writer::~H5Writer() {
  try {
    const std::lock_guard lock(mutex_);
    if (file_) mark_pending();
  } catch (const std::exception&) {
    // What could not be marked is written again by the next run.
  }
}

void H5Writer::resume() {
  FrameLayout layout;
  std::unordered_set<std::int64_t> indices;
  try {
    Hdf5File file = Hdf5File::open_for_writing(partial_);
    if (!file.has(kH5Written)) return;  // nothing is in it yet
    file.require_format(kH5Format, kH5Version);
    layout = {read_camera(file), file.has(kH5Infrared), file.has(kH5Mask)};
    const std::vector<std::uint8_t> written = file.read<std::uint8_t>(kH5Written).values;
    for (std::size_t row = 0; row < written.size(); ++row)
      if (written[row] != 0) indices.insert(options_.first + static_cast<std::int64_t>(row));
    file_ = std::move(file);
  } catch (const Error&) {
    return;  // damaged by a kill in mid-write: begin anew
  }
  require_same_run(*file_);
  ledger_.restore(layout, indices);
}

void H5Writer::require_same_run(const Hdf5File& file) const {
  const bool is_same = file.number_attribute("first_index") == static_cast<double>(options_.first) &&
                       file.shape(kH5Written) == std::vector{static_cast<std::uint64_t>(options_.count)} &&
                       file.number_attribute("depth_unit_mm") == options_.depth_unit_mm &&
                       file.text_attribute("manifest") == options_.manifest;
  if (!is_same)
    fail("{}: is left from a run with another manifest or other frames; remove it", partial_.string());
}

void H5Writer::create(const FrameLayout& layout) {
  Hdf5File file = Hdf5File::create(partial_);
  file.set_attribute("format", kH5Format);
  file.set_attribute("version", kH5Version);
  file.set_attribute("complete", 0);
  file.set_attribute("first_index", static_cast<double>(options_.first));
  file.set_attribute("manifest", options_.manifest);
  file.set_attribute("depth_unit_mm", options_.depth_unit_mm);
  file.set_attribute("joints_unit", "mm, in camera coordinates: x right, y down, z forward");
  file.set_attribute("landmarks", landmark_names());
  write_camera(file, layout.camera);

  const auto count = static_cast<std::uint64_t>(options_.count);
  const std::vector<std::uint64_t> images{count, static_cast<std::uint64_t>(layout.camera.height),
                                          static_cast<std::uint64_t>(layout.camera.width)};
  const Hdf5File::Storage a_frame_a_chunk{1, options_.deflate_level};
  file.create_dataset<std::uint16_t>(kH5Depth, images, a_frame_a_chunk);
  if (layout.has_infrared) file.create_dataset<std::uint16_t>(kH5Infrared, images, a_frame_a_chunk);
  if (layout.has_mask) file.create_dataset<std::uint8_t>(kH5Mask, images, a_frame_a_chunk);
  file.create_dataset<float>(kH5Joints, {count, kSupersetSize, 3}, {});
  file.create_dataset<std::uint8_t>(kH5Written, {count}, {});
  file_ = std::move(file);
}

void H5Writer::write_rows(std::uint64_t row, const Frame& frame) {
  const std::string where =
      fmt::format("{}: frame {}", path_.string(), options_.first + static_cast<std::int64_t>(row));
  const Image<std::uint16_t> counts = counts_from_depth(frame.depth_mm, options_.depth_unit_mm, where);
  const std::vector<float> joints_mm = joints_in_camera(frame);
  file_->write_rows(kH5Depth, row, 1, counts.data());
  if (!frame.infrared.empty()) file_->write_rows(kH5Infrared, row, 1, frame.infrared.data());
  if (!frame.mask.empty()) file_->write_rows(kH5Mask, row, 1, mask_from_pixels(frame.mask).data());
  file_->write_rows(kH5Joints, row, 1, joints_mm.data());
}

void H5Writer::write(std::int64_t index, const Frame& frame) {
  ledger_.enter(index, frame);
  {
    const std::lock_guard lock(mutex_);
    if (!file_) create(*ledger_.layout());
  }
  write_rows(static_cast<std::uint64_t>(index - options_.first), frame);
  const std::lock_guard lock(mutex_);
  ledger_.note_written(index);
  pending_.push_back(index);
  if (pending_.size() >= kFramesACheckpoint) mark_pending();
}

void H5Writer::mark_pending() {
  file_->flush();
  constexpr std::uint8_t kYes = 1;
  for (const std::int64_t index : pending_)
    file_->write_rows(kH5Written, static_cast<std::uint64_t>(index - options_.first), 1, &kYes);
  pending_.clear();
}

void H5Writer::finish() {
  ledger_.require_complete();
  const std::lock_guard lock(mutex_);
  mark_pending();
  file_->set_attribute("complete", 1);
  file_->close();
  file_.reset();
  publish_file(partial_, path_);
}

}  // namespace knuckle
