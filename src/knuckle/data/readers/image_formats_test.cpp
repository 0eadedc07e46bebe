// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstring>
#include <limits>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/csv_image.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/exr_image.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::cut_file;
using testing::error_of;
using ::testing::HasSubstr;
using testing::put_file;

Image<float> ramp(int width, int height) {
  Image<float> image(width, height);
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = 0.1f + 0.37f * static_cast<float>(i);
  return image;
}

TEST(ExrImage, ReadsWhatItWrote) {
  const testing::TemporaryFolder folder;
  Image<float> image = ramp(37, 21);
  image(3, 4) = 1e10f;
  image(4, 4) = std::numeric_limits<float>::infinity();
  write_exr(folder / "a.exr", image);
  EXPECT_EQ(read_exr(folder / "a.exr"), image);
}

/// An EXR with channels of several names, as renderers write, and a data window that does not start at 0.
void write_layers(const std::filesystem::path& path,
                  const std::vector<std::pair<std::string, float>>& channels, Imf::PixelType type) {
  const Imath::Box2i window({5, 7}, {8, 8});  // 4 x 2 pixels
  Imf::Header header(window, window);
  Imf::FrameBuffer buffer;
  std::vector<std::vector<float>> floats;
  std::vector<std::uint32_t> wholes(8, 1);
  for (const auto& [name, value] : channels) {
    header.channels().insert(name, Imf::Channel(type));
    floats.emplace_back(8, value);
    void* data =
        type == Imf::UINT ? static_cast<void*>(wholes.data()) : static_cast<void*>(floats.back().data());
    buffer.insert(name, Imf::Slice::Make(type, data, window));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(2);
}

TEST(ExrImage, PicksTheChannelThatHoldsDepth) {
  const testing::TemporaryFolder folder;
  write_layers(folder / "rgba.exr", {{"A", 1.0f}, {"B", 0.2f}, {"G", 0.3f}, {"R", 0.4f}}, Imf::FLOAT);
  const Image<float> image = read_exr(folder / "rgba.exr");
  EXPECT_EQ(image.width(), 4);
  EXPECT_EQ(image.height(), 2);
  for (const float value : image.pixels()) EXPECT_EQ(value, 0.4f);
  write_layers(folder / "z.exr", {{"A", 1.0f}, {"R", 0.3f}, {"Z", 0.6f}}, Imf::FLOAT);
  EXPECT_EQ(read_exr(folder / "z.exr")(0, 0), 0.6f);
  write_layers(folder / "other.exr", {{"layer.depth", 0.7f}}, Imf::FLOAT);
  EXPECT_EQ(read_exr(folder / "other.exr")(0, 0), 0.7f);
}

TEST(ExrImage, NamesTheFileAndItsFault) {
  const testing::TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { read_exr(folder / "missing.exr"); }), HasSubstr("missing.exr"));
  put_file(folder / "no.exr", "this is not an image");
  EXPECT_THAT(error_of([&] { read_exr(folder / "no.exr"); }), AllOf(HasSubstr("no.exr"), HasSubstr("EXR")));
  write_layers(folder / "whole.exr", {{"R", 1.0f}}, Imf::UINT);
  EXPECT_THAT(error_of([&] { read_exr(folder / "whole.exr"); }),
              AllOf(HasSubstr("whole.exr"), HasSubstr("whole numbers")));
}

TEST(ExrImage, RefusesAFileCutShortAnywhere) {
  const testing::TemporaryFolder folder;
  write_exr(folder / "a.exr", ramp(64, 48));
  const auto bytes = std::filesystem::file_size(folder / "a.exr");
  for (std::uintmax_t cut = bytes - 1; cut > 0; cut -= std::min(cut, bytes / 40 + 1)) {
    cut_file(folder / "a.exr", cut);
    EXPECT_THAT(error_of([&] { read_exr(folder / "a.exr"); }), HasSubstr("a.exr")) << cut << " of " << bytes;
  }
}

/// Four bytes each, the lowest first.
std::string numbers(const std::vector<std::uint32_t>& values) {
  std::string bytes;
  for (const std::uint32_t value : values) {
    for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xffU));
  }
  return bytes;
}

/// An attribute of an EXR header, which may say another size than it has.
std::string attribute(const std::string& name, const std::string& type, const std::string& value,
                      std::optional<std::uint32_t> size = std::nullopt) {
  const std::string end(1, '\0');
  return name + end + type + end + numbers({size.value_or(static_cast<std::uint32_t>(value.size()))}) + value;
}

class ExrHeader : public ::testing::Test {
 protected:
  /// What reading says of a file with these attributes and 1,000 bytes behind them.
  std::string fault_of(const std::string& attributes, std::uint32_t flags = 2) {
    const std::string window = attribute("dataWindow", "box2i", numbers({0, 0, 16383, 16383}));
    put_file(path_, numbers({20000630, flags}) + attributes + window + std::string(1001, '\0'));
    return error_of([&] { read_exr(path_); });
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "a.exr";
};

TEST_F(ExrHeader, AsksForNoMoreThanTheFileHolds) {
  EXPECT_THAT(fault_of(attribute("owner", "mine", "x", 0x61640300)),
              HasSubstr("a.exr: cannot be read as an EXR image: 'owner' is longer than the file"));
  EXPECT_THAT(fault_of(attribute("preview", "preview", numbers({0x8000, 0x8000, 0}))),
              HasSubstr("its thumbnail"));
  EXPECT_THAT(fault_of(attribute("views", "stringvector", numbers({2000000000, 0}))),
              HasSubstr("a text is longer than what it stands in"));
  EXPECT_THAT(fault_of(attribute("ids", "idmanifest", numbers({1, 2}))), HasSubstr("ID manifest"));
  for (const std::string& start : {numbers({20000630}), numbers({20000630, 2}) + "owner",
                                   numbers({20000630, 2}) + attribute("owner", "mine", "x").substr(0, 13)}) {
    put_file(path_, start);
    EXPECT_THAT(error_of([&] { read_exr(path_); }),
                HasSubstr("a.exr: cannot be read as an EXR image: it ends within its header"));
  }
  put_file(path_, numbers({20000630, 2}) + attribute("views", "stringvector", "xy"));
  EXPECT_THAT(error_of([&] { read_exr(path_); }), HasSubstr("it ends within its header"));
  put_file(path_, numbers({20000631, 2}));
  EXPECT_THAT(error_of([&] { read_exr(path_); }),
              HasSubstr("a.exr: cannot be read as an EXR image: it is none"));
  EXPECT_THAT(fault_of(attribute(std::string(300, 'n'), "mine", "")),
              HasSubstr("a name in its header is too long"));
}

/// Where OpenEXR would read on at another place than we do, it would see attributes that nobody has checked.
TEST_F(ExrHeader, AttributesEndWhereTheySay) {
  const std::string zero(1, '\0');
  const std::string channels = "R" + zero + numbers({2, 0, 1, 1}) + zero;
  for (const std::uint32_t size : {channels.size() - 1, channels.size() - 4, channels.size() + 1}) {
    EXPECT_THAT(fault_of(attribute("channels", "chlist", channels + zero, size)),
                HasSubstr("its list of channels"))
        << size;
  }
  EXPECT_THAT(fault_of(attribute("screenWindowWidth", "float", numbers({0}), 3)),
              HasSubstr("'screenWindowWidth' is of another size than its type"));
  EXPECT_THAT(fault_of(attribute("range", "floatvector", numbers({0, 0}), 7)),
              HasSubstr("'range' is of another size than its type"));
  EXPECT_THAT(fault_of(attribute("preview", "preview", numbers({1, 1, 0}) + zero)),
              HasSubstr("its thumbnail"));
}

TEST_F(ExrHeader, HasNoMoreTilesThanTheFile) {
  const std::string in_tiles = std::string(1, '\0');  // one level
  EXPECT_THAT(fault_of(attribute("tiles", "tiledesc", numbers({1, 1}) + in_tiles), 0x202),
              HasSubstr("it has more tiles than the file can hold"));
  // Its row of tiles would take 4 GiB a channel, of an image of 64 KiB.
  const std::string flat = attribute("dataWindow", "box2i", numbers({0, 0, 16383, 0}));
  put_file(path_, numbers({20000630, 0x202}) +
                      attribute("tiles", "tiledesc", numbers({16384, 65536}) + in_tiles) + flat +
                      std::string(1001, '\0'));
  EXPECT_THAT(error_of([&] { read_exr(path_); }), HasSubstr("its tiles are far larger than the image"));
}

/// Rows of all channels are unpacked together: 16 of them in ZIP, up to 256 in others.
TEST_F(ExrHeader, HasNoMoreChannelsThanMemory) {
  const std::string zero(1, '\0');
  const auto with = [&](int count, const std::string& more) {
    std::string channels;
    for (int i = 0; i < count; ++i) channels += fmt::format("{}", i) + zero + numbers({2, 0, 1, 1});
    return fault_of(attribute("channels", "chlist", channels + zero) + more);
  };
  const std::string zip = attribute("compression", "compression", "\3");
  const std::string dwab = attribute("compression", "compression", "\t");
  const auto is_too_much = HasSubstr("a.exr: cannot be read as an EXR image: it has too many channels");
  EXPECT_THAT(with(128, zip), ::testing::Not(is_too_much));
  EXPECT_THAT(with(129, zip), is_too_much);
  EXPECT_THAT(with(8, dwab), ::testing::Not(is_too_much));
  EXPECT_THAT(with(9, dwab), is_too_much);
  EXPECT_THAT(with(9, ""), is_too_much) << "the worst is taken where nothing is said";
}

TEST_F(ExrHeader, IsLookedThroughInEveryPart) {
  const std::string first = attribute("name", "string", "a") + std::string(1, '\0');
  EXPECT_THAT(fault_of(first + attribute("owner", "mine", "x", 0x61640300), 0x1002),
              HasSubstr("'owner' is longer"));
  // What follows the only header of a file with one part is no header.
  EXPECT_THAT(fault_of(first + attribute("owner", "mine", "x", 0x61640300)),
              AllOf(HasSubstr("a.exr"), ::testing::Not(HasSubstr("'owner'"))));
}

TEST(CsvImage, ReadsWhatItWrote) {
  const testing::TemporaryFolder folder;
  const Image<float> image = ramp(13, 7);
  write_csv_image(folder / "a.csv", image);
  EXPECT_EQ(read_csv_image(folder / "a.csv"), image);
}

TEST(CsvImage, AllowsBlanksReturnsAndTrailingCommas) {
  const testing::TemporaryFolder folder;
  put_file(folder / "a.csv", "1, 2.5,3,\r\n4,5,-6,\r\n\r\n");
  const Image<float> image = read_csv_image(folder / "a.csv");
  ASSERT_EQ(image.width(), 3);
  ASSERT_EQ(image.height(), 2);
  EXPECT_EQ(image(1, 0), 2.5f);
  EXPECT_EQ(image(2, 1), -6.0f);
}

TEST(CsvImage, NamesFileLineAndFault) {
  const testing::TemporaryFolder folder;
  put_file(folder / "short.csv", "1,2,3\n4,5");
  EXPECT_THAT(error_of([&] { read_csv_image(folder / "short.csv"); }),
              AllOf(HasSubstr("short.csv:2"), HasSubstr("2 values, expected 3")));
  put_file(folder / "word.csv", "1,2,3\n4,x,6\n");
  EXPECT_THAT(error_of([&] { read_csv_image(folder / "word.csv"); }),
              AllOf(HasSubstr("word.csv:2"), HasSubstr("'x'")));
  put_file(folder / "empty.csv", "\n\n");
  EXPECT_THAT(error_of([&] { read_csv_image(folder / "empty.csv"); }), HasSubstr("empty.csv: is empty"));
  EXPECT_THAT(error_of([&] { read_csv_image(folder / "none.csv"); }), HasSubstr("none.csv"));
}

TEST(DepthImage, RoundsToCountsAndBack) {
  Image<float> depth_mm(4, 1);
  depth_mm(0, 0) = 123.44f;
  depth_mm(1, 0) = -5.0f;
  depth_mm(2, 0) = std::nanf("");
  const Image<std::uint16_t> counts = counts_from_depth(depth_mm, 0.1, "here");
  EXPECT_EQ(counts(0, 0), 1234);
  for (const int hole : {1, 2, 3}) EXPECT_EQ(counts(hole, 0), 0);
  EXPECT_NEAR(depth_from_counts(counts, 0.1)(0, 0), 123.4f, 1e-4);
}

TEST(DepthImage, RefusesDepthsThatDoNotFit) {
  EXPECT_THAT(error_of([] { counts_from_depth(Image<float>(1, 1, 6554.0f), 0.1, "here"); }),
              AllOf(HasSubstr("here"), HasSubstr("6554"), HasSubstr("0.1")));
  EXPECT_EQ(counts_from_depth(Image<float>(1, 1, 6553.5f), 0.1, "here")(0, 0), 65535);
}

TEST(CsvImage, RefusesSizesAndNumbersThatNoDepthImageHas) {
  const testing::TemporaryFolder folder;
  const auto fault = [&](const std::string& text) {
    put_file(folder / "a.csv", text);
    return error_of([&] { read_csv_image(folder / "a.csv"); });
  };
  std::string rows;
  for (int i = 0; i < 16385; ++i) rows += "1\n";
  EXPECT_THAT(fault(rows), HasSubstr("1 x 16385 pixels, expected 1 to 16384 a side"));
  std::string wide;
  for (int i = 0; i < 16385; ++i) wide += "1,";
  EXPECT_THAT(fault(wide + "\n"), HasSubstr("16385 x 1 pixels, expected 1 to 16384 a side"));
  wide.resize(2 * 16384);
  std::string short_rows = wide;
  for (int i = 0; i < 16383; ++i) short_rows += "\n1";
  EXPECT_THAT(fault(short_rows), HasSubstr("a.csv:2: has 1 values, expected 16384"))
      << "a gigabyte for 65 KB";
  EXPECT_THAT(fault("1,1e200\n"), HasSubstr("too large"));
  EXPECT_THAT(fault("1,2\n1\n" + std::string(std::size_t{2} << 20, '1')),
              HasSubstr("a.csv:2: has 1 values, expected 2"));
  EXPECT_THAT(fault("1,2\n\n1,2\n"), HasSubstr("a.csv:2: has 0 values, expected 2"));
  EXPECT_THAT(fault("\n\n"), HasSubstr("a.csv: is empty"));
}

/// An EXR whose header says another size.
TEST(ExrImage, ThatSaysItHoldsMoreThanItCanIsRefusedBeforeMemoryIsTaken) {
  const testing::TemporaryFolder folder;
  write_exr(folder / "a.exr", ramp(37, 21));
  std::string bytes = read_text_file(folder / "a.exr");
  const auto with_window = [&](std::int32_t right, std::int32_t bottom, int more_bytes = 20000) {
    for (const char* name : {"dataWindow", "displayWindow"}) {
      const std::size_t place = bytes.find(name) + std::strlen(name) + 1 + std::strlen("box2i") + 1 + 4 + 8;
      std::memcpy(bytes.data() + place, &right, sizeof(right));
      std::memcpy(bytes.data() + place + 4, &bottom, sizeof(bottom));
    }
    put_file(folder / "b.exr", bytes + std::string(more_bytes, '\0'));
    return error_of([&] { read_exr(folder / "b.exr"); });
  };
  EXPECT_THAT(with_window(65535, 65535), HasSubstr("b.exr"));
  EXPECT_THAT(with_window(16384, 0), HasSubstr("b.exr"));
  EXPECT_THAT(with_window(16383, 16383),
              HasSubstr("b.exr: has 16384 x 16384 pixels, expected at most 33554432"));
  EXPECT_THAT(with_window(16383, 2047, 1000), HasSubstr("b.exr: says that it holds 33554432 pixels"));
  EXPECT_THAT(with_window(2147483646, 0), HasSubstr("b.exr"));
}

}  // namespace
}  // namespace knuckle
