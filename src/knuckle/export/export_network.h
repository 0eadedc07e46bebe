// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/net/network_weights.h"
#include "knuckle/net/onnx/onnx_model.h"
#include "knuckle/segment/detector/detector_file.h"

namespace knuckle {

// Networks as ONNX, for other engines (docs/onnx.md). Weights keep their values: numbers of half precision
// are written in single precision, batch norms are nodes of their own.

/// A network that infers poses: from `patch` (1 x 1 x size x size) to `landmarks` (1 x joints x 3: u, v, d)
/// and `confidence` (1 x joints), or to `heat_maps` (1 x joints x cells x cells) and `depth_bins`. Its
/// metadata is what `net/exported_network.h` reads.
OnnxModel onnx_of(const NetworkWeights& weights);

/// The detector: from `picture` (1 x 2 x rows x columns: inverse depth, measured share) to `maps` (1 x 6 x
/// rows / 4 x columns / 4), as segment/detector/detector_options.h names them.
OnnxModel onnx_of(const DetectorWeights& weights);

/// What was exported, for people.
struct ExportedFile {
  std::string network;   ///< its architecture, or "detector"
  std::size_t nodes;     ///< of the graph
  std::int64_t weights;  ///< numbers that it holds
};

/// Exports a model's file. Throws an Error that names the file where it cannot be read, holds no network, or
/// is damaged, and where `out` cannot be written.
ExportedFile export_network(const std::filesystem::path& model, const std::filesystem::path& out);

}  // namespace knuckle
