// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "knuckle/net/onnx/onnx_model.h"

namespace knuckle {

/// Runs one network. Not to be called from two threads at once; each thread takes an engine of its own.
class OnnxEngine {
 public:
  virtual ~OnnxEngine() = default;

  /// The outputs, in the order in which the model names them, of an input with as many numbers as its shape
  /// says. Throws a std::runtime_error of one line where the engine cannot.
  virtual std::vector<std::vector<float>> run(std::span<const float> input) = 0;
};

/// Whether engines can be created: the library that contains them is optional. The text says whose engine it
/// is, or why there is none.
struct OnnxSupport {
  bool is_there = false;
  std::string text;
};
/// Loads the engine's library where that has not been done. Safe to call from many threads.
OnnxSupport onnx_support();

/// An engine for a network that `checked_onnx` has returned. Throws an Error that starts with `origin` where
/// there is no engine, or it cannot run this network.
std::unique_ptr<OnnxEngine> create_onnx_engine(const OnnxModel& model, const std::string& origin);

}  // namespace knuckle
