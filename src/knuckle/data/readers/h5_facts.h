// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "knuckle/core/camera.h"
#include "knuckle/core/shard.h"

namespace knuckle {

/// What a Knuckle dataset says of all its frames.
struct H5Facts {
  IndexRange frames;                       ///< by the numbers that they have in the whole set
  std::optional<IndexRange> part_of = {};  ///< that whole, where the file is a part of a set made in several
  std::string manifest;                    ///< how they were made
  std::string generator;                   ///< by which program; empty where it is not known
  double depth_unit_mm = 0.1;
  Camera camera;  ///< of the first frame
  bool has_infrared = false;
  bool has_mask = false;
  bool has_labels = false;
  bool has_time = false;
};

}  // namespace knuckle
