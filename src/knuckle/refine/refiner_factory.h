// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "knuckle/core/options.h"
#include "knuckle/refine/refiner.h"

namespace knuckle {

/// Names of all refinement methods.
std::span<const std::string_view> refiner_names();

/// The refiner of that name with the options of `table`, which it reads strictly and finishes: throws an
/// Error where the name is not known (and lists those that are), a key is not known, or a value is out of
/// range.
std::unique_ptr<Refiner> create_refiner(std::string_view name, const OptionTable& table);

/// The same; the table names the method under `method`, which it must.
std::unique_ptr<Refiner> create_refiner(const OptionTable& table);

}  // namespace knuckle
