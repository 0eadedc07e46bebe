// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/net/network_weights.h"

namespace knuckle::testing {

/// Names and bytes of the records of a zip.
using ZipRecords = std::vector<std::pair<std::string, std::string>>;

/// Writes a zip whose records lie in it as they are.
void write_zip(const std::filesystem::path& path, const ZipRecords& records);

/// The records that a network's file is read from.
ZipRecords network_records(const NetworkWeights& weights);

/// A file that is read as a network, though LibTorch would miss its list of contents.
void write_network(const std::filesystem::path& path, const NetworkWeights& weights);

}  // namespace knuckle::testing
