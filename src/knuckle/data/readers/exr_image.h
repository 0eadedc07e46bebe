// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/core/image.h"

namespace knuckle {

/// Reads the depth channel of an OpenEXR image: Z, V, Y or R where there is one of these, otherwise the first
/// in the file (renderers write depth under each of these names). Values are as stored, whatever they mean.
/// Throws an Error that names the file where it is missing, cut short, no EXR, or its channel holds whole
/// numbers.
Image<float> read_exr(const std::filesystem::path& path);

/// Writes one float channel, named R as Blender's compositor names the first of a depth output. The file
/// appears only when whole.
void write_exr(const std::filesystem::path& path, const Image<float>& image);

}  // namespace knuckle
