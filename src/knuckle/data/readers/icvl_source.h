// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "knuckle/core/options.h"
#include "knuckle/data/readers/labelled_image_source.h"

namespace knuckle {

/// Settings of an `icvl:` source.
struct IcvlOptions {
  std::string labels;  ///< name of the label file; empty: labels.txt where there is one

  void visit(OptionVisitor& visitor) { visitor.text("labels", labels); }
};

/// The ICVL hand posture set (Tang et al. 2014), 320x240: 16-bit PNG in mm below `Depth/` (or the folder
/// itself) and a label file with a line per frame, the image's relative path and 16 x (u, v, d). Without that
/// file frames have no truth. Its intrinsics are those of the published evaluations.
class IcvlSource final : public LabelledImageSource {
 public:
  IcvlSource(const std::filesystem::path& folder, const IcvlOptions& options);
};

}  // namespace knuckle
