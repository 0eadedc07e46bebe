// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/icvl_source.h"

namespace knuckle {
namespace {

LabelledImageFormat icvl_format() {
  return {.camera = {CameraModel::projective, 320, 240, 240.99, 240.96, 160.0, 120.0, {}},
          .convention = convention_from_name("icvl16"),
          .coordinates = LabelCoordinates::image,
          .first_mark = 32000};  // by the camera's driver, far beyond its range
}

}  // namespace

IcvlSource::IcvlSource(const std::filesystem::path& folder, const IcvlOptions& options)
    : LabelledImageSource(
          {subfolder_or_self(folder, "Depth"), find_annotation(folder, options.labels, "labels.txt")},
          icvl_format()) {}

}  // namespace knuckle
