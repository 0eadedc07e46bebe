// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstring>
#include <optional>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/net/onnx/onnx_fields.h"
#include "knuckle/net/onnx/onnx_file.h"
#include "knuckle/net/onnx/protobuf_reader.h"

namespace knuckle {
namespace {

using namespace onnx_fields;
using Field = ProtobufField;

constexpr std::size_t kMostNodes = 1 << 14;
constexpr std::size_t kMostConstants = 1 << 14;
constexpr std::size_t kMostValues = 64;  // inputs and outputs of a graph that are no constants
constexpr std::size_t kMostNames = 256;  // inputs or outputs of a node, its attributes, entries of metadata
constexpr std::size_t kMostDimensions = 8;  // of a tensor

std::string name_of(const ProtobufReader& message, const Field& field) {
  const std::string_view name = message.bytes_of(field);
  if (name.size() > limits::kNameLength) message.fail_at(field, "is a name that is too long");
  return std::string(name);
}

void require_below(std::size_t count, std::size_t most, const ProtobufReader& message,
                   std::string_view things) {
  if (count >= most) fail("{}: more than {} {}", message.what(), most, things);
}

/// For what changes neither shapes nor answers: names for people, and fields of formats to come.
[[noreturn]] void fail_unknown(const ProtobufReader& message, const Field& field) {
  fail("{}: damaged, or of a later format: it has the unknown field {}", message.what(), field.number);
}

std::string_view type_name(std::int64_t type) {
  constexpr std::array<std::string_view, 17> kTypeNames = {
      "no type", "float32", "uint8",   "int8",   "uint16", "int16",     "int32",      "int64",   "text",
      "bool",    "float16", "float64", "uint32", "uint64", "complex64", "complex128", "bfloat16"};
  return type >= 0 && type < static_cast<std::int64_t>(kTypeNames.size())
             ? kTypeNames[static_cast<std::size_t>(type)]
             : "an unknown type";
}

OnnxType type_of(const ProtobufReader& message, std::int64_t type) {
  if (type == static_cast<std::int64_t>(OnnxType::float32)) return OnnxType::float32;
  if (type == static_cast<std::int64_t>(OnnxType::int64)) return OnnxType::int64;
  fail(
      "{}: its numbers are {}, expected float32 (or int64 for shapes); export the network in single "
      "precision",
      message.what(), type_name(type));
}

/// The numbers of `raw`, little-endian as in the file.
template <class Number>
std::vector<Number> numbers_in(std::string_view raw, const ProtobufReader& message) {
  if (raw.size() % sizeof(Number) != 0) {
    fail("{}: {} bytes of data, expected a multiple of {}", message.what(), raw.size(), sizeof(Number));
  }
  std::vector<Number> numbers(raw.size() / sizeof(Number));
  if (!raw.empty()) std::memcpy(numbers.data(), raw.data(), raw.size());
  return numbers;
}

/// Throws unless the shape's numbers are as many as there are. Sizes are compared as they are multiplied:
/// they may be anything.
void require_count(const OnnxTensor& tensor, const ProtobufReader& message) {
  const std::size_t found = tensor.reals.size() + tensor.integers.size();
  std::uint64_t expected = 1;
  for (const std::int64_t size : tensor.shape) {
    if (size < 0 || size > limits::kModelBytes) fail("{}: a size of {}", message.what(), size);
    expected *= static_cast<std::uint64_t>(size);
    if (expected > limits::kModelBytes) break;
  }
  if (expected != found) {
    fail("{}: it has {} numbers, but its shape asks for {}{}", message.what(), found,
         expected > limits::kModelBytes ? "more than " : "", expected);
  }
}

/// A tensor as it lies in the file.
struct RawTensor {
  std::string name;
  std::int64_t type = 0;
  OnnxShape shape;
  std::vector<float> reals;
  std::vector<std::int64_t> integers;
  std::optional<std::string_view> raw;  ///< its numbers' bytes, in place of these
};

void read_tensor_field(const ProtobufReader& message, const Field& field, RawTensor& tensor) {
  switch (field.number) {
    case kDims:
      message.add_integers(field, tensor.shape);
      if (tensor.shape.size() > kMostDimensions)
        fail("{}: more than {} sizes", message.what(), kMostDimensions);
      break;
    case kDataType:
      tensor.type = message.integer_of(field);
      break;
    case kRealData:
      message.add_reals(field, tensor.reals);
      break;
    case kIntegerData:
      message.add_integers(field, tensor.integers);
      break;
    case kTensorName:
      tensor.name = name_of(message, field);
      break;
    case kRawData:
      tensor.raw = message.bytes_of(field);
      break;
    case kTensorText:
    case kTensorMetadata:
      break;
    default:
      fail_unknown(message, field);
  }
}

RawTensor raw_tensor_in(std::string_view bytes, const std::string& what) {
  ProtobufReader message(bytes, what);
  RawTensor tensor;
  while (const auto field = message.next()) {
    const Field::Kind kind = field->kind;
    const bool is_elsewhere =
        field->number == kExternalData ||
        (field->number == kDataLocation && (kind != Field::Kind::varint || field->value != 0));
    if (is_elsewhere)
      fail("{}: its numbers lie in another file, which is not read; save the network as one file", what);
    if (field->number == kDataLocation) continue;
    const bool is_repeated = field->number == kDims || field->number == kRealData ||
                             field->number == kIntegerData || field->number == kTensorMetadata;
    if (!is_repeated) message.require_once(*field);
    read_tensor_field(message, *field, tensor);
  }
  return tensor;
}

struct NamedTensor {
  std::string name;
  OnnxTensor tensor;
};

NamedTensor tensor_in(std::string_view bytes, const std::string& what) {
  RawTensor raw = raw_tensor_in(bytes, what);
  const ProtobufReader named({}, raw.name.empty() ? what : fmt::format("{} '{}'", what, raw.name));
  const OnnxType type = type_of(named, raw.type);
  if (raw.raw && !(raw.reals.empty() && raw.integers.empty()))
    fail("{}: its data are there twice", named.what());
  if (raw.raw && type == OnnxType::float32) raw.reals = numbers_in<float>(*raw.raw, named);
  if (raw.raw && type == OnnxType::int64) raw.integers = numbers_in<std::int64_t>(*raw.raw, named);
  if (type == OnnxType::float32 ? !raw.integers.empty() : !raw.reals.empty()) {
    fail("{}: its data are of another type than it says", named.what());
  }
  if (raw.integers.size() > kMostIntegers)
    fail("{}: more than {} whole numbers", named.what(), kMostIntegers);
  OnnxTensor tensor{std::move(raw.shape), std::move(raw.reals), std::move(raw.integers), type};
  require_count(tensor, named);
  return {std::move(raw.name), std::move(tensor)};
}

/// An attribute as it lies in the file: the type says which of the values counts.
struct RawAttribute {
  std::string name;
  std::int64_t type = 0;
  std::int64_t integer = 0;
  float real = 0.0f;
  std::string text;
  std::vector<std::int64_t> integers;
  std::vector<float> reals;
  std::optional<OnnxTensor> tensor;
};

OnnxAttribute value_of(RawAttribute raw, const std::string& what) {
  switch (raw.type) {
    case kTypeReal:
      return raw.real;
    case kTypeInteger:
      return raw.integer;
    case kTypeText:
      return std::move(raw.text);
    case kTypeIntegers:
      return std::move(raw.integers);
    case kTypeReals:
      return std::move(raw.reals);
    case kTypeTensor:
      if (raw.tensor) return *std::move(raw.tensor);
      [[fallthrough]];
    default:
      fail("{}: the attribute '{}' is of type {}, expected numbers, a text or a tensor", what, raw.name,
           raw.type);
  }
}

std::pair<std::string, OnnxAttribute> attribute_in(std::string_view bytes, const std::string& what) {
  ProtobufReader message(bytes, what);
  RawAttribute raw;
  while (const auto field = message.next()) {
    if (field->number != kIntegers && field->number != kReals) message.require_once(*field);
    switch (field->number) {
      case kAttributeName:
        raw.name = name_of(message, *field);
        break;
      case kReal:
        raw.real = message.real_of(*field);
        break;
      case kInteger:
        raw.integer = message.integer_of(*field);
        break;
      case kText:
        raw.text = name_of(message, *field);
        break;
      case kTensor:
        raw.tensor = tensor_in(message.bytes_of(*field), what).tensor;
        break;
      case kReals:
        message.add_reals(*field, raw.reals);
        break;
      case kIntegers:
        message.add_integers(*field, raw.integers);
        break;
      case kAttributeText:
        break;
      case kAttributeType:
        raw.type = message.integer_of(*field);
        break;
      default:
        fail("{}: the attribute '{}' has the field {}, which is not read (a graph, texts, or a later format)",
             what, raw.name, field->number);
    }
  }
  std::string name = raw.name;
  return {std::move(name), value_of(std::move(raw), what)};
}

OnnxNode node_in(std::string_view bytes, const std::string& what) {
  ProtobufReader message(bytes, what);
  OnnxNode node;
  std::vector<std::string_view> attributes;
  std::string_view domain;
  while (const auto field = message.next()) {
    switch (field->number) {
      case kNodeInput:
        require_below(node.inputs.size(), kMostNames, message, "inputs");
        node.inputs.push_back(name_of(message, *field));
        break;
      case kNodeOutput:
        require_below(node.outputs.size(), kMostNames, message, "outputs");
        node.outputs.push_back(name_of(message, *field));
        break;
      case kNodeName:
        message.require_once(*field);
        node.name = name_of(message, *field);
        break;
      case kOperation:
        message.require_once(*field);
        node.operation = name_of(message, *field);
        break;
      case kAttribute:
        require_below(attributes.size(), kMostNames, message, "attributes");
        attributes.push_back(message.bytes_of(*field));
        break;
      case kNodeDomain:
      case kOverload:
        message.require_once(*field);
        if (!message.bytes_of(*field).empty() && field->bytes != "ai.onnx") domain = field->bytes;
        break;
      case kNodeText:
      case kNodeMetadata:
        break;
      default:
        fail_unknown(message, *field);
    }
  }
  if (node.name.empty() && !node.outputs.empty()) node.name = node.outputs.front();
  const std::string named = fmt::format("{} '{}' ({})", what, node.name, node.operation);
  if (!domain.empty()) {
    fail("{}: an operator of '{}', expected those of ONNX itself", named,
         domain.substr(0, limits::kNameLength));
  }
  for (const std::string_view attribute : attributes) {
    if (!node.attributes.insert(attribute_in(attribute, named)).second)
      fail("{}: an attribute is there twice", named);
  }
  return node;
}

std::int64_t dimension_in(std::string_view bytes, const std::string& what) {
  ProtobufReader message(bytes, what);
  std::int64_t size = kOpenSize;
  while (const auto field = message.next()) {
    message.require_once(*field);
    if (field->number == kDimensionValue) {
      size = message.integer_of(*field);
    } else if (field->number != kDimensionName && field->number != kDimensionDenotation) {
      fail_unknown(message, *field);
    }
  }
  return size > 0 ? size : kOpenSize;
}

OnnxShape shape_in(std::string_view bytes, const std::string& what) {
  ProtobufReader message(bytes, what);
  OnnxShape shape;
  while (const auto field = message.next()) {
    if (field->number != kDimension) fail_unknown(message, *field);
    require_below(shape.size(), kMostDimensions, message, "sizes");
    shape.push_back(dimension_in(message.bytes_of(*field), what));
  }
  return shape;
}

/// The shape in a TypeProto; all of our values are tensors of float32.
OnnxShape value_type_in(std::string_view bytes, const std::string& what) {
  ProtobufReader type(bytes, what);
  std::optional<std::string_view> tensor;
  while (const auto field = type.next()) {
    type.require_once(*field);
    if (field->number == kTensorType) {
      tensor = type.bytes_of(*field);
    } else if (field->number != kTypeDenotation) {
      fail("{}: it is no tensor", what);
    }
  }
  OnnxShape shape;
  ProtobufReader message(tensor.value_or(std::string_view()), what);
  while (const auto field = message.next()) {
    message.require_once(*field);
    if (field->number == kElementType) {
      type_of(message, message.integer_of(*field));
    } else if (field->number == kShape) {
      shape = shape_in(message.bytes_of(*field), what);
    } else {
      fail_unknown(message, *field);
    }
  }
  return shape;
}

OnnxValue value_in(std::string_view bytes, const std::string& what) {
  ProtobufReader message(bytes, what);
  OnnxValue value;
  std::string_view type;
  while (const auto field = message.next()) {
    if (field->number == kValueMetadata || field->number == kValueText) continue;
    message.require_once(*field);
    if (field->number == kValueName) {
      value.name = name_of(message, *field);
    } else if (field->number == kValueType) {
      type = message.bytes_of(*field);
    } else {
      fail_unknown(message, *field);
    }
  }
  value.shape = value_type_in(type, fmt::format("{} '{}'", what, value.name));
  return value;
}

void read_graph(std::string_view bytes, const std::string& origin, OnnxModel& model) {
  ProtobufReader message(bytes, origin);
  std::vector<OnnxValue> inputs;
  while (const auto field = message.next()) {
    switch (field->number) {
      case kNode:
        require_below(model.nodes.size(), kMostNodes, message, "nodes");
        model.nodes.push_back(
            node_in(message.bytes_of(*field), fmt::format("{}: node {}", origin, model.nodes.size())));
        break;
      case kGraphName:
        message.require_once(*field);
        model.graph_name = name_of(message, *field);
        break;
      case kInitializer: {
        require_below(model.constants.size(), kMostConstants, message, "constants");
        NamedTensor tensor = tensor_in(message.bytes_of(*field), fmt::format("{}: constant", origin));
        if (!model.constants.emplace(tensor.name, std::move(tensor.tensor)).second) {
          fail("{}: the constant '{}' is there twice", origin, tensor.name);
        }
        break;
      }
      case kInput:
        require_below(inputs.size(), kMostConstants, message, "inputs");
        inputs.push_back(value_in(message.bytes_of(*field), fmt::format("{}: input", origin)));
        break;
      case kOutput:
        require_below(model.outputs.size(), kMostValues, message, "outputs");
        model.outputs.push_back(value_in(message.bytes_of(*field), fmt::format("{}: output", origin)));
        break;
      case kSparseInitializer:
        fail("{}: it has sparse constants, which are not read", origin);
      case kGraphText:
      case kValueInfo:  // shapes of what is between: found out anew
      case kQuantization:
      case kGraphMetadata:
        break;
      default:
        fail_unknown(message, *field);
    }
  }
  // Until 2019 constants were listed among the inputs, too.
  for (OnnxValue& input : inputs) {
    if (model.constants.contains(input.name)) continue;
    require_below(model.inputs.size(), kMostValues, message, "inputs");
    model.inputs.push_back(std::move(input));
  }
}

void read_opset(std::string_view bytes, const std::string& origin, std::optional<std::int64_t>& opset) {
  ProtobufReader message(bytes, origin);
  std::string_view domain;
  std::int64_t version = 0;
  while (const auto field = message.next()) {
    message.require_once(*field);
    if (field->number == kOpsetDomain) {
      domain = message.bytes_of(*field);
    } else if (field->number == kOpsetVersion) {
      version = message.integer_of(*field);
    } else {
      fail_unknown(message, *field);
    }
  }
  if (!domain.empty() && domain != "ai.onnx") return;  // no node of another maker's is read
  if (opset) fail("{}: two versions of ONNX's operators", origin);
  opset = version;
}

void read_entry(std::string_view bytes, const std::string& origin, OnnxModel& model) {
  ProtobufReader message(bytes, origin + ": metadata");
  std::string key;
  std::string value;
  while (const auto field = message.next()) {
    message.require_once(*field);
    if (field->number == kEntryKey) {
      key = name_of(message, *field);
    } else if (field->number == kEntryValue) {
      value = message.bytes_of(*field);
    } else {
      fail_unknown(message, *field);
    }
  }
  if (!model.metadata.emplace(key, std::move(value)).second)
    fail("{}: '{}' is there twice", message.what(), key);
}

}  // namespace

OnnxModel parse_onnx(std::string_view bytes, const std::string& origin) {
  ProtobufReader message(bytes, origin);
  OnnxModel model;
  std::optional<std::string_view> graph;
  std::optional<std::int64_t> opset;
  std::size_t opsets = 0;
  while (const auto field = message.next()) {
    switch (field->number) {
      case kProducer:
        message.require_once(*field);
        model.producer = name_of(message, *field);
        break;
      case kGraph:
        message.require_once(*field);
        graph = message.bytes_of(*field);
        break;
      case kOpsetImport:
        require_below(opsets++, kMostNames, message, "sets of operators");
        read_opset(message.bytes_of(*field), origin, opset);
        break;
      case kModelMetadata:
        require_below(model.metadata.size(), kMostNames, message, "entries of metadata");
        read_entry(message.bytes_of(*field), origin, model);
        break;
      case kFunctions:
        fail("{}: it has functions of its own, which are not read; export the network without them", origin);
      case kIrVersion:
      case kProducerVersion:
      case kModelDomain:
      case kModelVersion:
      case kModelText:
      case kTrainingInfo:
        break;
      default:
        fail("{}: damaged, or no ONNX file: it has the unknown field {}", origin, field->number);
    }
  }
  if (!graph || !opset) fail("{}: damaged, or no ONNX file: it has no {}", origin, graph ? "opset" : "graph");
  model.opset = *opset;
  read_graph(*graph, origin, model);
  return model;
}

OnnxModel load_onnx(const std::filesystem::path& path) {
  return parse_onnx(read_regular_file(path, limits::kModelBytes), path.string());
}

}  // namespace knuckle
