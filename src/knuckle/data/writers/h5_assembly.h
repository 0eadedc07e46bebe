// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "knuckle/data/readers/h5_facts.h"
#include "knuckle/data/readers/stored_frame.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

namespace knuckle {

/// A frame by its number in the whole set; called by many threads.
using ReadStoredFrame = std::function<StoredFrame(std::int64_t)>;

/// Writes the frames that `facts` tell of as a Knuckle dataset, whose bytes depend on these alone. The file
/// appears under its name when it is whole. Throws an Error that names it where it cannot be written or the
/// frames' times go back.
void assemble_h5(const std::filesystem::path& path, const H5Facts& facts, const ReadStoredFrame& read);

/// The camera of the first frame as attributes of the file.
void write_camera(Hdf5Writer& file, const Camera& camera);

}  // namespace knuckle
