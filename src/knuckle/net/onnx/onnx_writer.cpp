// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/onnx/onnx_fields.h"
#include "knuckle/net/onnx/onnx_file.h"
#include "knuckle/net/onnx/protobuf_writer.h"

namespace knuckle {
namespace {

using namespace onnx_fields;

constexpr std::int64_t kOurIrVersion = 7;  // that of ONNX 1.8, which brought opset 13

template <class Number>
std::string_view raw_bytes(const std::vector<Number>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

ProtobufWriter tensor_message(const std::string& name, const OnnxTensor& tensor) {
  ProtobufWriter message;
  for (const std::int64_t size : tensor.shape) message.integer(kDims, size);
  message.integer(kDataType, static_cast<std::int64_t>(tensor.type));
  if (!name.empty()) message.bytes(kTensorName, name);
  message.bytes(kRawData,
                tensor.type == OnnxType::float32 ? raw_bytes(tensor.reals) : raw_bytes(tensor.integers));
  return message;
}

/// Writes the value of an attribute and its type.
struct AttributeValue {
  ProtobufWriter& message;

  void operator()(std::int64_t value) const {
    message.integer(kInteger, value);
    message.integer(kAttributeType, kTypeInteger);
  }
  void operator()(float value) const {
    message.real(kReal, value);
    message.integer(kAttributeType, kTypeReal);
  }
  void operator()(const std::string& value) const {
    message.bytes(kText, value);
    message.integer(kAttributeType, kTypeText);
  }
  void operator()(const std::vector<std::int64_t>& values) const {
    for (const std::int64_t value : values) message.integer(kIntegers, value);
    message.integer(kAttributeType, kTypeIntegers);
  }
  void operator()(const std::vector<float>& values) const {
    for (const float value : values) message.real(kReals, value);
    message.integer(kAttributeType, kTypeReals);
  }
  void operator()(const OnnxTensor& value) const {
    message.message(kTensor, tensor_message({}, value));
    message.integer(kAttributeType, kTypeTensor);
  }
};

ProtobufWriter node_message(const OnnxNode& node) {
  ProtobufWriter message;
  for (const std::string& input : node.inputs) message.bytes(kNodeInput, input);
  for (const std::string& output : node.outputs) message.bytes(kNodeOutput, output);
  if (!node.name.empty()) message.bytes(kNodeName, node.name);
  message.bytes(kOperation, node.operation);
  for (const auto& [name, value] : node.attributes) {
    ProtobufWriter attribute;
    attribute.bytes(kAttributeName, name);
    std::visit(AttributeValue{attribute}, value);
    message.message(kAttribute, attribute);
  }
  return message;
}

ProtobufWriter value_message(const OnnxValue& value) {
  ProtobufWriter shape;
  for (const std::int64_t size : value.shape) {
    ProtobufWriter dimension;
    if (size == kOpenSize) {
      dimension.bytes(kDimensionName, "any");
    } else {
      dimension.integer(kDimensionValue, size);
    }
    shape.message(kDimension, dimension);
  }
  ProtobufWriter tensor;
  tensor.integer(kElementType, static_cast<std::int64_t>(OnnxType::float32));
  tensor.message(kShape, shape);
  ProtobufWriter type;
  type.message(kTensorType, tensor);
  ProtobufWriter message;
  message.bytes(kValueName, value.name);
  message.message(kValueType, type);
  return message;
}

ProtobufWriter graph_message(const OnnxModel& model) {
  ProtobufWriter message;
  for (const OnnxNode& node : model.nodes) message.message(kNode, node_message(node));
  message.bytes(kGraphName, model.graph_name);
  for (const auto& [name, tensor] : model.constants)
    message.message(kInitializer, tensor_message(name, tensor));
  for (const OnnxValue& value : model.inputs) message.message(kInput, value_message(value));
  for (const OnnxValue& value : model.outputs) message.message(kOutput, value_message(value));
  return message;
}

}  // namespace

std::string onnx_bytes(const OnnxModel& model) {
  ProtobufWriter message;
  message.integer(kIrVersion, kOurIrVersion);
  message.bytes(kProducer, model.producer);
  message.message(kGraph, graph_message(model));
  ProtobufWriter opset;
  opset.bytes(kOpsetDomain, "");
  opset.integer(kOpsetVersion, model.opset);
  message.message(kOpsetImport, opset);
  for (const auto& [key, value] : model.metadata) {
    ProtobufWriter entry;
    entry.bytes(kEntryKey, key);
    entry.bytes(kEntryValue, value);
    message.message(kModelMetadata, entry);
  }
  return message.take();
}

}  // namespace knuckle
