// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdlib>
#include <ostream>

#include "knuckle/core/testing.h"
#include "knuckle/data/readers/azure_calibration.h"
#include "knuckle/data/readers/byte_cursor.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/ebml.h"
#include "knuckle/data/readers/mkv_source.h"
#include "knuckle/data/readers/open_dataset.h"
#include "knuckle/data/readers/recording_testing.h"
#include "knuckle/storage/deflate.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::little;
using testing::put_file;

std::string big(std::uint64_t value, std::size_t bytes) {
  std::string written;
  for (std::size_t i = bytes; i > 0; --i) written += static_cast<char>(value >> (8 * (i - 1)) & 0xFF);
  return written;
}

std::string mkv_id(std::uint32_t id) {
  const std::size_t bytes = id > 0xFFFFFF ? 4 : id > 0xFFFF ? 3 : id > 0xFF ? 2 : 1;
  return big(id, bytes);
}

/// An element with the length in 8 bytes, or without one.
std::string mkv_element(std::uint32_t id, const std::string& content, bool has_size = true) {
  return mkv_id(id) + (has_size ? '\1' + big(content.size(), 7) : "\xFF") + content;
}

std::string mkv_number(std::uint32_t id, std::uint64_t value) {
  return mkv_element(id, big(value, 8));
}

/// The values of a calibration, as a device gives them.
struct TestCalibration {
  std::string purpose = "CALIBRATION_CameraPurposeDepth";
  std::string lens = "CALIBRATION_LensDistortionModelBrownConrady";
  int sensor_width = 1024;
  std::vector<double> parameters{0.5014757513999939,
                                 0.49704870581626892,
                                 0.49203813076019287,
                                 0.49193161725997925,
                                 4.72473669052124,
                                 3.2092227935791016,
                                 0.17059645056724548,
                                 5.0558595657348633,
                                 4.775780200958252,
                                 0.88649415969848633,
                                 0,
                                 0,
                                 0.0001238211989402771,
                                 5.87981094213319e-6};

  std::string json() const {
    return fmt::format(R"({{"CalibrationInformation":{{"Cameras":[{{"Purpose":"Other"}},{{"Purpose":"{}",)"
                       R"("Intrinsics":{{"ModelType":"{}","ModelParameters":[{}]}},)"
                       R"("SensorWidth":{},"SensorHeight":1024}}]}}}})",
                       purpose, lens, fmt::join(parameters, ","), sensor_width);
  }
};

Camera camera_in(const std::string& mode, const TestCalibration& calibration = {}) {
  return parse_azure_calibration(calibration.json(), mode, "a.mkv");
}

/// How a Matroska file is laid out, and what is wrong with it.
struct MkvTestForm {
  bool has_groups = false;  ///< of blocks, in place of simple ones
  bool has_cluster_sizes = true;
  bool has_segment_size = true;
  bool has_track_tags = true;
  bool has_others = false;  ///< elements that say nothing, and sums
  bool tags_come_last = false;
  std::string codec = "V_MS/VFW/FOURCC";
  std::string pixel_code = "b16g";
  std::string depth_name = "DEPTH";
  std::string mode = "NFOV_2X2BINNED";
  std::string calibration_name = "calibration.json";
  std::string calibration = TestCalibration().json() + '\0';
  std::string document = "matroska";
  std::uint64_t version = 4;
  std::uint64_t tick_ns = 1000;
  std::uint64_t width = 320;
  std::uint64_t height = 288;
  std::uint8_t flags = 0x80;  ///< of blocks
  std::string in_track = {};  ///< more elements of the depth track
  std::string in_cluster = {};
  bool has_infrared = true;
};

/// Writes recordings by the format's description.
class MkvTestWriter : private MkvTestForm {
 public:
  explicit MkvTestWriter(MkvTestForm form = {}) : MkvTestForm(std::move(form)) {}

  /// A block of track 1 (depth), 2 (infrared) or 3 (colour).
  void add(int track, std::int64_t ticks, const std::string& content) {
    const std::string block = static_cast<char>(0x80 | track) +
                              big(static_cast<std::uint16_t>(ticks - cluster_ticks_), 2) +
                              static_cast<char>(flags) + content;
    cluster_ += has_groups ? mkv_element(0xA0, mkv_number(0x9B, 1) + mkv_element(0xA1, block))
                           : mkv_element(0xA3, block);
  }

  void end_cluster(std::int64_t next_ticks) {
    std::string others;
    if (has_others) others = mkv_element(0xEC, "nothing");
    clusters_ += mkv_element(
        0x1F43B675,
        mkv_number(0xE7, static_cast<std::uint64_t>(cluster_ticks_)) + others + in_cluster + cluster_,
        has_cluster_sizes);
    cluster_.clear();
    cluster_ticks_ = next_ticks;
  }

  std::string bytes() {
    if (!cluster_.empty()) end_cluster(0);
    std::string segment = with_sum(0x1549A966, mkv_number(0x2AD7B1, tick_ns));
    if (has_others)
      segment = mkv_element(0x114D9B74, "") + mkv_element(0xEC, std::string(90, '\0')) + segment;
    segment += with_sum(0x1654AE6B, tracks());
    segment += tags_come_last ? clusters_ + attachments() + tags() : attachments() + tags() + clusters_;
    if (has_others) segment += mkv_element(0x1C53BB6B, "\xBB\x80");
    return mkv_element(0x1A45DFA3,
                       mkv_element(0x4282, document) + mkv_number(0x42F7, 1) + mkv_number(0x4285, version)) +
           mkv_element(0x18538067, segment, has_segment_size);
  }

 private:
  std::string with_sum(std::uint32_t id, const std::string& content) const {
    const auto* const data = reinterpret_cast<const std::uint8_t*>(content.data());
    const std::string sum = "\xBF\x84" + little(crc32({data, content.size()}));
    return mkv_element(id, (has_others ? sum : "") + content);
  }

  std::string track(int number, const std::string& name, const std::string& more) const {
    const std::string video = mkv_element(
        0xE0, mkv_number(0xB0, width) + mkv_number(0xBA, height) + mkv_element(0x2EB524, pixel_code));
    const std::string header =
        little(std::uint32_t{40}) + std::string(12, '\0') + pixel_code + std::string(20, '\0');
    return mkv_element(0xAE, mkv_number(0xD7, static_cast<std::uint64_t>(number)) +
                                 mkv_number(0x73C5, static_cast<std::uint64_t>(1000 + number)) +
                                 mkv_element(0x536E, name) + mkv_element(0x86, codec) +
                                 mkv_element(0x63A2, header) + video + more);
  }

  std::string tracks() const {
    return mkv_element(0xAE,
                       mkv_number(0xD7, 3) + mkv_element(0x536E, "COLOR") + mkv_element(0x86, "V_MJPEG")) +
           track(1, depth_name, in_track) + (has_infrared ? track(2, "IR", "") : "");
  }

  static std::string tag(const std::string& name, const std::string& value, int track = 0) {
    const std::string targets =
        track == 0 ? "" : mkv_number(0x63C5, static_cast<std::uint64_t>(1000 + track));
    return mkv_element(0x7373,
                       mkv_element(0x63C0, targets) +
                           mkv_element(0x67C8, mkv_element(0x45A3, name) + mkv_element(0x4487, value)));
  }

  std::string tags() const {
    std::string all = tag("K4A_CALIBRATION_FILE", calibration_name);
    if (!mode.empty()) all += tag("K4A_DEPTH_MODE", mode, 1);
    if (has_track_tags) all += tag("K4A_DEPTH_TRACK", "1001", 1) + tag("K4A_IR_TRACK", "1002");
    return with_sum(0x1254C367, all);
  }

  std::string attachments() const {
    const std::string other = mkv_element(0x61A7, mkv_element(0x466E, "a.txt") + mkv_element(0x465C, "text"));
    const std::string file =
        mkv_element(0x61A7, mkv_element(0x466E, "calibration.json") + mkv_element(0x465C, calibration));
    return mkv_element(0x1941A469, other + (calibration.empty() ? "" : file));
  }

  std::string clusters_;
  std::string cluster_;
  std::int64_t cluster_ticks_ = 0;
};

/// Samples of an image: pixel (column, row) is `first` + column + 10 row.
std::string mkv_image(int first, const MkvTestForm& form = {}) {
  return testing::pixels_of({.width = static_cast<std::uint32_t>(form.width),
                             .height = static_cast<std::uint32_t>(form.height),
                             .is_big_endian = form.pixel_code == "b16g"},
                            first);
}

/// `count` frames, 30 per second, 3 a cluster, with infrared and colour between.
MkvTestWriter recorded(const MkvTestForm& form, int count = 5) {
  MkvTestWriter mkv(form);
  for (int i = 0; i < count; ++i) {
    const std::int64_t ticks = 33333 * std::int64_t{i};
    mkv.add(3, ticks, "a picture");
    mkv.add(1, ticks, mkv_image(500 + i, form));
    if (form.has_infrared) mkv.add(2, ticks, mkv_image(100 + i, form));
    // 16 bits are not enough for two times 33.3 ms
    mkv.end_cluster(33333 * std::int64_t{i + 1});
  }
  return mkv;
}

class MkvTest : public ::testing::Test {
 protected:
  std::filesystem::path path() const { return folder_ / "a.mkv"; }
  MkvSource open(MkvTestWriter mkv, const MkvOptions& options = {}) const {
    put_file(path(), mkv.bytes());
    return MkvSource(path(), options);
  }
  /// What is wrong with a recording of this form.
  std::string fault(const MkvTestForm& form, const MkvOptions& options = {}) const {
    return error_of([&] { open(recorded(form, 1), options).read(0); });
  }
  std::string fault_of_bytes(const std::string& bytes) const {
    put_file(path(), bytes);
    return error_of([&] { MkvSource(path()).read(0); });
  }
  /// A camera of 8 x 6 pixels, for small recordings.
  MkvOptions small_options() const {
    put_file(folder_ / "camera.toml", "[camera]\nwidth=8\nheight=6\nfx=7\nfy=7\ncx=4\ncy=3\n");
    return {.camera = (folder_ / "camera.toml").string()};
  }
  static MkvTestForm small(MkvTestForm form = {}) {
    form.width = 8;
    form.height = 6;
    return form;
  }
  /// That a file is read, or refused with its name.
  void expect_answer_or_error(const std::string& bytes, const MkvOptions& options) const {
    put_file(path(), bytes);
    testing::expect_read_or_refused([&] { return MkvSource(path(), options); }, path());
  }

  testing::TemporaryFolder folder_;
};

struct MkvLayout {
  const char* name;
  MkvTestForm form;
};

void PrintTo(const MkvLayout& layout, std::ostream* out) {
  *out << layout.name;
}

class MkvOfEachLayout : public MkvTest, public ::testing::WithParamInterface<MkvLayout> {};

TEST_P(MkvOfEachLayout, GivesDepthInfraredTimesAndCamera) {
  const MkvSource source = open(recorded(GetParam().form));
  ASSERT_EQ(source.size(), 5);
  for (const std::int64_t i : {4, 0, 3, 1, 2}) {
    const Frame frame = source.read(i);
    EXPECT_EQ(frame.depth_mm(0, 0), 500 + i);
    EXPECT_EQ(frame.depth_mm(319, 287), 500 + i + 319 + 2870);
    EXPECT_EQ(frame.infrared(0, 0), 100 + i);
    EXPECT_EQ(frame.infrared(319, 287), 100 + i + 319 + 2870);
    EXPECT_NEAR(*frame.time_s, 0.033333 * static_cast<double>(i), 1e-12);
    EXPECT_EQ(frame.camera, camera_in("NFOV_2X2BINNED"));
  }
  EXPECT_EQ(source.read(3).name, "000003");
  testing::expect_labels_like_frames(source);
}

TEST_P(MkvOfEachLayout, RandomPlacesHaveTheFramesOfAStraightReading) {
  const MkvOptions options = small_options();
  const MkvSource source = open(recorded(small(GetParam().form), 60), options);
  testing::expect_random_places_as_straight(source, MkvSource(path(), options));
}

TEST_P(MkvOfEachLayout, ManyThreadsReadAtOnce) {
  testing::expect_many_threads_may_read(open(recorded(small(GetParam().form), 60), small_options()));
}

/// Where the file says how long it is, it is noticed; else frames may be missing at the end.
TEST_P(MkvOfEachLayout, CutAnywhereIsRefusedOrHasFewerFrames) {
  const MkvOptions options = small_options();
  const std::string whole = recorded(small(GetParam().form), 3).bytes();
  for (std::size_t cut = 0; cut < whole.size(); cut += 7) {
    if (!GetParam().form.has_segment_size) {
      expect_answer_or_error(whole.substr(0, cut), options);
      continue;
    }
    put_file(path(), whole.substr(0, cut));
    EXPECT_THAT(error_of([&] { MkvSource(path(), options); }), HasSubstr("a.mkv")) << cut;
  }
}

TEST_P(MkvOfEachLayout, ChangedBytesAreReadOrRefused) {
  const MkvOptions options = small_options();
  const std::string whole = recorded(small(GetParam().form), 3).bytes();
  for (const std::string& damaged : testing::damaged_copies(whole, 150)) {
    expect_answer_or_error(damaged, options);
    expect_answer_or_error(damaged, {});
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, MkvOfEachLayout,
    ::testing::Values(MkvLayout{"SimpleBlocks", {}}, MkvLayout{"Groups", {.has_groups = true}},
                      MkvLayout{"ClustersWithoutSize", {.has_cluster_sizes = false}},
                      MkvLayout{"NothingWithSize",
                                {.has_groups = true, .has_cluster_sizes = false, .has_segment_size = false}},
                      MkvLayout{"OtherElementsBetween", {.has_others = true}},
                      MkvLayout{"TagsAtTheEnd",
                                {.has_cluster_sizes = false, .has_others = true, .tags_come_last = true}},
                      MkvLayout{"TracksKnownByName", {.has_track_tags = false}},
                      MkvLayout{"LittleEndian", {.pixel_code = "Y16 "}},
                      MkvLayout{"Uncompressed", {.codec = "V_UNCOMPRESSED", .pixel_code = "Y16 "}}),
    [](const auto& instance) { return instance.param.name; });

TEST_F(MkvTest, TheTagSaysWhichTrackIsDepth) {
  EXPECT_EQ(open(recorded({.depth_name = "another name"})).size(), 5);
  EXPECT_THAT(fault({.has_track_tags = false, .depth_name = "another name"}),
              HasSubstr("no depth track (depth mode NFOV_2X2BINNED); its tracks: COLOR, another name, IR"));
}

TEST_F(MkvTest, FramesComeInTheOrderOfTheirTimes) {
  MkvTestWriter mkv(small());
  for (const int i : {2, 0, 1}) mkv.add(1, 10 * i, mkv_image(500 + i, small()));
  const MkvSource source = open(mkv, small_options());
  for (const std::int64_t i : {0, 1, 2}) EXPECT_EQ(source.read(i).depth_mm(0, 0), 500 + i);
}

TEST_F(MkvTest, TimesMayLieBeforeTheirClusters) {
  MkvTestWriter mkv(small());
  mkv.end_cluster(1'000'000);
  mkv.add(1, 999'990, mkv_image(500, small()));
  EXPECT_NEAR(*open(mkv, small_options()).read(0).time_s, 0.99999, 1e-12);
}

TEST_F(MkvTest, AFrameWithoutAnInfraredImageHasNone) {
  MkvTestWriter mkv(small());
  for (int i = 0; i < 3; ++i) {
    mkv.add(1, 10 * i, mkv_image(500 + i, small()));
    if (i != 1) mkv.add(2, 10 * i, mkv_image(100 + i, small()));
  }
  const MkvSource source = open(mkv, small_options());
  EXPECT_EQ(source.read(0).infrared(0, 0), 100);
  EXPECT_TRUE(source.read(1).infrared.empty());
  EXPECT_EQ(source.read(2).infrared(0, 0), 102);
  EXPECT_TRUE(open(recorded(small({.has_infrared = false})), small_options()).read(0).infrared.empty());
}

TEST_F(MkvTest, ABlockOfAnotherSizeIsAFaultOfItsFrame) {
  MkvTestWriter mkv(small());
  for (int i = 0; i < 3; ++i) mkv.add(1, 10 * i, mkv_image(500 + i, small()).substr(i == 1 ? 1 : 0));
  const MkvSource source = open(mkv, small_options());
  EXPECT_EQ(source.read(0).depth_mm(0, 0), 500);
  EXPECT_THAT(error_of([&] { source.read(1); }), HasSubstr("frame 1: has an image of 95 bytes, expected 96"));
  EXPECT_EQ(source.read(2).depth_mm(0, 0), 502);
}

TEST_F(MkvTest, RefusesWhatIsNoMatroskaFile) {
  EXPECT_THAT(fault_of_bytes(""), HasSubstr("is not a Matroska file"));
  EXPECT_THAT(fault_of_bytes("RIFF....AVI "), HasSubstr("is not a Matroska file"));
  EXPECT_THAT(fault({.document = "webm"}), HasSubstr("of the kind 'webm', expected matroska"));
  EXPECT_THAT(fault({.version = 5}),
              HasSubstr("wants a reader of version 5 of Matroska, expected at most 4"));
  const std::string whole = recorded({}, 1).bytes();
  EXPECT_THAT(fault_of_bytes(whole + mkv_element(0x18538067, "")), HasSubstr("several segments"));
  EXPECT_THAT(fault_of_bytes(whole.substr(0, whole.find("\x18\x53\x80\x67"))), HasSubstr("has no segment"));
}

TEST_F(MkvTest, WhatIsNotSupportedIsNamed) {
  EXPECT_THAT(fault({.flags = 0x82}), HasSubstr("several frames per block (lacing), which is not read"));
  EXPECT_THAT(fault({.in_cluster = mkv_element(0xAF, "secret")}), HasSubstr("encrypted blocks"));
  EXPECT_THAT(fault({.in_track = mkv_element(0x6D80, "")}), HasSubstr("'b16g', compressed"));
  EXPECT_THAT(fault({.codec = "V_MPEG4/ISO/AVC"}),
              HasSubstr("track DEPTH: has the codec 'V_MPEG4/ISO/AVC', expected samples of 16 bits: b16g"));
  EXPECT_THAT(fault({.pixel_code = "MJPG"}), HasSubstr("the codec 'MJPG'"));
  EXPECT_THAT(fault({.in_track = mkv_element(0x63A2, "short")}), HasSubstr("the codec 'V_MS/VFW/FOURCC'"));
}

TEST_F(MkvTest, WithoutDepthOrImagesItSaysSo) {
  EXPECT_THAT(fault({.has_track_tags = false, .depth_name = "", .mode = "PASSIVE_IR"}),
              AllOf(HasSubstr("no depth track (depth mode PASSIVE_IR)"), HasSubstr("COLOR, , IR")));
  EXPECT_THAT(error_of([&] { open(MkvTestWriter()); }), HasSubstr("the depth track holds no image"));
}

TEST_F(MkvTest, NoFileMayDescribeTooMuch) {
  const auto fault_of = [&](std::uint32_t id, const std::string& entry, int count) {
    std::string entries;
    for (int i = 0; i < count; ++i) entries += entry;
    put_file(folder_ / "a.mkv", mkv_element(0x1A45DFA3, mkv_element(0x4282, "matroska")) +
                                    mkv_element(0x18538067, mkv_element(id, entries)));
    return error_of([&] { MkvSource(folder_ / "a.mkv", {}); });
  };
  const std::string track = mkv_element(0xAE, mkv_element(0x536E, std::string(5'000, 'n')));
  EXPECT_LT(fault_of(0x1654AE6B, track, 200).size(), 1000) << "names are shortened, and some are enough";
  EXPECT_THAT(fault_of(0x1654AE6B, mkv_element(0xAE, ""), 256), HasSubstr("has no depth track"));
  EXPECT_THAT(fault_of(0x1654AE6B, mkv_element(0xAE, ""), 257), HasSubstr("more than 256 tracks"));
  const std::string tag = mkv_element(0x7373, mkv_element(0x67C8, ""));
  EXPECT_THAT(fault_of(0x1254C367, tag, 4096), HasSubstr("has no depth track"));
  EXPECT_THAT(fault_of(0x1254C367, tag, 4097), HasSubstr("more than 4096 tags"));
  const std::string file = mkv_element(0x61A7, "");
  EXPECT_THAT(fault_of(0x1941A469, file, 4096), HasSubstr("has no depth track"));
  EXPECT_THAT(fault_of(0x1941A469, file, 4097), HasSubstr("more than 4096 files within it"));
}

TEST_F(MkvTest, SizesAreChecked) {
  EXPECT_THAT(fault({.width = 0}), HasSubstr("0x288 pixels, expected 1 to 16384 a side"));
  EXPECT_THAT(fault(small()), HasSubstr("8x6 pixels, and the depth mode has 320x288"));
  EXPECT_THAT(fault({}, small_options()), HasSubstr("camera.toml has 8x6"));
  MkvTestWriter huge({.width = 16385});
  huge.add(1, 0, "x");
  EXPECT_THAT(error_of([&] { open(huge); }), HasSubstr("16385x288 pixels, expected 1 to 16384 a side"));
  const std::string other = mkv_element(0xE0, mkv_number(0xB0, 640) + mkv_number(0xBA, 576));
  EXPECT_THAT(fault({.mode = "NFOV_UNBINNED", .in_track = other}),
              HasSubstr("the infrared images have 320x288 pixels, expected 640x576"));
}

TEST_F(MkvTest, WithoutACalibrationTheCameraMayComeFromAFile) {
  EXPECT_THAT(fault({.calibration = ""}), AllOf(HasSubstr("no calibration (the attachment calibration.json)"),
                                                HasSubstr("?camera=FILE.toml")));
  EXPECT_THAT(fault({.calibration_name = "other.json"}), HasSubstr("the attachment other.json"));
  EXPECT_EQ(open(recorded(small({.calibration = ""})), small_options()).read(0).camera.fx, 7.0);
  EXPECT_EQ(open_dataset("mkv:" + path().string() + "?camera=" + small_options().camera)->read(0).camera.fx,
            7.0);
}

TEST_F(MkvTest, ACalibrationIsChecked) {
  EXPECT_THAT(fault({.calibration = "{"}), HasSubstr("its calibration: is not JSON"));
  EXPECT_THAT(fault({.calibration = "[1, 2]"}), HasSubstr("has no depth camera"));
  EXPECT_THAT(fault({.calibration = std::string(100'000, '[')}), HasSubstr("more than 64 deep"));
  EXPECT_THAT(fault({.calibration = std::string((1 << 20) + 1, ' ')}), HasSubstr("expected at most 1048576"));
  EXPECT_THAT(fault({.mode = ""}), HasSubstr("unknown depth mode ''"));
  EXPECT_THAT(fault({.mode = "NFOV"}), HasSubstr("known are NFOV_UNBINNED, NFOV_2X2BINNED"));
  EXPECT_THAT(fault({.calibration = TestCalibration{.purpose = "Colour"}.json()}),
              HasSubstr("has no depth camera"));
  EXPECT_THAT(fault({.calibration = TestCalibration{.parameters = {0.5, 0.5}}.json()}),
              HasSubstr("2 parameters, expected 14"));
  EXPECT_THAT(fault({.calibration = TestCalibration{.sensor_width = 640}.json()}),
              HasSubstr("SensorWidth is not 1024"));
  EXPECT_THAT(fault({.calibration = TestCalibration{.lens = "Theta"}.json()}), HasSubstr("the lens 'Theta'"));
  TestCalibration without_focus;
  without_focus.parameters[2] = 0.0;
  EXPECT_THAT(fault({.calibration = without_focus.json()}), HasSubstr("a.mkv: its calibration: "));
  std::string not_a_number = TestCalibration().json();
  const std::size_t first = not_a_number.find("0.5014");
  not_a_number.replace(first, not_a_number.find(',', first) - first, "\"0\"");
  EXPECT_THAT(fault({.calibration = not_a_number}),
              HasSubstr("parameter 0 of the depth camera is no number"));
}

TEST(AzureCalibration, OtherLensesAreTakenWhereTheyAreTheSame) {
  TestCalibration rational;
  rational.lens = "CALIBRATION_LensDistortionModelRational6KT";
  EXPECT_THAT(error_of([&] { camera_in("NFOV_UNBINNED", rational); }),
              HasSubstr("Rational6KT' with a shift"));
  rational.parameters[12] = rational.parameters[13] = 0.0;
  TestCalibration brown = rational;
  brown.lens = TestCalibration().lens;
  EXPECT_EQ(camera_in("NFOV_UNBINNED", rational), camera_in("NFOV_UNBINNED", brown));
  brown.parameters[10] = 0.1;
  EXPECT_THAT(error_of([&] { camera_in("NFOV_UNBINNED", brown); }), HasSubstr("with a shift"));
}

/// The order of coefficients, and the centre in coordinates of pixel centres.
TEST(AzureCalibration, IsThatOfOpenCv) {
  const TestCalibration calibration;
  const std::vector<double>& p = calibration.parameters;
  const Camera camera = camera_in("WFOV_UNBINNED");
  EXPECT_EQ(camera.width, 1024);
  EXPECT_EQ(camera.height, 1024);
  EXPECT_DOUBLE_EQ(camera.fx, 1024 * p[2]);
  EXPECT_DOUBLE_EQ(camera.fy, 1024 * p[3]);
  EXPECT_DOUBLE_EQ(camera.cx, 1024 * p[0] - 0.5);
  EXPECT_DOUBLE_EQ(camera.cy, 1024 * p[1] - 0.5);
  EXPECT_EQ(camera.distortion, (std::array{p[4], p[5], p[13], p[12], p[6], p[7], p[8], p[9]}));
}

/// A pixel of the narrow image is one of the wide image; a joined one covers four.
TEST(AzureCalibration, ModesShowTheSameRays) {
  const Camera wide = camera_in("WFOV_UNBINNED");
  const Camera narrow = camera_in("NFOV_UNBINNED");
  EXPECT_EQ(narrow.fx, wide.fx);
  EXPECT_DOUBLE_EQ(narrow.cx, wide.cx - 192);
  EXPECT_DOUBLE_EQ(narrow.cy, wide.cy - 180);
  EXPECT_EQ(narrow.width, 640);
  EXPECT_EQ(narrow.height, 576);
  for (const auto& [full, joined] :
       {std::pair(narrow, camera_in("NFOV_2X2BINNED")), std::pair(wide, camera_in("WFOV_2X2BINNED"))}) {
    EXPECT_EQ(joined.width, full.width / 2);
    EXPECT_EQ(joined.height, full.height / 2);
    for (const double column : {0.0, 100.0}) {  // its centre lies between those of columns 2c and 2c + 1
      EXPECT_NEAR((column - joined.cx) / joined.fx, (2 * column + 0.5 - full.cx) / full.fx, 1e-12);
      EXPECT_NEAR((column - joined.cy) / joined.fy, (2 * column + 0.5 - full.cy) / full.fy, 1e-12);
    }
    EXPECT_EQ(joined.distortion, full.distortion);
  }
}

TEST_F(MkvTest, TimesThatCannotBeAreRefused) {
  EXPECT_THAT(fault({.tick_ns = 0}), HasSubstr("times count 0 ns"));
  EXPECT_THAT(fault({.tick_ns = ~std::uint64_t{0}}), HasSubstr("expected 1 to 1000000000"));
  EXPECT_THAT(fault({.in_cluster = mkv_number(0xE7, ~std::uint64_t{0})}), HasSubstr("a time of 18446744"));
  EXPECT_THAT(fault({.tick_ns = 1'000'000'000, .in_cluster = mkv_number(0xE7, std::uint64_t{1} << 50)}),
              HasSubstr("a time of"));
  EXPECT_THAT(fault({.in_cluster = mkv_element(0xE7, std::string(9, '\0'))}),
              HasSubstr("a number of 9 bytes"));
}

/// Each length in turn says more than there is.
TEST_F(MkvTest, LengthsThatLieAreRefused) {
  const MkvOptions options = small_options();
  const std::string whole = recorded(small({.has_others = true}), 1).bytes();
  int lies = 0;
  for (std::size_t at = 4; at + 8 < whole.size(); ++at) {
    const std::string length = whole.substr(at, 8);
    if (length[0] != '\1' || length.substr(1, 4) != std::string(4, '\0')) continue;
    for (const std::uint64_t lie : {(std::uint64_t{1} << 56) - 2, std::uint64_t{whole.size()}}) {
      std::string damaged = whole;
      damaged.replace(at + 1, 7, big(lie, 7));
      put_file(path(), damaged);
      EXPECT_THAT(error_of([&] { MkvSource(path(), options); }), HasSubstr("a.mkv")) << at;
      ++lies;
    }
  }
  EXPECT_GT(lies, 100);
}

TEST_F(MkvTest, DescriptionsAreBounded) {
  const std::string tracks = mkv_element(0x1654AE6B, std::string((1 << 20) + 1, '\0'));
  EXPECT_THAT(fault_of_bytes(mkv_element(0x1A45DFA3, mkv_element(0x4282, "matroska")) +
                             mkv_element(0x18538067, tracks)),
              HasSubstr("a description has 1048577 bytes, expected at most 1048576"));
}

TEST_F(MkvTest, SumsAreChecked) {
  std::string bytes = recorded({.has_others = true}, 1).bytes();
  bytes[bytes.find("COLOR")] ^= 1;
  EXPECT_THAT(fault_of_bytes(bytes), HasSubstr("the sum of an element is another"));
}

TEST_F(MkvTest, ElementsWithoutASizeAreRefusedWhereTheyCannotEnd) {
  const std::string whole = mkv_element(0x1A45DFA3, mkv_element(0x4282, "matroska")) +
                            mkv_element(0x18538067, mkv_element(0x1654AE6B, "", false), false);
  EXPECT_THAT(fault_of_bytes(whole), HasSubstr("an element without a size"));
}

TEST_F(MkvTest, DescriptionsAreNotOfAnyLength) {
  const std::string header = mkv_element(0x1A45DFA3, mkv_element(0x4282, "matroska"));
  const std::string long_one = mkv_element(0x1549A966, mkv_element(0xEC, std::string(1 << 20, '\0')));
  EXPECT_THAT(fault_of_bytes(header + mkv_element(0x18538067, long_one)),
              HasSubstr("a description has 1048585 bytes, expected at most 1048576"));
}

TEST_F(MkvTest, AnElementEndsWithinWhatItLiesIn) {
  const std::string whole = recorded(small(), 1).bytes();
  EXPECT_THAT(fault_of_bytes(whole.substr(0, whole.size() - 1)),
              HasSubstr(fmt::format("an element ends after byte {}", whole.size() - 1)));
}

TEST_F(MkvTest, ANewerEbmlIsRefused) {
  const std::string header = mkv_element(0x1A45DFA3, mkv_element(0x4282, "matroska") + mkv_number(0x42F7, 2));
  EXPECT_THAT(fault_of_bytes(header + mkv_element(0x18538067, "")),
              HasSubstr("wants a reader of version 2 of EBML, expected at most 1"));
}

TEST(Ebml, HeadsThatCannotBeReadAreNamed) {
  const auto fault = [](const std::vector<std::uint8_t>& bytes) {
    return error_of([&] { parse_ebml_head(bytes, "here"); });
  };
  EXPECT_EQ(parse_ebml_head(std::vector<std::uint8_t>{0xEC, 0x81}, "here").bytes, 1u);
  EXPECT_THAT(fault({}), HasSubstr("here: is cut short: expected an element"));
  EXPECT_THAT(fault({0xEC}), HasSubstr("here: is cut short: expected an element"));
  EXPECT_THAT(fault({0x08, 0x81, 0x81, 0x81, 0x81, 0x81}),
              HasSubstr("here: is damaged: expected an element, found byte 8"));
  EXPECT_THAT(fault({0xEC, 0x00}), HasSubstr("here: is damaged: expected an element, found byte 0"));
  EXPECT_THAT(fault({0x1A, 0x45, 0xDF}), HasSubstr("here: is cut short within the head of an element"));
}

TEST(Ebml, AnElementEndsWithTheBytes) {
  const auto fault = [](const std::vector<std::uint8_t>& bytes) {
    return error_of([&] { EbmlCursor(bytes, "here").next(); });
  };
  const std::vector<std::uint8_t> whole{0xEC, 0x81, 0};
  EXPECT_EQ(EbmlCursor(whole, "here").next()->content.size(), 1u);
  EXPECT_THAT(fault({0xEC, 0x82, 0}), HasSubstr("here: is damaged: an element has 2 bytes, and 1 are left"));
  EXPECT_THAT(fault({0xEC, 0xFF, 0}),
              HasSubstr("here: is damaged: an element has 127 bytes, and 1 are left"));
}

TEST(ByteCursor, TakesNoMoreThanThereIs) {
  const std::vector<std::uint8_t> bytes{1, 2, 3};
  ByteCursor cursor(bytes, "here");
  EXPECT_THAT(error_of([&] { cursor.u32(); }), HasSubstr("here: is cut short: 3 bytes are left, expected 4"));
  EXPECT_EQ(cursor.u16(), 0x201);
  EXPECT_THAT(error_of([&] { cursor.text(2); }),
              HasSubstr("here: is cut short: 1 bytes are left, expected 2"));
}

/// That a file holds the frames that fuzz/write_mkvs.py writes.
void expect_frames_of_ffmpeg(const std::filesystem::path& path, const MkvOptions& options) {
  const MkvSource source(path, options);
  ASSERT_EQ(source.size(), 3);
  for (std::int64_t i = 0; i < source.size(); ++i) {
    const Frame frame = source.read(i);
    EXPECT_NEAR(*frame.time_s, static_cast<double>(i) / 32, 0.0006);  // ffmpeg counts milliseconds
    ASSERT_FALSE(frame.infrared.empty());
    for (int row = 0; row < frame.camera.height; ++row) {
      for (int column = 0; column < frame.camera.width; ++column) {
        const int expected = (row + column) % 7 == 0 ? 0 : 600 + static_cast<int>(i) + column + 3 * row;
        ASSERT_EQ(frame.depth_mm(column, row), static_cast<float>(expected)) << column << " " << row;
        ASSERT_EQ(frame.infrared(column, row), 100 + i + 2 * column + row) << column << " " << row;
      }
    }
  }
}

constexpr std::array kFilesOfFfmpeg{"b16g", "y16", "uncompressed", "live"};

class MkvOfFfmpeg : public MkvTest {
 protected:
  MkvOptions options() const {
    put_file(folder_ / "camera.toml", "[camera]\nwidth=16\nheight=12\nfx=15\nfy=15\ncx=8\ncy=6\n");
    return {.camera = (folder_ / "camera.toml").string()};
  }
};

TEST_F(MkvOfFfmpeg, IsRead) {
  for (const char* file : kFilesOfFfmpeg) {
    SCOPED_TRACE(file);
    expect_frames_of_ffmpeg(testing::project_folder() / "fuzz/corpus/mkv" / file, options());
  }
}

TEST_F(MkvOfFfmpeg, IsReadAsItIsWrittenNow) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "ffmpeg (Debian: ffmpeg) is not on this machine";
  if (std::system("python3 --version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "python3 is not on this machine";
  const std::string script = (testing::project_folder() / "fuzz/write_mkvs.py").string();
  const std::string command = fmt::format("python3 '{}' '{}' --azure", script, folder_.path().string());
  ASSERT_EQ(std::system(command.c_str()), 0);
  for (const char* file : kFilesOfFfmpeg) {
    SCOPED_TRACE(file);
    expect_frames_of_ffmpeg(folder_ / file, options());
  }
  expect_frames_of_ffmpeg(folder_ / "azure.mkv", {});
  EXPECT_EQ(MkvSource(folder_ / "azure.mkv").read(0).camera, camera_in("NFOV_2X2BINNED"));
}

}  // namespace
}  // namespace knuckle
