// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "knuckle/core/options.h"
#include "knuckle/estimate/estimator.h"

namespace knuckle {

/// The estimator that a table with `method = "onnx"` asks for: an ExportedEstimator where `model` is a file
/// of `knuckle export`, else a ForeignEstimator with the keys of ForeignNetworkOptions. Throws an Error that
/// names the file (and line).
std::unique_ptr<Estimator> load_onnx_estimator(const OptionTable& table);

}  // namespace knuckle
