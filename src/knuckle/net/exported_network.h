// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "knuckle/net/network_options.h"
#include "knuckle/net/onnx/onnx_model.h"

namespace knuckle {

/// Writes into an ONNX model's metadata what network of ours it is: `knuckle.kind` = "knuckle-network" and
/// `knuckle.options`, all options as TOML.
void set_exported_options(OnnxModel& model, const NetworkOptions& options);

/// The options of a network of ours; nothing where the model is somebody else's. Throws an Error that starts
/// with `origin` where it is another thing of ours, or its options are wrong.
std::optional<NetworkOptions> exported_options(const OnnxModel& model, const std::string& origin);

}  // namespace knuckle
