// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <ostream>

#include "knuckle/core/random.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/core/testing.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/mcap_source.h"
#include "knuckle/data/readers/mcap_testing.h"
#include "knuckle/data/readers/open_dataset.h"
#include "knuckle/data/readers/recording_testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::camera_info_of;
using testing::CdrWriter;
using testing::error_of;
using testing::filled;
using ::testing::HasSubstr;
using testing::image_of;
using testing::kMcapCameraInfo;
using testing::kMcapColour;
using testing::kMcapDepth;
using testing::kMcapImage;
using testing::kMcapInfo;
using testing::little;
using testing::McapTestForm;
using testing::McapTestWriter;
using testing::put_file;
using testing::TestImage;
using testing::with_image;

class McapTest : public ::testing::Test {
 protected:
  std::filesystem::path path() const { return folder_ / "a.mcap"; }
  McapSource open(McapTestWriter mcap, const McapOptions& options = {}) const {
    put_file(path(), mcap.bytes());
    return McapSource(path(), options);
  }
  std::string fault(const McapTestWriter& mcap, const McapOptions& options = {}) const {
    return error_of([&] { open(mcap, options).read(0); });
  }
  std::string fault_of_bytes(const std::string& bytes) const {
    put_file(path(), bytes);
    return error_of([&] { McapSource(path()).read(0); });
  }

  std::string camera_file() const {
    put_file(folder_ / "camera.toml", "[camera]\nwidth=8\nheight=6\nfx=7\nfy=7\ncx=4\ncy=3\n");
    return (folder_ / "camera.toml").string();
  }

  testing::TemporaryFolder folder_;
};

struct McapLayout {
  const char* name;
  McapTestForm form;
};

void PrintTo(const McapLayout& layout, std::ostream* out) {
  *out << layout.name;
}

class McapOfEachLayout : public McapTest, public ::testing::WithParamInterface<McapLayout> {
 protected:
  static McapTestWriter recording(int count = 8) { return filled(GetParam().form, count); }
};

TEST_P(McapOfEachLayout, GivesDepthTimesAndCamera) {
  const McapSource source = open(recording());
  ASSERT_EQ(source.size(), 8);
  for (const std::int64_t i : {7, 0, 3, 4, 1, 6, 2, 5}) {
    const Frame frame = source.read(i);
    EXPECT_EQ(frame.depth_mm(0, 0), 500 + i);
    EXPECT_EQ(frame.depth_mm(7, 5), 500 + i + 57);
    EXPECT_NEAR(*frame.time_s, 1000.0 + static_cast<double>(i) / 30, 1e-8);
    EXPECT_EQ(frame.camera,
              (Camera{CameraModel::projective, 8, 6, 7.5, 7.25, 3.25, 2.5, {0.1, -0.2, 0.003, 0.004, 0.05}}));
  }
  EXPECT_EQ(source.read(3).name, "000003");
  testing::expect_labels_like_frames(source);
}

TEST_P(McapOfEachLayout, RandomPlacesHaveTheFramesOfAStraightReading) {
  const McapSource source = open(recording(60));
  testing::expect_random_places_as_straight(source, McapSource(path()));
}

TEST_P(McapOfEachLayout, ManyThreadsReadAtOnce) {
  testing::expect_many_threads_may_read(open(recording(60)));
}

TEST_P(McapOfEachLayout, CutAnywhereIsRefused) {
  const std::string whole = recording().bytes();
  for (std::size_t cut = 0; cut < whole.size(); cut += 31) {
    put_file(path(), whole.substr(0, cut));
    EXPECT_THAT(error_of([&] { McapSource source(path()); }), HasSubstr("a.mcap")) << cut;
  }
}

/// The ends of records and of their fields, too, with an end of the file put after the cut.
TEST_P(McapOfEachLayout, ClosedAfterAnyCutIsReadOrRefused) {
  const std::string whole = recording(2).bytes();
  const std::string end = whole.substr(whole.size() - 8 - 20 - 9);
  for (std::size_t cut = 0; cut < whole.size(); cut += 5) {
    SCOPED_TRACE(cut);
    put_file(path(), whole.substr(0, cut) + end);
    testing::expect_read_or_refused([&] { return McapSource(path()); }, path());
  }
}

TEST_P(McapOfEachLayout, ChangedBytesAreReadOrRefused) {
  McapTestForm form = GetParam().form;
  form.has_sums = false;  // else they hide what lies behind them
  for (const std::string& damaged : testing::damaged_copies(filled(form).bytes(), 200)) {
    put_file(path(), damaged);
    testing::expect_read_or_refused([&] { return McapSource(path()); }, path());
  }
}

/// A file with any changed byte is read as it was, or refused.
TEST_P(McapOfEachLayout, SumsAreChecked) {
  std::vector<float> expected;
  for (int first = 500; first < 502; ++first) {
    for (int row = 0; row < 6; ++row) {
      for (int column = 0; column < 8; ++column)
        expected.push_back(static_cast<float>(first + column + 10 * row));
    }
  }
  const std::string whole = recording(2).bytes();
  Random random(9);
  for (int i = 0; i < 150; ++i) {
    std::string damaged = whole;
    const std::size_t place = random.below(static_cast<std::uint32_t>(damaged.size()));
    damaged[place] = static_cast<char>(damaged[place] ^ 1 << random.below(8));
    put_file(path(), damaged);
    std::vector<float> depths;
    try {
      const McapSource source(path());
      for (std::int64_t frame = 0; frame < source.size(); ++frame) {
        const Image<float> depth_mm = source.read(frame).depth_mm;
        depths.insert(depths.end(), depth_mm.pixels().begin(), depth_mm.pixels().end());
      }
    } catch (const Error& error) {
      ASSERT_THAT(error.what(), HasSubstr("a.mcap"));
      continue;
    }
    ASSERT_EQ(depths, expected) << place;
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, McapOfEachLayout,
    ::testing::Values(McapLayout{"Plain", {}}, McapLayout{"Lz4", {.compression = "lz4"}},
                      McapLayout{"Zstd", {.compression = "zstd"}},
                      McapLayout{"WithoutIndexes", {.compression = "zstd", .has_indexes = false}},
                      McapLayout{"WithoutSummary", {.compression = "lz4", .has_summary = false}},
                      McapLayout{"WithoutChannelsInTheSummary",
                                 {.compression = "lz4", .repeats_channels = false}},
                      McapLayout{"WithoutBoth", {.has_indexes = false, .has_summary = false}},
                      McapLayout{"WithoutChunks", {.has_chunks = false}},
                      McapLayout{"WithoutChunksAndSummary", {.has_chunks = false, .has_summary = false}}),
    [](const auto& instance) { return instance.param.name; });

TEST_F(McapTest, FramesComeInTheOrderOfTheirStamps) {
  McapTestWriter mcap;
  mcap.add(kMcapInfo, kMcapCameraInfo, 0.0, camera_info_of({}));
  for (const int i : {2, 0, 1})
    mcap.add(kMcapDepth, kMcapImage, 10.0 - i, image_of({.stamp_s = 100.0 + i}, 500 + i));
  const McapSource source = open(mcap);
  for (const std::int64_t i : {0, 1, 2}) EXPECT_EQ(source.read(i).depth_mm(0, 0), 500 + i);
}

TEST_F(McapTest, WithoutStampsTheTimeIsThatOfRecording) {
  // Without indexes or chunks it stands with each message alone.
  for (const McapTestForm& form :
       {McapTestForm{}, McapTestForm{.has_indexes = false}, McapTestForm{.has_chunks = false}}) {
    McapTestWriter mcap(form);
    mcap.add(kMcapInfo, kMcapCameraInfo, 0.0, camera_info_of({}));
    mcap.add(kMcapDepth, kMcapImage, 12.5, image_of({}, 500));
    EXPECT_EQ(open(mcap).read(0).time_s, 12.5) << form.has_indexes << form.has_chunks;
  }
}

TEST_F(McapTest, ReadsBothOrdersOfBytesOfMessagesAndImages) {
  for (const bool is_big_endian_cdr : {false, true}) {
    for (const bool is_big_endian : {false, true}) {
      McapTestWriter mcap;
      mcap.add(kMcapInfo, kMcapCameraInfo, 0.0, camera_info_of({}, is_big_endian_cdr));
      const TestImage image{.is_big_endian = is_big_endian, .padding = 5, .stamp_s = 3.25};
      mcap.add(kMcapDepth, kMcapImage, 1.0, image_of(image, 700, is_big_endian_cdr));
      const Frame frame = open(mcap).read(0);
      EXPECT_EQ(frame.depth_mm(0, 0), 700);
      EXPECT_EQ(frame.depth_mm(7, 5), 757);
      EXPECT_EQ(frame.time_s, 3.25);
      EXPECT_EQ(frame.camera.distortion[4], 0.05);
    }
  }
}

TEST_F(McapTest, ReadsMetres) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::string pixels;
  for (const float metres : {0.5f, nan, -1.0f, 3.25f}) pixels += little(std::bit_cast<std::uint32_t>(metres));
  const std::string image = CdrWriter(false)
                                .header(1.0)
                                .number(std::uint32_t{2})
                                .number(std::uint32_t{2})
                                .text("32FC1")
                                .number(std::uint8_t{0})
                                .number(std::uint32_t{8})
                                .list(pixels)
                                .bytes();
  const Frame frame = open(with_image(image, {.width = 2, .height = 2, .d = {}})).read(0);
  EXPECT_EQ(std::vector<float>(frame.depth_mm.pixels().begin(), frame.depth_mm.pixels().end()),
            (std::vector<float>{500, 0, 0, 3250}));
}

TEST_F(McapTest, TheUnitCanBeSaid) {
  EXPECT_EQ(open(with_image(image_of({}, 700)), {.depth_unit_mm = 0.25}).read(0).depth_mm(0, 0), 175.0f);
}

TEST_F(McapTest, SeveralDepthTopicsAreListedAndOneIsChosen) {
  McapTestWriter mcap = filled({});
  mcap.add("/wrist/depth/image_raw", kMcapImage, 5.0, image_of({.encoding = "mono16"}, 900));
  mcap.add("/wrist/depth/camera_info", kMcapCameraInfo, 5.0, camera_info_of({}));
  EXPECT_THAT(fault(mcap), AllOf(HasSubstr("2 depth topics"), HasSubstr("?topic="), HasSubstr(kMcapDepth),
                                 HasSubstr("/wrist/depth/image_raw")));
  EXPECT_EQ(open(mcap, {.topic = "/wrist/depth/image_raw"}).read(0).depth_mm(0, 0), 900);
  EXPECT_EQ(open_dataset("mcap:" + path().string() + "?topic=/camera/depth/image_raw&first=2")
                ->read(0)
                .depth_mm(0, 0),
            502);
  EXPECT_THAT(fault(mcap, {.topic = "/wrist"}),
              HasSubstr("no images on the topic '/wrist'; those with images"));
  EXPECT_THAT(fault(mcap, {.topic = kMcapColour}), HasSubstr("encoding 'rgb8', expected depth"));
}

TEST_F(McapTest, InfraredComesWithTheDepth) {
  McapTestWriter mcap = filled({});
  for (int i = 0; i < 8; ++i) {
    const TestImage image{.encoding = "mono8", .stamp_s = 1000.0 + i / 30.0, .bytes = 1};
    mcap.add("/camera/infra1/image_rect_raw", kMcapImage, image.stamp_s, image_of(image, 20 + i));
  }
  EXPECT_EQ(open(mcap).read(5).infrared(7, 5), 25 + 57);
  EXPECT_TRUE(open(mcap, {.infrared = "none"}).read(5).infrared.empty());
}

TEST_F(McapTest, WithoutADepthTopicItSaysWhatThereIs) {
  McapTestWriter colour;
  colour.add(kMcapColour, kMcapImage, 5.0, image_of({.encoding = "rgb8"}, 0));
  EXPECT_THAT(fault(colour), AllOf(HasSubstr("no depth topic"), HasSubstr(kMcapColour)));
  McapTestWriter infrared;
  infrared.add("/camera/ir/image", kMcapImage, 5.0, image_of({.encoding = "mono16"}, 0));
  EXPECT_THAT(fault(infrared), HasSubstr("no depth topic"));
  EXPECT_THAT(fault(McapTestWriter()), HasSubstr("topics with images: none"));
  EXPECT_THAT(fault(filled({.encoding = "json"})), HasSubstr("topics with images: none"));
}

TEST_F(McapTest, TheCameraMayComeFromAFile) {
  McapTestWriter mcap;
  mcap.add(kMcapDepth, kMcapImage, 1.0, image_of({}, 700));
  EXPECT_THAT(fault(mcap), AllOf(HasSubstr("no camera on the topic '/camera/depth/camera_info'"),
                                 HasSubstr("?camera=FILE.toml")));
  EXPECT_EQ(open(mcap, {.camera = camera_file()}).read(0).camera.fx, 7.0);
}

TEST_F(McapTest, RefusesWhatItCannotRead) {
  EXPECT_THAT(fault(filled({.magic = "\x89MCAP1\r\n"})), HasSubstr("version '1', expected 0"));
  EXPECT_THAT(fault(filled({.magic = "\x89MCAP0\n\n\n"})), HasSubstr("changed by a transfer as text"));
  EXPECT_THAT(fault(filled({.magic = "#ROSBAG V2.0\n"})), HasSubstr("is not an MCAP file"));
  EXPECT_THAT(fault_of_bytes(""), HasSubstr("is not an MCAP file"));
  EXPECT_THAT(fault(filled({.is_closed = false})), HasSubstr("'mcap recover' mends it"));
  EXPECT_THAT(fault(filled({.compression = "bz2"})),
              HasSubstr("compression 'bz2', expected none, lz4 or zstd"));
}

constexpr std::size_t kFooterBytes = 9 + 8 + 8 + 4;
constexpr std::size_t kMagicBytes = 8;

TEST_F(McapTest, AnEndThatIsNoneIsRefused) {
  const std::string whole = filled({.has_sums = false}).bytes();
  const std::size_t footer = whole.size() - kMagicBytes - kFooterBytes;
  std::string of_another_kind = whole;
  of_another_kind[footer] = 3;
  EXPECT_THAT(fault_of_bytes(of_another_kind), HasSubstr("'mcap recover' mends it"));
  std::string of_another_size = whole;
  of_another_size[footer + 1] = 21;
  EXPECT_THAT(fault_of_bytes(of_another_size), HasSubstr("'mcap recover' mends it"));
  std::string without_magic = whole;
  without_magic.back() = 'x';
  EXPECT_THAT(fault_of_bytes(without_magic), HasSubstr("'mcap recover' mends it"));
  EXPECT_THAT(fault_of_bytes(whole.substr(0, kMagicBytes)), HasSubstr("'mcap recover' mends it"));
  std::string beyond = whole;
  beyond.replace(footer + 9, 8, little(std::uint64_t{footer} + 1));
  EXPECT_THAT(fault_of_bytes(beyond), HasSubstr("the file is damaged: its summary lies beyond its end"));
}

TEST_F(McapTest, RecordsThatCannotBeReadAreNamed) {
  const std::string whole = filled({.has_sums = false}).bytes();
  const std::size_t first =
      kMagicBytes +
      testing::mcap_record(1, testing::with_length("ros2") + testing::with_length("test")).size();
  const auto fault_with = [&](std::size_t place, const std::string& record) {
    return fault_of_bytes(std::string(whole).insert(place, record));
  };
  const std::size_t footer = whole.size() - kMagicBytes - kFooterBytes;
  EXPECT_THAT(fault_with(footer, "abc"), HasSubstr("the file is damaged: a record is cut short"));
  EXPECT_THAT(fault_with(footer, '\x0C' + little(std::uint64_t{5}) + "abc"),
              HasSubstr("the file is damaged: a record has 5 bytes, and 3 are left"));
  EXPECT_THAT(fault_with(footer, testing::mcap_record(11, std::string((1 << 20) + 1, '\0'))),
              HasSubstr("a description has 1048577 bytes, expected at most 1048576"));
  const std::string channel = little(std::uint16_t{7});
  EXPECT_THAT(fault_with(first, testing::mcap_record(7, channel + testing::with_length(""))),
              HasSubstr("the file is damaged: an index without a chunk"));
  EXPECT_THAT(fault_with(first, testing::mcap_record(7, channel + testing::with_length("12345"))),
              HasSubstr("the file is damaged: an index of 5 bytes in 11"));
  EXPECT_THAT(fault_with(first, testing::mcap_record(7, channel + little(std::uint32_t{16}))),
              HasSubstr("the file is damaged: an index of 16 bytes in 6"));
}

/// The index leads to the description of its channel's type, which lies before the message.
TEST_F(McapTest, AnIndexThatLeadsToNoMessageIsAFaultOfTheFrame) {
  const std::string before =
      testing::mcap_record(3, little(std::uint16_t{7}) + testing::with_length(kMcapImage) +
                                  testing::with_length("ros2msg") + testing::with_length("# text")) +
      testing::mcap_record(4, little(std::uint16_t{7}) + little(std::uint16_t{7}) +
                                  testing::with_length(kMcapDepth) + testing::with_length("cdr") +
                                  testing::with_length(testing::with_length("offered_qos_profiles") +
                                                       testing::with_length("")));
  McapTestWriter mcap({.offset_of_offsets = ~std::uint64_t{before.size()} + 1});
  mcap.add(kMcapDepth, kMcapImage, 1.0, image_of({}, 700));
  EXPECT_THAT(fault(mcap, {.topic = kMcapDepth, .camera = camera_file()}),
              HasSubstr("the file is damaged: not the message that its index says"));
}

TEST_F(McapTest, AChunkThatSaysMoreThanItHoldsIsRefused) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    for (const std::uint64_t more : {std::uint64_t{1}, std::uint64_t{200'000'000}}) {
      EXPECT_THAT(fault(filled({.compression = compression, .more_chunk_bytes = more})), HasSubstr("a.mcap"));
    }
    for (const std::uint64_t more : {std::uint64_t{400'000'000}, std::uint64_t{1} << 63}) {
      EXPECT_THAT(fault(filled({.compression = compression, .more_chunk_bytes = more})),
                  HasSubstr("expected at most 268435456"));
    }
  }
}

TEST_F(McapTest, AChunkThatRunsOverItsRecordIsRefused) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    EXPECT_THAT(fault(filled({.compression = compression, .more_packed_bytes = 1})),
                AllOf(HasSubstr("a.mcap"), HasSubstr("the file is damaged: a chunk has")));
  }
}

TEST_F(McapTest, IndexesThatLieAreFaultsOfTheirFrames) {
  for (const std::uint64_t more : {std::uint64_t{1}, std::uint64_t{1} << 40, ~std::uint64_t{0}}) {
    McapTestWriter mcap = filled({.offset_of_offsets = more});
    EXPECT_THAT(fault(mcap, {.topic = kMcapDepth, .camera = camera_file()}), HasSubstr("a.mcap"));
  }
}

TEST_F(McapTest, AnIndexOfAnUnknownChannelIsRefused) {
  EXPECT_THAT(fault(filled({.index_of_channel = 4000})),
              HasSubstr("the channel 4000, which is described nowhere"));
}

TEST_F(McapTest, CountsAreComparedWithTheStatistics) {
  EXPECT_THAT(fault(filled({.more_messages = 1})), HasSubstr("expected 9"));
}

TEST_F(McapTest, ChunksThatUnpackToFarMoreThanTheFileAreNotLookedThrough) {
  McapTestWriter mcap({.compression = "zstd", .has_summary = false, .more_chunk_bytes = 250'000'000});
  for (int i = 0; i < 4; ++i) {
    mcap.add(kMcapDepth, kMcapImage, i, image_of({}, i));
    mcap.end_chunk();
  }
  EXPECT_THAT(fault(mcap), HasSubstr("bytes, expected")) << "each is unpacked, and is not as long as it says";
  mcap.add(kMcapDepth, kMcapImage, 4, image_of({}, 4));
  EXPECT_THAT(fault(mcap), AllOf(HasSubstr("a.mcap: has no index, and unpacks to more than 10738"),
                                 HasSubstr("'mcap recover'")));
}

TEST_F(McapTest, TooManyChannelsAreRefused) {
  McapTestWriter mcap;
  for (int i = 0; i <= 16384; ++i) mcap.add(fmt::format("/{}", i), kMcapImage, 1.0, "");
  EXPECT_THAT(fault(mcap), HasSubstr("more than 16384 channels"));
}

/// A record that says it has as many bytes as a file cannot have, at each place where one begins.
TEST_F(McapTest, LengthsThatLieAreRefused) {
  const std::string whole = filled({.has_chunks = false}, 3).bytes();
  for (std::size_t at = 8; at + 37 < whole.size();) {
    std::uint64_t length = 0;
    std::memcpy(&length, whole.data() + at + 1, sizeof length);
    for (const std::uint64_t lie : {~std::uint64_t{0}, std::uint64_t{1} << 62, std::uint64_t{whole.size()}}) {
      std::string damaged = whole;
      damaged.replace(at + 1, 8, little(lie));
      EXPECT_THAT(fault_of_bytes(damaged), HasSubstr("a.mcap")) << at;
    }
    at += 9 + length;
  }
}

TEST_F(McapTest, MessagesThatAreNoPlainCdrAreRefused) {
  std::string with_parameters = image_of({}, 700);
  with_parameters[1] = '\3';
  EXPECT_THAT(fault(with_image(with_parameters)), HasSubstr("no depth topic"));
  McapTestWriter mcap = with_image(with_parameters);
  const McapOptions chosen{.topic = kMcapDepth};
  EXPECT_THAT(fault(mcap, chosen), HasSubstr("CDR of kind 3, expected 0 or 1"));
  EXPECT_THAT(fault(with_image(""), chosen), HasSubstr("a message of 0 bytes"));
  std::string without_end = image_of({}, 700);
  without_end[without_end.find("16UC1") + 5] = 'x';
  EXPECT_THAT(fault(with_image(without_end), chosen), HasSubstr("a text does not end with 0"));
}

TEST_F(McapTest, MessagesCutAnywhereAreRefused) {
  const std::string image = image_of({.stamp_s = 1.0}, 700);
  for (std::size_t cut = 0; cut < image.size(); ++cut) {
    EXPECT_THAT(fault(with_image(image.substr(0, cut)), {.topic = kMcapDepth}), HasSubstr("a.mcap")) << cut;
  }
  const std::string info = camera_info_of({});
  const std::size_t needed = info.size() - 6 * 4 - 1;
  for (std::size_t cut = 0; cut < needed; cut += 3) {
    McapTestWriter mcap;
    mcap.add(kMcapInfo, kMcapCameraInfo, 0.0, info.substr(0, cut));
    mcap.add(kMcapDepth, kMcapImage, 1.0, image);
    EXPECT_THAT(fault(mcap), HasSubstr("a.mcap")) << cut;
  }
}

TEST_F(McapTest, CoefficientsThatDoNotFitAreRefusedBeforeMemoryIsTaken) {
  CdrWriter writer(false);
  writer.header(1.0).number(std::uint32_t{6}).number(std::uint32_t{8}).text("plumb_bob");
  writer.number(~std::uint32_t{0});
  McapTestWriter mcap;
  mcap.add(kMcapInfo, kMcapCameraInfo, 0.0, writer.bytes());
  mcap.add(kMcapDepth, kMcapImage, 1.0, image_of({}, 700));
  EXPECT_THAT(fault(mcap), HasSubstr("4294967295 numbers in 0 bytes"));
}

TEST_F(McapTest, ADamagedChunkIsAFaultOfItsFramesAlone) {
  std::string bytes = filled({.compression = "zstd"}).bytes();
  const std::string zstd_magic = "\x28\xB5\x2F\xFD";
  const std::size_t second_chunk = bytes.find(zstd_magic, bytes.find(zstd_magic) + 1);
  bytes[second_chunk + 60] ^= 0x10;
  put_file(path(), bytes);
  const McapSource source(path());
  ASSERT_EQ(source.size(), 8);
  int faults = 0;
  for (std::int64_t i = 0; i < source.size(); ++i) {
    try {
      (void)source.read(i);
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("a.mcap"));
      ++faults;
    }
  }
  EXPECT_EQ(faults, 3);
}

/// That a file holds the frames that fuzz/write_mcaps.mjs writes.
void expect_written_frames(const std::filesystem::path& path) {
  const McapSource source(path);
  ASSERT_EQ(source.size(), 3);
  for (std::int64_t i = 0; i < source.size(); ++i) {
    const Frame frame = source.read(i);
    EXPECT_EQ(frame.time_s, 1600000000.25 + static_cast<double>(i) / 32);
    EXPECT_EQ(
        frame.camera,
        (Camera{CameraModel::projective, 16, 12, 15.5, 16.25, 7.25, 5.75, {0.1, -0.2, 0.001, 0.002, 0.03}}));
    for (int row = 0; row < 12; ++row) {
      for (int column = 0; column < 16; ++column) {
        const int expected = (row + column) % 7 == 0 ? 0 : 600 + static_cast<int>(i) + column + 3 * row;
        ASSERT_EQ(frame.depth_mm(column, row), static_cast<float>(expected)) << column << " " << row;
      }
    }
  }
}

constexpr std::array kWrittenFiles{"none", "lz4", "zstd", "no_indexes", "no_summary", "no_chunks"};

/// What fuzz/write_mcaps.mjs wrote with @mcap/core.
TEST(McapOfItsOwnLibrary, IsRead) {
  for (const char* file : kWrittenFiles) {
    SCOPED_TRACE(file);
    expect_written_frames(testing::project_folder() / "fuzz/corpus/mcap" / file);
  }
}

TEST(McapOfItsOwnLibrary, IsReadAsItIsWrittenNow) {
  if (std::system("node --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "Node.js is not on this machine";
  if (!std::filesystem::exists(testing::project_folder() / "web/node_modules/@mcap/core"))
    GTEST_SKIP() << "@mcap/core is not on this machine (scripts/fetch_web_packages.sh)";
  const testing::TemporaryFolder folder;
  const std::string command =
      fmt::format("node '{}' '{}'", (testing::project_folder() / "fuzz/write_mcaps.mjs").string(),
                  folder.path().string());
  ASSERT_EQ(std::system(command.c_str()), 0);
  for (const char* file : kWrittenFiles) {
    SCOPED_TRACE(file);
    expect_written_frames(folder / file);
  }
}

TEST_F(McapTest, TheSumsOfItsOwnLibraryAreChecked) {
  for (const char* file : {"none", "no_chunks", "no_indexes"}) {
    std::string bytes =
        read_regular_file(testing::project_folder() / "fuzz/corpus/mcap" / file, std::int64_t{1} << 20);
    const std::size_t pixels = bytes.find("16UC1") + 60;
    bytes[pixels] ^= 1;
    EXPECT_THAT(fault_of_bytes(bytes), HasSubstr("is damaged: ")) << file;
  }
  std::string bytes =
      read_regular_file(testing::project_folder() / "fuzz/corpus/mcap/none", std::int64_t{1} << 20);
  bytes[bytes.rfind("image_raw")] ^= 1;  // in the summary
  EXPECT_THAT(fault_of_bytes(bytes), HasSubstr("the sum of its summary is another"));
}

}  // namespace
}  // namespace knuckle
