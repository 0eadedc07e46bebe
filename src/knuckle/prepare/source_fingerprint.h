// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace knuckle {

/// A hash of what a source is made from, cheap to compute: its kind, selection and settings, and of its file,
/// or of all files below its folder, the name, size and time of writing (of a synthetic source: the
/// manifest's content, and the body). Where it is the same again, so are the frames, unless somebody took
/// pains. Where the source lies does not matter. Hidden files and those in `except` do not count: a run may
/// write into the folder that it reads. Throws an Error that names what is missing.
std::string source_fingerprint(const std::string& source, std::span<const std::filesystem::path> except = {});

}  // namespace knuckle
