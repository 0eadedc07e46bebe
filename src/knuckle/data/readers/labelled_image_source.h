// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "knuckle/camera/projection.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/labelled_images.h"

namespace knuckle {

/// What the numbers of a label are.
enum class LabelCoordinates {
  camera_mm,  ///< x, y, z in the camera's coordinates [mm], y down
  image,      ///< u, v [px], depth [mm]
};

/// What the images and labels of a published set mean.
struct LabelledImageFormat {
  Camera camera;
  Convention convention;  ///< of the labels: three numbers per landmark, in its order
  LabelCoordinates coordinates = LabelCoordinates::camera_mm;
  std::int32_t first_mark = 65536;  ///< Counts from here on mark pixels without a sure depth
};

/// Frames of 16-bit PNG images in millimetres with labels in one text file; without that file frames have no
/// truth.
class LabelledImageSource : public FrameSource {
 public:
  LabelledImageSource(LabelledImages images, const LabelledImageFormat& format);

  std::int64_t size() const override { return images_.size(); }
  Frame read(std::int64_t index) const override;
  FrameLabel read_label(std::int64_t index) const override;
  std::optional<Convention> convention() const override;

 private:
  LabelledImages::Entry entry(std::int64_t index) const;
  std::optional<HandPose> truth_of(const LabelledImages::Entry& entry) const;

  LabelledImages images_;
  LabelledImageFormat format_;
  Projection projection_;
};

}  // namespace knuckle
