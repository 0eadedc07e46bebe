// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "knuckle/data/frame_source.h"
#include "knuckle/hand/body.h"
#include "knuckle/synth/manifest.h"

namespace knuckle {

/// Frames rendered as they are read: nothing lies on the disk. A frame is a function of (manifest, index)
/// alone, to the bit, in any order and on any number of threads. Truth: the 22 landmarks (`knuckle22`) and
/// the hand's mask. Smooth motion is one sequence; without motion each frame is a sequence of its own. Throws
/// an Error that names the file where the manifest is faulty or its body is missing.
std::unique_ptr<FrameSource> open_synthetic(const std::filesystem::path& manifest);

/// The body that a manifest names: its file, or MakeHuman's. Throws an Error that names what is missing.
Body body_of(const Manifest& manifest);

/// The same of a manifest and a body in memory.
std::unique_ptr<FrameSource> create_synthetic(const Manifest& manifest, std::shared_ptr<const Body> body);

}  // namespace knuckle
