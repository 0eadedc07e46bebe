// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <torch/types.h>

namespace knuckle {

/// The device of that name: "cpu", "cuda" or "cuda:1". Of "cuda" each worker of a machine takes the GPU of
/// its number, and where there are fewer GPUs begins again with the first. Throws an Error where the name is
/// another, or where this machine or this LibTorch has no such device: call it before long work.
torch::Device device_from_name(const std::string& name, int number_on_machine = 0);

}  // namespace knuckle
