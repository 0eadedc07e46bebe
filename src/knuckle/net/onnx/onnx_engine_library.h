// SPDX-License-Identifier: Apache-2.0
// Private to the module: what the library of engines, libknuckle_opencv_dnn.so, shares with who loads it. It
// is a library of its own, so that nothing loads OpenCV's networks but who runs an ONNX file.
#pragma once

#include <string_view>

#include "knuckle/net/onnx/onnx_engine.h"

namespace knuckle {

/// The library with the engine, which lies beside ours, and the function in it that makes one.
inline constexpr const char* kEngineLibrary = "libknuckle_opencv_dnn.so";
/// Its number rises with each change of what the library offers.
inline constexpr const char* kEngineFunction = "knuckle_onnx_engine_1";

/// What the library has to offer. `create` takes the bytes of an ONNX file; its inputs and outputs are those
/// of `model`. Throws a std::runtime_error of one line.
struct OnnxEngineMaker {
  const char* name;
  std::unique_ptr<OnnxEngine> (*create)(std::string_view bytes, const OnnxModel& model);
};
/// The function that the library exports under the name kEngineFunction.
using OnnxEngineFunction = const OnnxEngineMaker* (*)();

}  // namespace knuckle
