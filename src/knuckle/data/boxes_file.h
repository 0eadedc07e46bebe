// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "knuckle/core/box.h"

namespace knuckle {

/// Reads the CSV that `segment` writes: frame,found,x,y,width,height,milliseconds, a line per frame, in
/// order. A frame in which nothing was found has an empty box. Throws an Error that names file and line where
/// one is damaged.
std::vector<Box> read_boxes_file(const std::filesystem::path& path);

}  // namespace knuckle
