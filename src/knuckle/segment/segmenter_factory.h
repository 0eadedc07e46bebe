// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "knuckle/core/options.h"
#include "knuckle/segment/segmenter.h"

namespace knuckle {

/// Names of all segmentation methods.
std::span<const std::string_view> segmenter_names();

/// The segmenter of that name with the options of `table`, which it reads strictly and finishes: throws an
/// Error where the name is not known (and lists those that are), a key is not known, or a value is out of
/// range.
std::unique_ptr<Segmenter> create_segmenter(std::string_view name, const OptionTable& table);

/// The same; the table names the method under `method`, mean_shift where it does not.
std::unique_ptr<Segmenter> create_segmenter(const OptionTable& table);

}  // namespace knuckle
