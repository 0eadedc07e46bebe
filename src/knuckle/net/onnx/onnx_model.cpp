// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/onnx/onnx_model.h"

#include <utility>

namespace knuckle {

OnnxTensor real_tensor(OnnxShape shape, std::vector<float> values) {
  return {std::move(shape), std::move(values), {}, OnnxType::float32};
}

OnnxTensor integer_list(std::vector<std::int64_t> values) {
  const auto count = static_cast<std::int64_t>(values.size());
  return {{count}, {}, std::move(values), OnnxType::int64};
}

}  // namespace knuckle
