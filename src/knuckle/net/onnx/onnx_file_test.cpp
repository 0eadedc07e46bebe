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

/// A model whose graph holds one constant that is written by hand.
std::string with_constant(const ProtobufWriter& tensor) {
  ProtobufWriter graph;
  graph.message(onnx_fields::kInitializer, tensor);
  ProtobufWriter opset;
  opset.integer(onnx_fields::kOpsetVersion, 13);
  ProtobufWriter model;
  model.message(onnx_fields::kGraph, graph);
  model.message(onnx_fields::kOpsetImport, opset);
  return model.text();
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

/// A model of one node that is written by hand.
std::string with_node(const ProtobufWriter& node) {
  ProtobufWriter graph;
  graph.message(onnx_fields::kNode, node);
  ProtobufWriter opset;
  opset.integer(onnx_fields::kOpsetVersion, 13);
  ProtobufWriter model;
  model.message(onnx_fields::kGraph, graph);
  model.message(onnx_fields::kOpsetImport, opset);
  return model.text();
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

TEST(OnnxFile, AttributesAreOfTheKindsThatAreReadAndThereOnce) {
  const auto attribute = [](std::int64_t type) {
    ProtobufWriter written;
    written.bytes(onnx_fields::kAttributeName, "a");
    written.integer(onnx_fields::kInteger, 3);
    written.integer(onnx_fields::kAttributeType, type);
    return written;
  };
  ProtobufWriter node;
  node.bytes(onnx_fields::kOperation, "Conv");
  ProtobufWriter foreign = node;
  foreign.message(onnx_fields::kAttribute, attribute(11));
  EXPECT_THAT(fault(with_node(foreign)), HasSubstr("the attribute 'a' is of type 11, expected numbers"));
  ProtobufWriter twice = node;
  for (int i = 0; i < 2; ++i) twice.message(onnx_fields::kAttribute, attribute(onnx_fields::kTypeInteger));
  EXPECT_THAT(fault(with_node(twice)), HasSubstr("an attribute is there twice"));
  ProtobufWriter later = node;
  later.integer(99, 1);
  EXPECT_THAT(fault(with_node(later)), HasSubstr("it has the unknown field 99"));
}

/// A model of this graph, with its operators' version told so often.
std::string with_graph(const ProtobufWriter& graph, int opsets = 1) {
  ProtobufWriter opset;
  opset.integer(onnx_fields::kOpsetVersion, 13);
  ProtobufWriter model;
  model.message(onnx_fields::kGraph, graph);
  for (int i = 0; i < opsets; ++i) model.message(onnx_fields::kOpsetImport, opset);
  return model.text();
}

TEST(OnnxFile, GraphsThatSayThingsTwiceOrSayOthersAreRefused) {
  ProtobufWriter sound = tensor_of(1, {2});
  sound.bytes(onnx_fields::kRawData, std::string(8, '\0'));
  ProtobufWriter twice;
  for (int i = 0; i < 2; ++i) twice.message(onnx_fields::kInitializer, sound);
  EXPECT_THAT(fault(with_graph(twice)), HasSubstr("the constant 'w' is there twice"));
  EXPECT_THAT(fault(with_graph({}, 2)), HasSubstr("two versions of ONNX's operators"));
  ProtobufWriter sparse;
  sparse.bytes(onnx_fields::kSparseInitializer, "");
  EXPECT_THAT(fault(with_graph(sparse)), HasSubstr("it has sparse constants"));
  ProtobufWriter sequence;
  sequence.bytes(4, "");  // a list of tensors
  ProtobufWriter value;
  value.bytes(onnx_fields::kValueName, "x");
  value.message(onnx_fields::kValueType, sequence);
  ProtobufWriter with_sequence;
  with_sequence.message(onnx_fields::kInput, value);
  EXPECT_THAT(fault(with_graph(with_sequence)), HasSubstr("it is no tensor"));
  ProtobufWriter mixed = tensor_of(1, {2});
  mixed.integer(onnx_fields::kIntegerData, 7);
  EXPECT_THAT(fault(with_constant(mixed)), HasSubstr("its data are of another type than it says"));
  ProtobufWriter many = tensor_of(7, {(1 << 16) + 1});
  many.bytes(onnx_fields::kRawData, std::string(8 * ((1 << 16) + 1), '\0'));
  EXPECT_THAT(fault(with_constant(many)), HasSubstr("more than 65536 whole numbers"));
}

TEST(OnnxFile, NamesAreBounded) {
  ProtobufWriter node;
  node.bytes(onnx_fields::kOperation, "Conv");
  node.bytes(onnx_fields::kNodeName, std::string(100'000, 'n'));
  EXPECT_THAT(fault(with_node(node)), HasSubstr("is a name that is too long"));
}

TEST(OnnxFile, CountsAreBounded) {
  ProtobufWriter graph;
  for (int i = 0; i < (1 << 14) + 1; ++i) graph.bytes(onnx_fields::kNode, "");
  ProtobufWriter opset;
  opset.integer(onnx_fields::kOpsetVersion, 13);
  ProtobufWriter model;
  model.message(onnx_fields::kGraph, graph);
  model.message(onnx_fields::kOpsetImport, opset);
  EXPECT_THAT(fault(model.text()), HasSubstr("more than 16384 nodes"));
}

}  // namespace
}  // namespace knuckle
