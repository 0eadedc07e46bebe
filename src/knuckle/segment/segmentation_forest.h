// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/forest/pixel_forest.h"

namespace knuckle {

/// Writes a forest that tells hands (class 1) from all else as a file (storage/model_file.h) of format
/// "knuckle-forest", version 2, kind "segmentation"; it appears only when whole.
void save_segmentation_forest(const std::filesystem::path& path, const PixelForest& forest);

/// Reads it back. Throws an Error that names the file where it is missing, cut short, foreign, of another
/// version or kind, or where its parts do not fit together.
PixelForest load_segmentation_forest(const std::filesystem::path& path);
/// The same of a file that is open.
PixelForest read_segmentation_forest(const ModelFile& file);

}  // namespace knuckle
