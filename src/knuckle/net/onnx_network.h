// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/net/onnx/onnx_model.h"

namespace knuckle {

/// A network from an ONNX file, for inference on the calling thread.
class OnnxNetwork {
 public:
  /// Checks the model and runs it once, on zeros. Throws an Error that starts with `origin` where it is not
  /// sound or cannot be run.
  OnnxNetwork(OnnxModel model, const std::string& origin);
  OnnxNetwork(OnnxNetwork&&) noexcept;
  OnnxNetwork& operator=(OnnxNetwork&&) noexcept;
  ~OnnxNetwork();

  /// The file's name, for messages.
  const std::string& origin() const;
  /// Four sizes, the first of which is 1.
  const OnnxShape& input_shape() const;
  const std::vector<OnnxValue>& outputs() const;
  /// The place of an output; -1 where there is none of this name.
  int output_named(std::string_view name) const;

  /// All outputs. `input` has as many numbers as its shape says. Throws an Error where a number that comes
  /// out is not finite. Safe to call from many threads: each has the weights for itself.
  std::vector<std::vector<float>> run(std::span<const float> input) const;

 private:
  struct Content;
  std::unique_ptr<const Content> content_;
};

}  // namespace knuckle
