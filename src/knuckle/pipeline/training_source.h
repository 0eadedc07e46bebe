// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "knuckle/core/options.h"

namespace knuckle {

/// The `source` of a training configuration, KIND:PATH; a relative path in it starts at the configuration's
/// folder. Throws an Error where the key is missing.
std::string training_source(const OptionTable& document);

}  // namespace knuckle
