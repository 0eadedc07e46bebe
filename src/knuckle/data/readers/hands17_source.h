// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "knuckle/core/options.h"
#include "knuckle/data/readers/labelled_image_source.h"

namespace knuckle {

/// Settings of a `hands17:` source.
struct Hands17Options {
  std::string annotation;  ///< name of the annotation file; empty: Training_Annotation.txt where there is one

  void visit(OptionVisitor& visitor) { visitor.text("annotation", annotation); }
};

/// The HANDS 2017 challenge set, from BigHand2.2M (Yuan et al. 2017), 640x480: 16-bit PNG in mm, in the
/// folder or its `images/`; an annotation file with a line per frame, the image's name and 21 x (x, y, z) mm,
/// y down. Without that file frames have no truth.
class Hands17Source final : public LabelledImageSource {
 public:
  Hands17Source(const std::filesystem::path& folder, const Hands17Options& options);
};

}  // namespace knuckle
