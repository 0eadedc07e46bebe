// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "knuckle/core/options.h"
#include "knuckle/estimate/estimator.h"

namespace knuckle {

/// The names that `method` may take.
std::span<const std::string_view> estimator_names();

/// The estimator that a table of a pipeline file asks for; every key of the table is read.
///
///     method         one of estimator_names()
///     model          the model's file, relative to the table's file
///     convention     optional: what the model must predict
///     patch_size_px  optional: what size of patches the model must have been trained on
///     and those of the method (NetworkEstimatorOptions, ForeignNetworkOptions)
///
/// Throws an Error that names the file (and line) where a key is missing, unknown or wrong, or the model is.
std::unique_ptr<Estimator> create_estimator(const OptionTable& table);

}  // namespace knuckle
