// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/core/image.h"

namespace knuckle {

/// Reads an image from rows of numbers parted by commas; one at the end of a row is allowed. Throws an Error
/// that names file and line where a row is not a row of numbers or not as long as the first.
Image<float> read_csv_image(const std::filesystem::path& path);

/// Writes such a file; it appears only when whole. The numbers are the shortest that read back as the same
/// floats.
void write_csv_image(const std::filesystem::path& path, const Image<float>& image);

}  // namespace knuckle
