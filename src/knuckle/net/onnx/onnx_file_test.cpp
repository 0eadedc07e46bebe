// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/onnx/onnx_file.h"

#include "knuckle/core/testing.h"
#include "knuckle/net/onnx/onnx_fields.h"
#include "knuckle/net/onnx/onnx_testing.h"
#include "knuckle/net/onnx/protobuf_writer.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::error_of;
using testing::filled;
using ::testing::HasSubstr;
using testing::one_node;

OnnxModel some_model() {
  OnnxModel model =
      one_node("Conv", {kOpenSize, 1, 4, 4}, {{"w", filled({2, 1, 3, 3})}, {"s", integer_list({-1, 7})}},
               {{"text", std::string("abc")},
                {"whole", std::int64_t{-3}},
                {"real", 0.25f},
                {"wholes", testing::Integers{1, -2}},
                {"none", testing::Integers{}},
                {"reals", std::vector<float>{0.5f, -1.5f}},
                {"tensor", filled({2, 2}, 3.0f)}});
  model.metadata = {{"key", "value"}, {"other", "two\nlines"}};
  model.opset = 11;
  return model;
}

std::string fault(std::string_view bytes) {
  return error_of([&] { (void)parse_onnx(bytes, "net.onnx"); });
}

TEST(OnnxFile, WhatIsWrittenIsRead) {
  const OnnxModel model = some_model();
  const std::string bytes = onnx_bytes(model);
  const OnnxModel read = parse_onnx(bytes, "net.onnx");
  EXPECT_EQ(onnx_bytes(read), bytes);
  EXPECT_EQ(read.opset, 11);
  EXPECT_EQ(read.producer, "a test");
  EXPECT_EQ(read.metadata, model.metadata);
  EXPECT_THAT(read.inputs.front().shape, ElementsAre(kOpenSize, 1, 4, 4));
  EXPECT_EQ(read.constants.at("w").reals, model.constants.at("w").reals);
  EXPECT_EQ(read.constants.at("s").integers, model.constants.at("s").integers);
  const OnnxNode& node = read.nodes.front();
  EXPECT_EQ(node.operation, "Conv");
  EXPECT_THAT(node.inputs, ElementsAre("x", "w", "s"));
  EXPECT_EQ(std::get<std::string>(node.attributes.at("text")), "abc");
  EXPECT_EQ(std::get<std::int64_t>(node.attributes.at("whole")), -3);
  EXPECT_EQ(std::get<float>(node.attributes.at("real")), 0.25f);
  EXPECT_THAT(std::get<testing::Integers>(node.attributes.at("wholes")), ElementsAre(1, -2));
  EXPECT_TRUE(std::get<testing::Integers>(node.attributes.at("none")).empty());
  EXPECT_THAT(std::get<std::vector<float>>(node.attributes.at("reals")), ElementsAre(0.5f, -1.5f));
  EXPECT_THAT(std::get<OnnxTensor>(node.attributes.at("tensor")).reals, ElementsAre(3, 3, 3, 3));
}

TEST(OnnxFile, EachCutIsSaidOrLeavesAWholeModel) {
  const std::string bytes = onnx_bytes(some_model());
  int refused = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    try {
      (void)parse_onnx(std::string_view(bytes).substr(0, size), "net.onnx");
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("net.onnx"));
      ++refused;
    }
  }
  // Metadata stand last: a file that ends between two of them is whole but for these.
  EXPECT_GE(refused, static_cast<int>(bytes.size()) - 2);
}

TEST(OnnxFile, WhatIsNoOnnxIsSaid) {
  EXPECT_THAT(fault(""), HasSubstr("net.onnx: damaged, or no ONNX file: it has no graph"));
  EXPECT_THAT(fault("PK\3\4 a zip"), HasSubstr("net.onnx: damaged"));
  EXPECT_THAT(fault("# text\n"), HasSubstr("net.onnx"));
  const testing::TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { (void)load_onnx(folder / "none.onnx"); }), HasSubstr("none.onnx"));
  EXPECT_THAT(error_of([&] { (void)load_onnx(folder.path()); }), HasSubstr(folder.path().string()));
}

/// A model whose graph is written by hand.
std::string with_graph(const ProtobufWriter& graph) {
  ProtobufWriter opset;
  opset.integer(onnx_fields::kOpsetVersion, 13);
  ProtobufWriter model;
  model.message(onnx_fields::kGraph, graph);
  model.message(onnx_fields::kOpsetImport, opset);
  return model.text();
}

/// The same of a graph with one field.
std::string with_graph(std::uint32_t number, const ProtobufWriter& value) {
  ProtobufWriter graph;
  graph.message(number, value);
  return with_graph(graph);
}

std::string with_constant(const ProtobufWriter& tensor) {
  return with_graph(onnx_fields::kInitializer, tensor);
}

ProtobufWriter tensor_of(std::int64_t type, const testing::Integers& shape) {
  ProtobufWriter tensor;
  for (const std::int64_t size : shape) tensor.integer(onnx_fields::kDims, size);
  tensor.integer(onnx_fields::kDataType, type);
  tensor.bytes(onnx_fields::kTensorName, "w");
  return tensor;
}

TEST(OnnxFile, ConstantsMustBeWhole) {
  ProtobufWriter sound = tensor_of(1, {2});
  sound.bytes(onnx_fields::kRawData, std::string(8, '\0'));
  EXPECT_EQ(parse_onnx(with_constant(sound), "net.onnx").constants.at("w").reals.size(), 2u);

  EXPECT_THAT(fault(with_constant(tensor_of(10, {2}))), AllOf(HasSubstr("'w'"), HasSubstr("float16")));
  EXPECT_THAT(fault(with_constant(tensor_of(1, {2}))),
              HasSubstr("it has 0 numbers, but its shape asks for 2"));
  EXPECT_THAT(fault(with_constant(tensor_of(1, {-2}))), HasSubstr("a size of -2"));
  // 100 GB, and what overflows.
  EXPECT_THAT(fault(with_constant(tensor_of(1, {500000, 50000}))), HasSubstr("asks for more than"));
  EXPECT_THAT(fault(with_constant(tensor_of(1, {400000000, 400000000, 400000000}))),
              HasSubstr("asks for more than"));
  EXPECT_THAT(fault(with_constant(tensor_of(1, testing::Integers(9, 1)))), HasSubstr("more than 8 sizes"));

  ProtobufWriter twice = sound;
  twice.real(onnx_fields::kRealData, 1.0f);
  EXPECT_THAT(fault(with_constant(twice)), HasSubstr("twice"));
  ProtobufWriter odd = tensor_of(1, {2});
  odd.bytes(onnx_fields::kRawData, "abc");
  EXPECT_THAT(fault(with_constant(odd)), HasSubstr("3 bytes of data"));

  ProtobufWriter reals = tensor_of(7, {1});
  reals.real(onnx_fields::kRealData, 1.0f);
  EXPECT_THAT(fault(with_constant(reals)), HasSubstr("'w': its data are of another type than it says"));
  ProtobufWriter integers = tensor_of(1, {1});
  integers.integer(onnx_fields::kIntegerData, 1);
  EXPECT_THAT(fault(with_constant(integers)), HasSubstr("'w': its data are of another type than it says"));
}

TEST(OnnxFile, AListOfWholeNumbersIsBounded) {
  ProtobufWriter longest = tensor_of(7, {1 << 16});
  longest.bytes(onnx_fields::kRawData, std::string(8 << 16, '\0'));
  EXPECT_EQ(parse_onnx(with_constant(longest), "net.onnx").constants.at("w").integers.size(), 1u << 16);
  ProtobufWriter longer = tensor_of(7, {(1 << 16) + 1});
  longer.bytes(onnx_fields::kRawData, std::string((8 << 16) + 8, '\0'));
  EXPECT_THAT(fault(with_constant(longer)), HasSubstr("'w': more than 65536 whole numbers"));
}

TEST(OnnxFile, DataInOtherFilesAreRefused) {
  for (const char* place : {"../../etc/passwd", "/etc/passwd", "weights.bin"}) {
    ProtobufWriter entry;
    entry.bytes(onnx_fields::kEntryKey, "location");
    entry.bytes(onnx_fields::kEntryValue, place);
    ProtobufWriter tensor = tensor_of(1, {2});
    tensor.message(onnx_fields::kExternalData, entry);
    tensor.integer(onnx_fields::kDataLocation, 1);
    EXPECT_THAT(fault(with_constant(tensor)), HasSubstr("lie in another file"));
  }
}

std::string with_node(const ProtobufWriter& node) {
  return with_graph(onnx_fields::kNode, node);
}

/// A model of one node with one attribute.
std::string with_attribute(const ProtobufWriter& attribute) {
  ProtobufWriter node;
  node.bytes(onnx_fields::kOperation, "Conv");
  node.message(onnx_fields::kAttribute, attribute);
  return with_node(node);
}

/// A model of one input, whose type is written by hand.
std::string with_input(const ProtobufWriter& type) {
  ProtobufWriter input;
  input.bytes(onnx_fields::kValueName, "x");
  input.message(onnx_fields::kValueType, type);
  return with_graph(onnx_fields::kInput, input);
}

/// A message of one field, which holds another message.
ProtobufWriter around(std::uint32_t number, const ProtobufWriter& value) {
  ProtobufWriter message;
  message.message(number, value);
  return message;
}

TEST(OnnxFile, WhatIsNotReadIsSaid) {
  ProtobufWriter node;
  node.bytes(onnx_fields::kOperation, "Conv");
  node.bytes(onnx_fields::kNodeName, "first");
  ProtobufWriter foreign = node;
  foreign.bytes(onnx_fields::kNodeDomain, "com.microsoft");
  EXPECT_THAT(fault(with_node(foreign)), AllOf(HasSubstr("'first'"), HasSubstr("com.microsoft")));

  ProtobufWriter branch;
  branch.bytes(onnx_fields::kAttributeName, "then_branch");
  branch.bytes(6, "a graph");
  ProtobufWriter with_branch = node;
  with_branch.message(onnx_fields::kAttribute, branch);
  EXPECT_THAT(fault(with_node(with_branch)), HasSubstr("'then_branch'"));

  ProtobufWriter twice = node;
  twice.bytes(onnx_fields::kOperation, "Relu");
  EXPECT_THAT(fault(with_node(twice)), HasSubstr("is there twice"));

  ProtobufWriter functions;
  functions.bytes(onnx_fields::kFunctions, "f");
  EXPECT_THAT(fault(functions.text()), HasSubstr("functions"));

  // Readers differ in which of two graphs they take.
  const std::string sound = with_node(node);
  EXPECT_NO_THROW((void)parse_onnx(sound, "net.onnx"));
  EXPECT_THAT(fault(sound + sound), HasSubstr("twice"));
}

TEST(OnnxFile, AnAttributeHasOneValueOfAKnownType) {
  ProtobufWriter texts;
  texts.bytes(onnx_fields::kAttributeName, "words");
  texts.integer(onnx_fields::kAttributeType, 8);
  EXPECT_THAT(fault(with_attribute(texts)),
              HasSubstr("the attribute 'words' is of type 8, expected numbers, a text or a tensor"));
  ProtobufWriter missing;
  missing.bytes(onnx_fields::kAttributeName, "value");
  missing.integer(onnx_fields::kAttributeType, onnx_fields::kTypeTensor);
  EXPECT_THAT(fault(with_attribute(missing)), HasSubstr("the attribute 'value' is of type 4, expected"));

  ProtobufWriter axis;
  axis.bytes(onnx_fields::kAttributeName, "axis");
  axis.integer(onnx_fields::kAttributeType, onnx_fields::kTypeInteger);
  axis.integer(onnx_fields::kInteger, 1);
  EXPECT_NO_THROW((void)parse_onnx(with_attribute(axis), "net.onnx"));
  ProtobufWriter node;
  node.bytes(onnx_fields::kOperation, "Concat");
  node.message(onnx_fields::kAttribute, axis);
  node.message(onnx_fields::kAttribute, axis);
  EXPECT_THAT(fault(with_node(node)), HasSubstr("(Concat): an attribute is there twice"));
  axis.integer(onnx_fields::kInteger, 2);
  EXPECT_THAT(fault(with_attribute(axis)), HasSubstr("field 3 is there twice"));
}

TEST(OnnxFile, AnInputIsATensorOfRealNumbers) {
  ProtobufWriter sequence;
  sequence.bytes(4, "");
  EXPECT_THAT(fault(with_input(sequence)), HasSubstr("input 'x': it is no tensor"));
  ProtobufWriter half;
  half.integer(onnx_fields::kElementType, 10);
  EXPECT_THAT(fault(with_input(around(onnx_fields::kTensorType, half))),
              HasSubstr("input 'x': its numbers are float16"));
}

/// Readers differ in which of two they take.
TEST(OnnxFile, NamesAndVersionsAreThereOnce) {
  ProtobufWriter tensor = tensor_of(1, {1});
  tensor.real(onnx_fields::kRealData, 1.0f);
  ProtobufWriter graph;
  graph.message(onnx_fields::kInitializer, tensor);
  graph.message(onnx_fields::kInitializer, tensor);
  EXPECT_THAT(fault(with_graph(graph)), HasSubstr("the constant 'w' is there twice"));

  ProtobufWriter opset;
  opset.integer(onnx_fields::kOpsetVersion, 12);
  ProtobufWriter model;
  model.message(onnx_fields::kOpsetImport, opset);
  EXPECT_THAT(fault(with_graph(ProtobufWriter()) + model.text()),
              HasSubstr("two versions of ONNX's operators"));

  ProtobufWriter entry;
  entry.bytes(onnx_fields::kEntryKey, "joints");
  entry.bytes(onnx_fields::kEntryValue, "14");
  const std::string metadata = around(onnx_fields::kModelMetadata, entry).text();
  EXPECT_NO_THROW((void)parse_onnx(with_graph(ProtobufWriter()) + metadata, "net.onnx"));
  EXPECT_THAT(fault(with_graph(ProtobufWriter()) + metadata + metadata),
              HasSubstr("metadata: 'joints' is there twice"));
}

/// Each message with a field of number 31, which none of them has.
TEST(OnnxFile, AnUnknownFieldIsRefusedInEachMessage) {
  ProtobufWriter unknown;
  unknown.integer(31, 1);
  const auto type_around = [](const ProtobufWriter& shape) {
    return with_input(around(onnx_fields::kTensorType, around(onnx_fields::kShape, shape)));
  };
  EXPECT_THAT(fault(with_graph(unknown)), HasSubstr("net.onnx: damaged, or of a later format"));
  EXPECT_THAT(fault(with_constant(unknown)), HasSubstr("constant: damaged, or of a later format"));
  EXPECT_THAT(fault(with_node(unknown)), HasSubstr("node 0: damaged, or of a later format"));
  EXPECT_THAT(fault(with_attribute(unknown)), HasSubstr("the attribute '' has the field 31"));
  EXPECT_THAT(fault(with_graph(onnx_fields::kInput, unknown)), HasSubstr("unknown field 31"));
  EXPECT_THAT(fault(with_input(around(onnx_fields::kTensorType, unknown))), HasSubstr("unknown field 31"));
  EXPECT_THAT(fault(type_around(unknown)), HasSubstr("unknown field 31"));
  EXPECT_THAT(fault(type_around(around(onnx_fields::kDimension, unknown))), HasSubstr("unknown field 31"));
  for (const std::uint32_t number : {onnx_fields::kOpsetImport, onnx_fields::kModelMetadata}) {
    EXPECT_THAT(fault(with_graph(ProtobufWriter()) + around(number, unknown).text()),
                HasSubstr("unknown field 31"));
  }
  EXPECT_THAT(fault(with_graph(ProtobufWriter()) + unknown.text()),
              HasSubstr("no ONNX file: it has the unknown field 31"));

  ProtobufWriter sparse;
  sparse.bytes(onnx_fields::kSparseInitializer, "");
  EXPECT_THAT(fault(with_graph(sparse)), HasSubstr("sparse constants, which are not read"));
}

/// `count` times the same field, which is empty.
ProtobufWriter repeated(std::uint32_t number, int count) {
  ProtobufWriter message;
  for (int i = 0; i < count; ++i) message.bytes(number, "");
  return message;
}

TEST(OnnxFile, CountsAreBounded) {
  EXPECT_THAT(fault(with_graph(repeated(onnx_fields::kNode, (1 << 14) + 1))),
              HasSubstr("more than 16384 nodes"));
  EXPECT_THAT(fault(with_graph(repeated(onnx_fields::kInput, (1 << 14) + 1))),
              HasSubstr("more than 16384 inputs"));
  EXPECT_THAT(fault(with_graph(repeated(onnx_fields::kInput, 65))), HasSubstr("more than 64 inputs"));
  EXPECT_THAT(fault(with_graph(repeated(onnx_fields::kOutput, 65))), HasSubstr("more than 64 outputs"));
  EXPECT_THAT(fault(with_node(repeated(onnx_fields::kNodeInput, 257))), HasSubstr("more than 256 inputs"));
  EXPECT_THAT(fault(with_node(repeated(onnx_fields::kNodeOutput, 257))), HasSubstr("more than 256 outputs"));
  EXPECT_THAT(fault(with_node(repeated(onnx_fields::kAttribute, 257))),
              HasSubstr("more than 256 attributes"));
  EXPECT_THAT(fault(with_input(around(onnx_fields::kTensorType,
                                      around(onnx_fields::kShape, repeated(onnx_fields::kDimension, 9))))),
              HasSubstr("more than 8 sizes"));

  ProtobufWriter constants;
  for (int i = 0; i < (1 << 14) + 1; ++i) {
    ProtobufWriter tensor;
    tensor.integer(onnx_fields::kDims, 0);
    tensor.integer(onnx_fields::kDataType, 1);
    tensor.bytes(onnx_fields::kTensorName, fmt::format("{}", i));
    constants.message(onnx_fields::kInitializer, tensor);
  }
  EXPECT_THAT(fault(with_graph(constants)), HasSubstr("more than 16384 constants"));

  ProtobufWriter foreign;
  foreign.bytes(onnx_fields::kOpsetDomain, "com.example");
  ProtobufWriter opsets;
  ProtobufWriter metadata;
  for (int i = 0; i < 257; ++i) {
    opsets.message(onnx_fields::kOpsetImport, foreign);
    ProtobufWriter entry;
    entry.bytes(onnx_fields::kEntryKey, fmt::format("{}", i));
    metadata.message(onnx_fields::kModelMetadata, entry);
  }
  EXPECT_THAT(fault(opsets.text()), HasSubstr("more than 256 sets of operators"));
  EXPECT_THAT(fault(metadata.text()), HasSubstr("more than 256 entries of metadata"));
}

TEST(OnnxFile, NamesHaveABoundedLength) {
  const auto named = [](std::size_t length) {
    ProtobufWriter graph;
    graph.bytes(onnx_fields::kGraphName, std::string(length, 'a'));
    return with_graph(graph);
  };
  EXPECT_NO_THROW((void)parse_onnx(named(4096), "net.onnx"));
  EXPECT_THAT(fault(named(4097)), HasSubstr("field 2 is a name that is too long"));
}

}  // namespace
}  // namespace knuckle
