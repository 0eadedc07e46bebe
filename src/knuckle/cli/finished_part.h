// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/data/writers/frame_writer.h"

namespace knuckle::cli {

/// Whether the file is the part of a set that is to be made, so that whoever renders it again does not lose
/// it. All of it is read: one that is broken is told of and set aside as `OUT.broken`, to be made anew.
/// Throws an Error where the file is whole, but another part or of another set.
bool is_part_finished(const std::filesystem::path& out, const FrameWriterOptions& options);

}  // namespace knuckle::cli
