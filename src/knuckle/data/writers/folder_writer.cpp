// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/folder_writer.h"

#include <algorithm>
#include <string>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/file_listing.h"
#include "knuckle/data/readers/folder_format.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/data/truth.h"
#include "knuckle/storage/file_io.h"

namespace fs = std::filesystem;

namespace knuckle {

FolderWriter::FolderWriter(fs::path folder, const FrameWriterOptions& options)
    : folder_(std::move(folder)), options_(options), ledger_(folder_.string(), options) {
  if (fs::exists(folder_ / "dataset.toml"))
    fail("{}: already holds a data set; remove it or choose another folder", folder_.string());
  make_folder(folder_ / "depth");
}

void FolderWriter::write(std::int64_t index, const Frame& frame) {
  ledger_.enter(index, frame);
  const std::string name = fmt::format("{:08}.png", index);  // sorts by number
  const fs::path depth = folder_ / "depth" / name;
  write_png(depth, counts_from_depth(frame.depth_mm, options_.depth_unit_mm, depth.string()));
  if (!frame.infrared.empty()) {
    make_folder(folder_ / "infrared");
    write_png(folder_ / "infrared" / name, frame.infrared);
  }
  if (!frame.mask.empty()) {
    constexpr std::uint8_t kWhite = 255;  // visible to a person who looks
    Image<std::uint8_t> mask = mask_from_pixels(frame.mask);
    for (std::uint8_t& pixel : mask.pixels()) pixel *= kWhite;
    make_folder(folder_ / "mask");
    write_png(folder_ / "mask" / name, mask);
  }
  keep(index, frame);
  ledger_.note_written(index);
}

void FolderWriter::keep(std::int64_t index, const Frame& frame) {
  const std::lock_guard lock(mutex_);
  if (frame.truth) {
    if (!convention_) convention_ = frame.truth->convention;
    if (frame.truth->convention != *convention_) {
      fail("{}: frame {} is labelled in {}, frames before in {}", folder_.string(), index,
           frame.truth->convention.name, convention_->name);
    }
  }
  frames_[index] = {frame.truth, frame.side, frame.time_s, frame.sequence};
}

Timeline FolderWriter::timeline() const {
  Timeline timeline;
  for (const auto& [index, frame] : frames_) {
    if (frame.time_s) timeline.times_s.push_back(*frame.time_s);
    timeline.sequences.push_back(frame.sequence);
  }
  return timeline;
}

/// right, left or both; empty where that of any frame is not known.
std::string FolderWriter::side() const {
  const auto all_are = [this](auto&&... sides) {
    return std::ranges::all_of(frames_, [&](const auto& entry) {
      return entry.second.side && ((*entry.second.side == sides) || ...);
    });
  };
  if (all_are(HandSide::right)) return "right";
  if (all_are(HandSide::left)) return "left";
  return all_are(HandSide::right, HandSide::left) ? "both" : "";
}

std::string FolderWriter::joints_as_text() const {
  std::string text;
  for (const auto& [index, frame] : frames_) {
    const HandPose pose = with_pixel_origin(frame.truth.value_or(HandPose::missing(*convention_)),
                                            PixelOrigin::centre, options_.pixel_origin);
    std::string_view blank;
    for (const ImagePoint& joint : pose.joints) {
      text += blank;
      text += joint.is_missing() ? "nan nan nan" : fmt::format("{} {} {}", joint.u, joint.v, joint.depth_mm);
      blank = " ";
    }
    text += '\n';
  }
  return text;
}

void FolderWriter::finish() {
  ledger_.require_complete();
  const auto images = static_cast<std::int64_t>(list_files(folder_ / "depth", "", ".png").size());
  if (images != ledger_.size()) {
    fail("{}: holds {} images, {} were written; the others are of an earlier run: remove them",
         (folder_ / "depth").string(), images, ledger_.size());
  }
  const std::lock_guard lock(mutex_);
  if (convention_) write_text_file(folder_ / "joints.txt", joints_as_text());
  const Timeline times = timeline();
  write_timeline(folder_, times);
  write_text_file(
      folder_ / "dataset.toml",
      folder_description_as_toml({convention_, options_.depth_unit_mm, options_.pixel_origin,
                                  ledger_.layout()->camera, side(), regular_rate_hz(times).value_or(0.0)}));
}

}  // namespace knuckle
