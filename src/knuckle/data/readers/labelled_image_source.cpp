// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/labelled_image_source.h"

#include <utility>

#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/file_listing.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/data/truth.h"

namespace knuckle {

LabelledImageSource::LabelledImageSource(LabelledImages images, const LabelledImageFormat& format)
    : images_(std::move(images)), format_(format), projection_(format_.camera) {}

std::optional<Convention> LabelledImageSource::convention() const {
  if (!images_.has_labels()) return std::nullopt;
  return format_.convention;
}

LabelledImages::Entry LabelledImageSource::entry(std::int64_t index) const {
  constexpr std::size_t kNumbersPerLandmark = 3;
  return images_.read(index, kNumbersPerLandmark * format_.convention.landmarks.size());
}

std::optional<HandPose> LabelledImageSource::truth_of(const LabelledImages::Entry& entry) const {
  if (!images_.has_labels()) return std::nullopt;
  return known_or_nothing(format_.coordinates == LabelCoordinates::camera_mm
                              ? pose_from_camera(format_.convention, entry.numbers, projection_)
                              : pose_from_uvd(format_.convention, entry.numbers));
}

FrameLabel LabelledImageSource::read_label(std::int64_t index) const {
  const LabelledImages::Entry image = entry(index);
  return {format_.camera, truth_of(image), std::nullopt, 0, without_extension(image.name)};
}

Frame LabelledImageSource::read(std::int64_t index) const {
  const LabelledImages::Entry image = entry(index);
  Frame frame;
  frame.name = without_extension(image.name);
  frame.camera = format_.camera;
  Image<std::uint16_t> counts =
      read_png16(image.path, ImageSize{format_.camera.width, format_.camera.height});
  for (std::uint16_t& count : counts.pixels())
    if (count >= format_.first_mark) count = 0;
  frame.depth_mm = depth_from_counts(counts, 1.0);
  frame.truth = truth_of(image);
  return frame;
}

}  // namespace knuckle
