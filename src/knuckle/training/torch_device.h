// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <torch/types.h>

namespace knuckle {

/// The device of that name: "cpu" or "cuda". Throws an Error where the name is another, or where this machine
/// or this LibTorch has no such device: call it before long work.
torch::Device device_from_name(const std::string& name);

}  // namespace knuckle
