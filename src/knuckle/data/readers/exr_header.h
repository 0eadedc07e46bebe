// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace knuckle {

/// Looks through the header of an EXR file (all headers, where it has several parts) before OpenEXR does,
/// which takes as much memory as attributes, thumbnails and tables of tiles say, whether the file holds it or
/// not. Throws an Error that names the file where it asks for more than it can hold, or is no EXR file.
/// OpenEXR File Layout, "Headers".
void check_exr_header(const std::filesystem::path& path);

}  // namespace knuckle
