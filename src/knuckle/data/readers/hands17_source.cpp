// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/hands17_source.h"

namespace knuckle {
namespace {

LabelledImageFormat hands17_format() {
  return {.camera = {CameraModel::projective, 640, 480, 475.065948, 475.065857, 315.944855, 245.287079, {}},
          .convention = convention_from_name("hands21")};
}

}  // namespace

Hands17Source::Hands17Source(const std::filesystem::path& folder, const Hands17Options& options)
    : LabelledImageSource({subfolder_or_self(folder, "images"),
                           find_annotation(folder, options.annotation, "Training_Annotation.txt")},
                          hands17_format()) {}

}  // namespace knuckle
