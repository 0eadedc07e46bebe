// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/folder_source.h"

#include <utility>

#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/file_listing.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/data/truth.h"

namespace fs = std::filesystem;

namespace knuckle {

FolderSource::FolderSource(fs::path folder) : folder_(std::move(folder)) {
  require_folder(folder_);
  description_ = read_folder_description(folder_ / "dataset.toml");
  names_ = list_files(folder_ / "depth", "", ".png");
  if (names_.empty()) fail("{}: holds no .png file", (folder_ / "depth").string());
  has_infrared_ = fs::is_directory(folder_ / "infrared");
  has_mask_ = fs::is_directory(folder_ / "mask");
  timeline_ = read_timeline(folder_, size(), description_.rate_hz);

  const fs::path joints = folder_ / "joints.txt";
  if (!fs::exists(joints)) return;
  if (!description_.convention)
    fail("{}: lacks 'convention', which joints.txt needs", (folder_ / "dataset.toml").string());
  joints_.emplace(joints);
  if (joints_->size() != size())
    fail("{}: has {} lines, but there are {} depth images", joints.string(), joints_->size(), size());
}

std::optional<Convention> FolderSource::convention() const {
  return joints_ ? description_.convention : std::nullopt;
}

std::optional<HandPose> FolderSource::read_truth(std::int64_t index) const {
  if (!joints_) return std::nullopt;
  const Convention& convention = *description_.convention;
  const std::vector<double> uvd =
      parse_annotation(joints_->line(index), 3 * convention.landmarks.size(), joints_->where(index));
  return known_or_nothing(
      with_pixel_origin(pose_from_uvd(convention, uvd), description_.pixel_origin, PixelOrigin::centre));
}

FrameLabel FolderSource::read_label(std::int64_t index) const {
  return {description_.camera,
          read_truth(index),
          timeline_.time_s(index),
          timeline_.sequence(index),
          without_extension(names_.at(static_cast<std::size_t>(index))),
          description_.hand_side()};
}

Frame FolderSource::read(std::int64_t index) const {
  const std::string& name = names_.at(static_cast<std::size_t>(index));
  const ImageSize size{description_.camera.width, description_.camera.height};
  Frame frame;
  frame.name = without_extension(name);
  frame.camera = description_.camera;
  frame.depth_mm = depth_from_counts(read_png16(folder_ / "depth" / name, size), description_.depth_unit_mm);
  if (has_infrared_) frame.infrared = read_png8_or_16(folder_ / "infrared" / name, size);
  if (has_mask_) frame.mask = mask_from_pixels(read_png8(folder_ / "mask" / name, size));
  frame.truth = read_truth(index);
  frame.side = description_.hand_side();
  frame.time_s = timeline_.time_s(index);
  frame.sequence = timeline_.sequence(index);
  return frame;
}

}  // namespace knuckle
