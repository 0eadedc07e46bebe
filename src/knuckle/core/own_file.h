// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace knuckle {

/// The shared library that contains this function, or the program where it was linked into that; empty where
/// the system does not tell.
std::filesystem::path own_file();

}  // namespace knuckle
