// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "knuckle/prepare/inputs.h"
#include "knuckle/prepare/network_samples.h"

namespace knuckle {

/// What is known of a block of samples without reading it.
struct SampleBlockNote {
  SampleFrames frames;      ///< that it was cut from; those used are its samples
  std::int64_t bytes = 0;   ///< of its file; 0: it has no sample, and no file
  std::vector<bool> known;  ///< which joints are known in at least one sample
};

/// Writes the notes of all blocks of a set as an HDF5 file, "knuckle-sample-index" version 1, atomically.
/// Throws an Error that names the file where it cannot be written.
void write_block_index(const std::filesystem::path& path, const std::vector<SampleBlockNote>& blocks,
                       const Inputs& inputs);

/// Reads them. Throws an Error that names the file where it is damaged, foreign or of other inputs, or its
/// samples have not that many joints.
std::vector<SampleBlockNote> read_block_index(const std::filesystem::path& path, const Inputs& inputs,
                                              int joint_count);

}  // namespace knuckle
