// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/prepare/inputs.h"
#include "knuckle/prepare/network_samples.h"

namespace knuckle {

/// Writes training samples as an HDF5 file, "knuckle-samples" version 1, atomically: `codes` N x crop x crop
/// (deflated), `joints` N x J x 3, `centres_mm` N x 3 as CubeSample has them, and the attributes `patch`
/// (size [px], side [mm]), `frames` (total, without a hand, off centre) and `inputs` (their hash). Throws an
/// Error that names the file where it cannot be written.
void write_samples(const std::filesystem::path& path, const NetworkSamples& samples, const Inputs& inputs);

/// Reads what `write_samples` wrote. Throws an Error that names the file where it is damaged, foreign or of
/// other inputs.
NetworkSamples read_samples(const std::filesystem::path& path, const Inputs& inputs);

}  // namespace knuckle
