// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "knuckle/net/onnx/onnx_model.h"

namespace knuckle {

inline constexpr std::int64_t kOldestOpset = 9;   ///< of the versions of ONNX's operators that are read
inline constexpr std::int64_t kNewestOpset = 17;  ///< of them: the newest that OpenCV 4.6 knows

/// What a network may take at most, so that a small file cannot ask for a large machine.
struct OnnxLimits {
  std::int64_t numbers = std::int64_t{1} << 28;  ///< of all tensors of one answer together: a gigabyte
  std::int64_t work = std::int64_t{1} << 37;     ///< multiplications of one answer: half a minute on one core
};

/// Checks a network before an engine sees it: one input and at least one output, all of whose sizes are known
/// (a size that the file leaves open as the first one is 1), operators and attributes from a list, inputs
/// that exist, shapes that fit together, constants that are finite, and what all of it takes in memory and
/// work.
///
/// Returns it in the form that OpenCV 4.6 understands best: what the operators make constant is constant,
/// changes of shape are all `Reshape`, bounds and axes are attributes; the outputs' shapes are known. Throws
/// an Error that starts with `origin` and names the node.
OnnxModel checked_onnx(OnnxModel model, const std::string& origin, const OnnxLimits& limits = {});

/// The operators that are on the list.
std::span<const std::string_view> onnx_operators();

}  // namespace knuckle
