// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/net/onnx/onnx_model.h"

namespace knuckle {

/// What is known of the tensors of a graph while it is checked.
struct OnnxTensors {
  std::map<std::string, OnnxShape> shapes;         ///< of those that are computed, and of the inputs
  std::map<std::string, OnnxTensor>* constants{};  ///< the model's own
  std::int64_t opset = 0;
  std::int64_t most_numbers = 0;  ///< that a tensor may have
};

/// A node as the check of its operator sees it. All faults are Errors that name it.
class NodeView {
 public:
  NodeView(OnnxNode& node, const OnnxTensors& tensors, std::string what)
      : node_(node), tensors_(tensors), what_(std::move(what)) {}

  template <class... Arguments>
  [[noreturn]] void fault(fmt::format_string<Arguments...> format, Arguments&&... arguments) const {
    fail("{}: {}", what_, fmt::format(format, std::forward<Arguments>(arguments)...));
  }

  OnnxNode& node() { return node_; }
  std::int64_t opset() const { return tensors_.opset; }
  std::size_t input_count() const { return node_.inputs.size(); }
  /// Whether an input is there.
  bool has(std::size_t input) const { return input < input_count() && !node_.inputs[input].empty(); }
  /// The shape of an input of real numbers, computed or constant.
  const OnnxShape& shape(std::size_t input) const;
  /// The same of one that must have so many sizes.
  const OnnxShape& shape(std::size_t input, std::size_t rank) const;
  /// A constant input.
  const OnnxTensor& constant(std::size_t input) const;
  const std::vector<float>& reals(std::size_t input) const;
  const std::vector<std::int64_t>& integers(std::size_t input) const;

  /// An attribute, or `otherwise`. Numbers have to lie in [low, high].
  std::int64_t integer(const std::string& name, std::int64_t otherwise, std::int64_t low,
                       std::int64_t high) const;
  std::vector<std::int64_t> integers(const std::string& name, std::vector<std::int64_t> otherwise,
                                     std::int64_t low, std::int64_t high) const;
  std::string text(const std::string& name, const std::string& otherwise) const;
  float real(const std::string& name, float otherwise) const;
  bool has_attribute(const std::string& name) const { return node_.attributes.contains(name); }
  /// An attribute that counts from the end where it is negative, as one of `rank` places.
  std::size_t axis(const std::string& name, std::int64_t otherwise, std::size_t rank) const;
  std::size_t place_of(std::int64_t axis, std::size_t rank) const;

  /// Throws where a size is below 1 or a tensor of that shape would be too large.
  void check_size(const OnnxShape& shape) const;
  void count_work(std::int64_t outputs, std::int64_t products_per_output);
  double work() const { return work_; }

  /// Makes the node a `Reshape` of its first input. Returns the shape.
  OnnxShape become_reshape(OnnxShape shape);
  /// Makes the node another one of its first input alone.
  void become(std::string operation, std::map<std::string, OnnxAttribute> attributes);

 private:
  OnnxNode& node_;
  const OnnxTensors& tensors_;
  std::string what_;
  double work_ = 0.0;
};

/// An operator on the list.
struct OnnxOperator {
  std::string_view name;
  std::size_t least_inputs;
  std::size_t most_inputs;
  std::string_view attributes;  ///< those that it may have, parted by blanks
  OnnxShape (*output_shape)(NodeView& node);
};

/// @{
/// The shape of what the operators of one kind make. Throws an Error where inputs or attributes do not fit.
OnnxShape shape_of_same(NodeView& node);
OnnxShape shape_of_clip(NodeView& node);
OnnxShape shape_of_dropout(NodeView& node);
OnnxShape shape_of_broadcast(NodeView& node);
OnnxShape shape_of_prelu(NodeView& node);
OnnxShape shape_of_softmax(NodeView& node);
OnnxShape shape_of_batch_norm(NodeView& node);

OnnxShape shape_of_convolution(NodeView& node);
OnnxShape shape_of_transposed_convolution(NodeView& node);
OnnxShape shape_of_pool(NodeView& node);
OnnxShape shape_of_global_pool(NodeView& node);
OnnxShape shape_of_resize(NodeView& node);
OnnxShape shape_of_gemm(NodeView& node);
OnnxShape shape_of_matmul(NodeView& node);

OnnxShape shape_of_reshape(NodeView& node);
OnnxShape shape_of_flatten(NodeView& node);
OnnxShape shape_of_squeeze(NodeView& node);
OnnxShape shape_of_unsqueeze(NodeView& node);
OnnxShape shape_of_transpose(NodeView& node);
OnnxShape shape_of_concat(NodeView& node);
OnnxShape shape_of_slice(NodeView& node);
OnnxShape shape_of_pad(NodeView& node);
OnnxShape shape_of_reduce(NodeView& node);
/// @}

}  // namespace knuckle
