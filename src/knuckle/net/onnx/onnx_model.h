// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace knuckle {

// The part of ONNX (Open Neural Network Exchange, its specification on onnx.ai) that we write and read:
// graphs of operators on tensors of single precision, and of whole numbers that say shapes.

/// What a tensor consists of; the values are those of the format.
enum class OnnxType : std::uint8_t { float32 = 1, int64 = 7 };

using OnnxShape = std::vector<std::int64_t>;

/// Stands for a size that a file leaves open.
inline constexpr std::int64_t kOpenSize = -1;

/// How many numbers a tensor of that shape has. All sizes are known, and their product fits.
inline std::int64_t count_of(const OnnxShape& shape) {
  std::int64_t count = 1;
  for (const std::int64_t size : shape) count *= size;
  return count;
}

/// A tensor of constants. One of the two is empty.
struct OnnxTensor {
  OnnxShape shape;
  std::vector<float> reals;
  std::vector<std::int64_t> integers;
  OnnxType type = OnnxType::float32;
};

/// A tensor of numbers in single precision.
OnnxTensor real_tensor(OnnxShape shape, std::vector<float> values);
/// A list of whole numbers, as shapes and axes are told.
OnnxTensor integer_list(std::vector<std::int64_t> values);

/// What an attribute of a node may be.
using OnnxAttribute =
    std::variant<std::int64_t, float, std::string, std::vector<std::int64_t>, std::vector<float>, OnnxTensor>;

/// One operation. An input that is left out has an empty name.
struct OnnxNode {
  std::string operation;
  std::string name;  ///< for messages
  std::vector<std::string> inputs;
  std::vector<std::string> outputs;
  std::map<std::string, OnnxAttribute> attributes = {};
};

/// What goes into a graph or comes out.
struct OnnxValue {
  std::string name;
  OnnxShape shape;  ///< kOpenSize where the file leaves a size open
};

/// A network as ONNX knows it.
struct OnnxModel {
  std::int64_t opset = 13;  ///< version of the operators
  std::string producer;     ///< the program that wrote it
  std::string graph_name;
  std::map<std::string, std::string> metadata;
  std::vector<OnnxValue> inputs;
  std::vector<OnnxValue> outputs;
  std::map<std::string, OnnxTensor> constants;
  std::vector<OnnxNode> nodes;  ///< each after those whose outputs it reads
};

}  // namespace knuckle
