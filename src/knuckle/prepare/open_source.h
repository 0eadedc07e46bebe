// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/frame_stream.h"

namespace knuckle {

/// Opens any source, `KIND:PATH[?key=value&...]`: a data set on disk, or `synthetic:manifest.toml`. Throws an
/// Error that lists the kinds where it is none of them.
std::unique_ptr<FrameSource> open_source(std::string_view text);

/// Opens any stream: a source as `open_source` takes it, with the settings of PlayOptions beside its own,
/// played as a camera would give its frames; or a camera, as `open_camera` takes it.
std::unique_ptr<FrameStream> open_stream(std::string_view text);

/// Names of all kinds of source.
std::vector<std::string> source_kinds();

/// Whether the text starts with a kind of source and a colon (and is not, say, a file's name).
bool names_a_source(std::string_view text);

/// The source that a file names under `key`; a relative path in it starts at the file's folder. Throws an
/// Error where the key is missing.
std::string source_in(const OptionTable& document, std::string_view key);

}  // namespace knuckle
