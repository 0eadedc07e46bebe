// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/model_file.h"

#include <sys/stat.h>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/deflate.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/model_testing.h"
#include "knuckle/storage/zip_archive.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Not;

ModelWriter example() {
  ModelWriter writer("knuckle-test", 3);
  writer.set("name", "a hand");
  writer.set("count", 12.0);
  writer.set("bones", std::vector<std::string>{"wrist", "palm"});
  writer.add("single", {2, 3}, std::vector<float>{1.5F, -2, 3, 4, 5, 6e-30F});
  writer.add("whole", {3}, std::vector<std::int64_t>{-1, 0, std::int64_t{1} << 40});
  writer.add("bytes", {4}, std::vector<std::uint8_t>{0, 1, 2, 255});
  writer.add("nothing", {0, 7}, std::vector<std::uint16_t>{});
  const std::vector<std::uint16_t> plain{1, 2, 3};
  writer.add<std::uint16_t>("plain", {3}, plain, ModelWriter::Storage::plain);
  return writer;
}

std::string text_of(const std::vector<std::uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

std::string fault_of(const std::string& bytes) {
  std::string message = error_of([&] { ModelFile::parse(bytes, "a.model"); });
  EXPECT_THAT(message, AllOf(HasSubstr("a.model"), Not(HasSubstr("\n"))));
  return message;
}

/// A file of this header and these entries, with a sum that fits.
std::string file_of(const std::string& header, std::vector<ZipContent> entries = {},
                    const std::string& name = "model.json") {
  const auto* const text = reinterpret_cast<const std::uint8_t*>(header.data());
  entries.insert(entries.begin(), {name, {text, header.size()}});
  std::string bytes = text_of(zip_of(entries, "knuckle-sum 0000000000000000"));
  bytes.resize(bytes.size() - 16);
  const std::span before(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  return bytes + fmt::format("{:08x}{:08x}", crc32(before), adler32(before));
}

TEST(ModelFile, GivesBackWhatWasWritten) {
  const testing::TemporaryFolder folder;
  example().save(folder / "a.model");
  const ModelFile file = ModelFile::open(folder / "a.model");
  file.require_format("knuckle-test", 3);
  EXPECT_EQ(file.text("name"), "a hand");
  EXPECT_EQ(file.number("count"), 12.0);
  EXPECT_EQ(file.integer("count", 0, 12), 12);
  EXPECT_THAT(file.texts("bones"), ElementsAre("wrist", "palm"));
  EXPECT_THAT(file.shape("single"), ElementsAre(2, 3));
  EXPECT_THAT(file.read<float>("single").values, ElementsAre(1.5F, -2, 3, 4, 5, 6e-30F));
  EXPECT_THAT(file.read<std::int64_t>("whole").values, ElementsAre(-1, 0, std::int64_t{1} << 40));
  EXPECT_THAT(file.read<std::uint8_t>("bytes").values, ElementsAre(0, 1, 2, 255));
  EXPECT_THAT(file.read<std::uint16_t>("nothing").shape, ElementsAre(0, 7));
  EXPECT_THAT(file.read<std::uint16_t>("plain").values, ElementsAre(1, 2, 3));
  EXPECT_TRUE(file.has("name") && file.has("single") && !file.has("other"));
}

TEST(ModelFile, TheSameContentIsTheSameBytes) {
  EXPECT_EQ(example().bytes(), example().bytes());
  const ModelFile file = ModelFile::parse(text_of(example().bytes()), "a");
  EXPECT_EQ(file.writer().bytes(), example().bytes());
}

TEST(ModelFile, OfWhichAnyByteWasChangedIsRefused) {
  const std::string bytes = text_of(example().bytes());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const int change : {1, 32, 255}) {
      std::string changed = bytes;
      changed[i] = static_cast<char>(changed[i] ^ change);
      EXPECT_NE(fault_of(changed), "") << i;
    }
  }
}

TEST(ModelFile, CutShortAtAnyLengthIsRefused) {
  const std::string bytes = text_of(example().bytes());
  for (std::size_t length = 0; length < bytes.size(); ++length) fault_of(bytes.substr(0, length));
}

TEST(ModelFile, OfAnOlderKnuckleIsRefusedWithTheWordsThatSaySo) {
  EXPECT_THAT(fault_of("\x89HDF\r\n\x1a\n and more"),
              AllOf(HasSubstr("an HDF5 file"), HasSubstr("Knuckle 0.1")));
  EXPECT_THAT(fault_of(std::string("PK\x03\x04") + "net/data.pkl"),
              AllOf(HasSubstr("an archive of LibTorch"), HasSubstr("Knuckle 0.1")));
  EXPECT_THAT(fault_of("a text"), HasSubstr("not a model's file, or cut short"));
}

TEST(ModelFile, OfAnotherFormatOrVersionIsRefused) {
  const ModelFile file = ModelFile::parse(text_of(example().bytes()), "a.model");
  EXPECT_THAT(error_of([&] { file.require_format("knuckle-body", 3); }),
              HasSubstr("a.model: expected a knuckle-body file, found a knuckle-test file"));
  EXPECT_THAT(error_of([&] { file.require_format("knuckle-test", 4); }),
              HasSubstr("version 3 of the format knuckle-test, expected version 4"));
}

TEST(ModelFile, WhatIsMissingOrOfAnotherTypeIsNamed) {
  const ModelFile file = ModelFile::parse(text_of(example().bytes()), "a.model");
  EXPECT_THAT(error_of([&] { file.text("author"); }), HasSubstr("a.model: author is missing"));
  EXPECT_THAT(error_of([&] { file.text("count"); }), HasSubstr("count is not a text"));
  EXPECT_THAT(error_of([&] { file.number("name"); }), HasSubstr("name is not a number"));
  EXPECT_THAT(error_of([&] { file.texts("name"); }), HasSubstr("name is not a list of texts"));
  EXPECT_THAT(error_of([&] { file.integer("count", 0, 11); }), HasSubstr("count is 12, expected a whole"));
  ModelWriter verbose = example();
  verbose.set("bones", std::vector<std::string>{"wrist", std::string(4097, 'p')});
  const ModelFile long_text = ModelFile::parse(text_of(verbose.bytes()), "a.model");
  EXPECT_THAT(error_of([&] { long_text.texts("bones"); }),
              HasSubstr("has 4097 characters, expected at most 4096"));
  EXPECT_THAT(error_of([&] { file.read<float>("weights"); }), HasSubstr("weights: the array is missing"));
  EXPECT_THAT(error_of([&] { file.read<double>("single"); }),
              HasSubstr("single has numbers of the type float32, expected float64"));
}

TEST(ModelFile, WhoseHeaderIsNotOneIsRefused) {
  const std::string start = R"({"format": "knuckle-test", "version": 1, "values": {}, "arrays": )";
  EXPECT_NO_THROW(ModelFile::parse(file_of(start + "{}}"), "a.model"));
  for (const std::string& header : {std::string(), std::string("[]"), std::string("{"), start, start + "[]}",
                                    std::string(2'000'000, '['), start + std::string(2'000'000, '[')}) {
    EXPECT_THAT(fault_of(file_of(header)), HasSubstr("header"));
  }
  EXPECT_THAT(fault_of(file_of(start + "{}}", {}, "other.json")), HasSubstr("it has no model.json"));
  EXPECT_THAT(fault_of(file_of(start + "{}}" + std::string(std::size_t{4} << 20, ' '))),
              HasSubstr("its header is too long"));
}

TEST(ModelFile, ThatDoesNotBeginWithAHeaderIsRefused) {
  const auto fault_with = [](const std::vector<ZipContent>& entries) {
    std::string bytes = text_of(zip_of(entries, "knuckle-sum 0000000000000000"));
    bytes.resize(bytes.size() - 16);
    const std::span before(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    return fault_of(bytes + fmt::format("{:08x}{:08x}", crc32(before), adler32(before)));
  };
  EXPECT_THAT(fault_with({}), HasSubstr("not a model's file: it has no model.json"));
  EXPECT_THAT(fault_with({{"readme", {}}}), HasSubstr("not a model's file: it has no model.json"));
  const std::vector<std::uint8_t> blanks((std::size_t{4} << 20) + 1, ' ');
  EXPECT_THAT(fault_with({{"model.json", blanks}}), HasSubstr("damaged: its header is too long"));
}

TEST(ModelFile, WhoseTextsAreNoneOrTooLongIsRefused) {
  const ModelFile file = ModelFile::parse(
      file_of(R"({"format": "knuckle-test", "version": 1, "values": {"bones": ["wrist", 2], "names": [")" +
              std::string(100'000, 'x') + R"("]}, "arrays": {}})"),
      "a.model");
  EXPECT_THAT(error_of([&] { file.texts("bones"); }), HasSubstr("a.model: bones is not a list of texts"));
  EXPECT_THAT(error_of([&] { file.texts("names"); }),
              HasSubstr("a.model: a text of names has 100000 characters, expected at most"));
}

TEST(ModelFile, WhoseShapesAndSizesDisagreeIsRefusedBeforeMemoryIsTaken) {
  const std::vector<std::uint8_t> six(6, 1);
  const auto fault_with = [&](const std::string& description) {
    return fault_of(
        file_of(R"({"format": "knuckle-test", "version": 1, "values": {}, "arrays": {)" + description + "}}",
                {{"a", six}}));
  };
  EXPECT_THAT(fault_with(""), HasSubstr("it has 1 arrays and describes 0"));
  EXPECT_THAT(fault_with(R"("b": {"type": "uint8", "shape": [6]})"), HasSubstr("a is not described"));
  EXPECT_THAT(fault_with(R"("a": {"type": "uint8", "shape": [7]})"), HasSubstr("6 bytes, expected 7"));
  EXPECT_THAT(fault_with(R"("a": {"type": "magic", "shape": [6]})"), HasSubstr("unknown type"));
  EXPECT_THAT(fault_with(R"("a": {"type": "uint8", "shape": [-6]})"), HasSubstr("whole numbers"));
  EXPECT_THAT(fault_with(R"("a": {"type": "uint8", "shape": 6})"), HasSubstr("no type and shape"));
  EXPECT_THAT(fault_with(R"("a": {"type": "uint8", "shape": [4294967296, 4294967296, 6]})"),
              HasSubstr("more numbers than a model may have"));
  EXPECT_THAT(fault_with(R"("a": {"type": "uint8", "shape": [1,1,1,1,1,1,1,1,6]})"),
              HasSubstr("no type and shape"));
}

TEST(ModelFile, ThatIsNoRegularFileIsRefusedAtOnce) {
  const testing::TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
  EXPECT_THAT(error_of([&] { ModelFile::open(folder / "fifo"); }),
              HasSubstr("expected a file, found a FIFO"));
  EXPECT_THAT(error_of([&] { ModelFile::open(folder.path()); }), HasSubstr("found a folder"));
  EXPECT_THAT(error_of([&] { ModelFile::open("/dev/zero"); }), HasSubstr("found a device"));
  EXPECT_THAT(error_of([&] { ModelFile::open(folder / "none"); }), HasSubstr("No such file"));
}

TEST(ModelFile, ThatCannotBeWrittenIsNamed) {
  EXPECT_THAT(error_of([] { example().save("/proc/knuckle/a.model"); }), HasSubstr("/proc/knuckle/a.model"));
}

}  // namespace
}  // namespace knuckle
