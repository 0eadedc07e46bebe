// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/icvl_source.h"

#include "knuckle/core/image_io.h"
#include "knuckle/data/depth_image.h"
#include "knuckle/data/file_listing.h"
#include "knuckle/data/truth.h"

namespace knuckle {
namespace {

constexpr Camera kIcvlCamera{CameraModel::projective, 320, 240, 240.99, 240.96, 160.0, 120.0, {}};
constexpr std::size_t kValuesAIcvlFrame = 48;
/// The camera's driver marks pixels without a sure depth by values from 32000 on, far beyond its range.
constexpr std::uint16_t kFirstMark = 32000;

}  // namespace

IcvlSource::IcvlSource(const std::filesystem::path& folder, const IcvlOptions& options)
    : images_(subfolder_or_self(folder, "Depth"), find_annotation(folder, options.labels, "labels.txt")) {}

std::optional<Convention> IcvlSource::convention() const {
  if (!images_.has_labels()) return std::nullopt;
  return convention_from_name("icvl16");
}

std::optional<HandPose> IcvlSource::truth_of(const LabelledImages::Entry& entry) const {
  if (!images_.has_labels()) return std::nullopt;
  return known_or_nothing(pose_from_uvd(convention_from_name("icvl16"), entry.numbers));
}

FrameLabel IcvlSource::read_label(std::int64_t index) const {
  return {kIcvlCamera, truth_of(images_.read(index, kValuesAIcvlFrame))};
}

Frame IcvlSource::read(std::int64_t index) const {
  const LabelledImages::Entry entry = images_.read(index, kValuesAIcvlFrame);
  Frame frame;
  frame.name = without_extension(entry.name);
  frame.camera = kIcvlCamera;
  Image<std::uint16_t> counts = read_png16(entry.path);
  require_size(counts, kIcvlCamera.width, kIcvlCamera.height, entry.path);
  for (std::uint16_t& count : counts.pixels())
    if (count >= kFirstMark) count = 0;
  frame.depth_mm = depth_from_counts(counts, 1.0);
  frame.truth = truth_of(entry);
  return frame;
}

}  // namespace knuckle
