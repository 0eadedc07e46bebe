// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/rosbag.h"

#include <array>
#include <bit>
#include <cmath>
#include <fstream>
#include <limits>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/open_dataset.h"
#include "knuckle/data/readers/recording_testing.h"
#include "knuckle/data/readers/rosbag_source.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::put_file;

using testing::little;
using testing::little_double;
using testing::packed;
using testing::TestCameraInfo;
using testing::TestImage;
using testing::with_length;

using BagTestFields = std::vector<std::pair<std::string, std::string>>;

std::string record(int op, BagTestFields fields, const std::string& data) {
  std::string header;
  fields.emplace_back("op", std::string(1, static_cast<char>(op)));
  for (const auto& [name, value] : fields) header += with_length(name + "=" + value);
  return with_length(header) + with_length(data);
}

std::string bag_time(double seconds) {
  const double whole = std::floor(seconds);
  return little(static_cast<std::uint32_t>(whole)) +
         little(static_cast<std::uint32_t>(std::llround((seconds - whole) * 1e9)));
}

/// Writes bags by the format's description, with faults where a test wants them.
class BagWriter {
 public:
  explicit BagWriter(std::string compression = "none") : compression_(std::move(compression)) {}

  std::string version = "#ROSBAG V2.0\n";
  std::string encryptor;
  bool is_closed = true;
  std::uint32_t more_chunk_bytes = 0;  ///< that a chunk says it has
  std::uint32_t more_chunks = 0;       ///< that its header counts
  std::uint32_t more_connections = 0;  ///< the same

  void add(const std::string& topic, const std::string& type, double recorded_s, const std::string& message) {
    const std::uint32_t connection = connection_of(topic, type);
    entries_.push_back({connection, recorded_s, static_cast<std::uint32_t>(chunk_.size())});
    chunk_ += record(2, {{"conn", little(connection)}, {"time", bag_time(recorded_s)}}, message);
  }

  void end_chunk() {
    const auto bytes = static_cast<std::uint32_t>(chunk_.size()) + more_chunk_bytes;
    body_ +=
        record(5, {{"compression", compression_}, {"size", little(bytes)}}, packed(chunk_, compression_));
    for (std::uint32_t connection = 0; connection < connections_.size(); ++connection) {
      std::string data;
      std::uint32_t count = 0;
      for (const Entry& entry : entries_) {
        if (entry.connection != connection) continue;
        data += bag_time(entry.recorded_s) + little(entry.offset);
        ++count;
      }
      if (count == 0) continue;
      body_ += record(
          4, {{"ver", little(std::uint32_t{1})}, {"conn", little(connection)}, {"count", little(count)}},
          data);
    }
    ++chunk_count_;
    chunk_.clear();
    entries_.clear();
  }

  std::string bytes() {
    if (!chunk_.empty()) end_chunk();
    std::string index;
    for (std::uint32_t i = 0; i < connections_.size(); ++i) {
      const auto& [topic, type] = connections_[i];
      const std::string about = with_length("topic=" + topic) + with_length("type=" + type);
      index += record(7, {{"conn", little(i)}, {"topic", topic}}, about);
    }
    const std::size_t header_bytes = header(0).size();
    return version + header(is_closed ? version.size() + header_bytes + body_.size() : 0) + body_ + index;
  }

 private:
  struct Entry {
    std::uint32_t connection;
    double recorded_s;
    std::uint32_t offset;
  };

  std::uint32_t connection_of(const std::string& topic, const std::string& type) {
    const auto found = std::ranges::find(connections_, std::pair(topic, type));
    if (found != connections_.end()) return static_cast<std::uint32_t>(found - connections_.begin());
    connections_.emplace_back(topic, type);
    return static_cast<std::uint32_t>(connections_.size() - 1);
  }

  std::string header(std::size_t index_at) const {
    BagTestFields fields{
        {"index_pos", little(static_cast<std::uint64_t>(index_at))},
        {"conn_count", little(static_cast<std::uint32_t>(connections_.size()) + more_connections)},
        {"chunk_count", little(chunk_count_ + more_chunks)}};
    if (!encryptor.empty()) fields.emplace_back("encryptor", encryptor);
    return record(3, fields, std::string(20, ' '));
  }

  std::string compression_;
  std::string body_;
  std::string chunk_;
  std::vector<Entry> entries_;
  std::vector<std::pair<std::string, std::string>> connections_;
  std::uint32_t chunk_count_ = 0;
};

std::string message_header(double stamp_s) {
  return little(std::uint32_t{7}) + bag_time(stamp_s) + with_length("camera_frame");
}

std::string image_message(const TestImage& image, int first) {
  return message_header(image.stamp_s) + little(image.height) + little(image.width) +
         with_length(image.encoding) + little(static_cast<std::uint8_t>(image.is_big_endian)) +
         little(image.step()) + with_length(testing::pixels_of(image, first));
}

std::string camera_message(const TestCameraInfo& info) {
  std::string bytes = message_header(1.0) + little(info.height) + little(info.width) +
                      with_length(info.model) + little(static_cast<std::uint32_t>(info.d.size()));
  for (const double value : info.d) bytes += little_double(value);
  for (const double value : info.k) bytes += little_double(value);
  for (const double value : {1, 0, 0, 0, 1, 0, 0, 0, 1}) bytes += little_double(value);
  for (const double value : info.p) bytes += little_double(value);
  return bytes + std::string(8 + 17, '\0');  // binning, region of interest
}

constexpr const char* kDepth = "/camera/depth/image_raw";
constexpr const char* kInfo = "/camera/depth/camera_info";
constexpr const char* kImage = "sensor_msgs/Image";
constexpr const char* kCameraInfo = "sensor_msgs/CameraInfo";

class RosbagTest : public ::testing::Test {
 protected:
  std::filesystem::path path() const { return folder_ / "a.bag"; }
  RosbagSource open(BagWriter& bag, const RosbagOptions& options = {}) const {
    put_file(path(), bag.bytes());
    return RosbagSource(path(), options);
  }
  std::string fault(BagWriter& bag, const RosbagOptions& options = {}) const {
    return error_of([&] { open(bag, options).read(0); });
  }
  /// `count` frames, 30 per second, 3 a chunk, with a camera and colour images between.
  static BagWriter recording(const std::string& compression, int count = 8) {
    BagWriter bag(compression);
    for (int i = 0; i < count; ++i) {
      const double time_s = 1000.0 + i / 30.0;
      bag.add(kInfo, kCameraInfo, time_s, camera_message({}));
      bag.add(kDepth, kImage, time_s + 0.5, image_message({.stamp_s = time_s}, 500 + i));
      bag.add("/camera/rgb/image_raw", kImage, time_s, image_message({.encoding = "rgb8"}, 0));
      if (i % 3 == 2) bag.end_chunk();
    }
    return bag;
  }

  testing::TemporaryFolder folder_;
};

class RosbagOfEachCompression : public RosbagTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(RosbagOfEachCompression, GivesDepthTimesAndCamera) {
  BagWriter bag = recording(GetParam());
  const RosbagSource source = open(bag);
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

TEST_P(RosbagOfEachCompression, ManyThreadsReadAtOnce) {
  BagWriter bag = recording(GetParam(), 60);
  testing::expect_many_threads_may_read(open(bag));
}

TEST_P(RosbagOfEachCompression, RandomPlacesHaveTheFramesOfAStraightReading) {
  BagWriter bag = recording(GetParam(), 60);
  const RosbagSource source = open(bag);
  testing::expect_random_places_as_straight(source, RosbagSource(path()));
}

TEST_P(RosbagOfEachCompression, CutAnywhereIsRefused) {
  BagWriter bag = recording(GetParam());
  const std::string whole = bag.bytes();
  for (std::size_t cut = 0; cut < whole.size(); cut += 13) {
    put_file(path(), whole.substr(0, cut));
    EXPECT_THAT(error_of([&] { RosbagSource source(path()); }), HasSubstr("a.bag")) << cut;
  }
}

TEST_P(RosbagOfEachCompression, ChangedBytesAreReadOrRefused) {
  BagWriter bag = recording(GetParam());
  for (const std::string& damaged : testing::damaged_copies(bag.bytes(), 1000)) {
    put_file(path(), damaged);
    testing::expect_read_or_refused([&] { return RosbagSource(path()); }, path());
  }
}

/// What fuzz/write_bags.py wrote with ROS's own library.
TEST_P(RosbagOfEachCompression, ReadsWhatRosWrites) {
  const RosbagSource source(testing::project_folder() / "fuzz/corpus/rosbag" / GetParam());
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

INSTANTIATE_TEST_SUITE_P(All, RosbagOfEachCompression, ::testing::Values("none", "bz2", "lz4"));

TEST_F(RosbagTest, FramesComeInTheOrderOfTheirStamps) {
  BagWriter bag;
  bag.add(kInfo, kCameraInfo, 0.0, camera_message({}));
  for (const int i : {2, 0, 1})
    bag.add(kDepth, kImage, 10.0 - i, image_message({.stamp_s = 100.0 + i}, 500 + i));
  const RosbagSource source = open(bag);
  for (const std::int64_t i : {0, 1, 2}) EXPECT_EQ(source.read(i).depth_mm(0, 0), 500 + i);
}

TEST_F(RosbagTest, WithoutStampsTheTimeIsThatOfRecording) {
  BagWriter bag;
  bag.add(kInfo, kCameraInfo, 0.0, camera_message({}));
  bag.add(kDepth, kImage, 12.5, image_message({}, 500));
  EXPECT_EQ(open(bag).read(0).time_s, 12.5);
}

TEST_F(RosbagTest, ReadsBothOrdersOfBytesAndPaddedRows) {
  BagWriter bag;
  bag.add(kInfo, kCameraInfo, 0.0, camera_message({}));
  bag.add(kDepth, kImage, 1.0, image_message({.is_big_endian = true, .padding = 5}, 700));
  const Frame frame = open(bag).read(0);
  EXPECT_EQ(frame.depth_mm(0, 0), 700);
  EXPECT_EQ(frame.depth_mm(7, 5), 757);
}

TEST_F(RosbagTest, ReadsMetres) {
  BagWriter bag;
  bag.add(kInfo, kCameraInfo, 0.0, camera_message({.width = 4, .height = 2, .d = {}}));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  std::string pixels;
  for (const float metres : {0.5f, nan, infinity, -1.0f, 0.0f, 3.25f, 1e38f, 2.0f})
    pixels += little(std::bit_cast<std::uint32_t>(metres));
  bag.add(kDepth, kImage, 1.0,
          message_header(1.0) + little(std::uint32_t{2}) + little(std::uint32_t{4}) + with_length("32FC1") +
              little(std::uint8_t{0}) + little(std::uint32_t{16}) + with_length(pixels));
  const Frame frame = open(bag).read(0);
  EXPECT_EQ(std::vector<float>(frame.depth_mm.pixels().begin(), frame.depth_mm.pixels().end()),
            (std::vector<float>{500, 0, 0, 0, 0, 3250, 0, 2000}));
}

/// As RealSense's recorder names its topics.
BagWriter realsense_bag(float metres_per_count) {
  const std::string sensor = "/device_0/sensor_0";
  BagWriter bag("lz4");
  bag.add(sensor + "/option/Exposure/value", "std_msgs/Float32", 0.0,
          little(std::bit_cast<std::uint32_t>(33.0f)));
  bag.add(sensor + "/option/Depth_Units/value", "std_msgs/Float32", 0.0,
          little(std::bit_cast<std::uint32_t>(metres_per_count)));
  bag.add(sensor + "/Depth_0/info/camera_info", kCameraInfo, 0.0,
          camera_message({.model = "Brown Conrady", .d = {0, 0, 0, 0, 0}}));
  bag.add(sensor + "/Depth_0/image/data", kImage, 1.0,
          image_message({.encoding = "mono16", .stamp_s = 1.0}, 1000));
  bag.add(sensor + "/Infrared_1/image/data", kImage, 1.0, image_message({.encoding = "mono16"}, 0));
  return bag;
}

TEST_F(RosbagTest, ReadsRealSensesTopicsAndUnit) {
  BagWriter millimetres = realsense_bag(0.001f);
  const Frame frame = open(millimetres).read(0);
  EXPECT_EQ(frame.depth_mm(0, 0), 1000.0f);
  EXPECT_EQ(frame.camera.fx, 7.5);
  EXPECT_FALSE(frame.camera.is_distorted());
  BagWriter tenths = realsense_bag(0.0001f);
  EXPECT_EQ(open(tenths).read(0).depth_mm(0, 0), 100.0f);
  EXPECT_EQ(open(tenths, {.depth_unit_mm = 0.25}).read(0).depth_mm(0, 0), 250.0f);
  for (const float wrong : {0.0f, -1.0f, 2.0f, std::numeric_limits<float>::quiet_NaN()}) {
    BagWriter bag = realsense_bag(wrong);
    EXPECT_THAT(fault(bag), HasSubstr("m per count, expected a number from 0 to 1"));
  }
}

TEST_F(RosbagTest, SeveralDepthTopicsAreListedAndOneIsChosen) {
  BagWriter bag = recording("none");
  bag.add("/wrist/depth/image_raw", kImage, 5.0, image_message({.encoding = "mono16"}, 900));
  bag.add("/wrist/depth/camera_info", kCameraInfo, 5.0, camera_message({}));
  EXPECT_THAT(fault(bag), AllOf(HasSubstr("2 depth topics"), HasSubstr("?topic="), HasSubstr(kDepth),
                                HasSubstr("/wrist/depth/image_raw")));
  EXPECT_EQ(open(bag, {.topic = "/wrist/depth/image_raw"}).read(0).depth_mm(0, 0), 900);
  EXPECT_EQ(open_dataset("rosbag:" + path().string() + "?topic=/camera/depth/image_raw&first=2")
                ->read(0)
                .depth_mm(0, 0),
            502);
  EXPECT_THAT(fault(bag, {.topic = "/wrist"}),
              HasSubstr("no images on the topic '/wrist'; those with images"));
  EXPECT_THAT(fault(bag, {.topic = "/camera/rgb/image_raw"}), HasSubstr("encoding 'rgb8', expected depth"));
}

TEST_F(RosbagTest, WithoutADepthTopicItSaysWhatThereIs) {
  BagWriter colour;
  colour.add("/camera/rgb/image_raw", kImage, 5.0, image_message({.encoding = "rgb8"}, 0));
  EXPECT_THAT(fault(colour), AllOf(HasSubstr("no depth topic"), HasSubstr("/camera/rgb/image_raw")));
  BagWriter infrared;
  infrared.add("/camera/ir/image", kImage, 5.0, image_message({.encoding = "mono16"}, 0));
  EXPECT_THAT(fault(infrared), HasSubstr("no depth topic"));
  BagWriter empty;
  EXPECT_THAT(fault(empty), HasSubstr("topics with images: none"));
}

class RosbagInfrared : public RosbagTest {
 protected:
  static constexpr const char* kLeft = "/camera/infra1/image_rect_raw";
  static constexpr const char* kRight = "/camera/infra2/image_rect_raw";

  /// Eight frames, with both images of a RealSense camera; its left one is 20 + the frame's number.
  static BagWriter with_infrared(const TestImage& form = {.encoding = "mono8", .bytes = 1},
                                 double late_s = 0.0) {
    BagWriter bag = recording("none");
    for (int i = 0; i < 8; ++i) {
      TestImage image = form;
      image.stamp_s = 1000.0 + i / 30.0 + late_s;
      bag.add(kRight, kImage, image.stamp_s, image_message(image, 80 + i));
      bag.add(kLeft, kImage, image.stamp_s, image_message(image, 20 + i));
    }
    return bag;
  }
};

TEST_F(RosbagInfrared, ComesWithTheDepth) {
  for (const char* const encoding : {"mono8", "8UC1", "mono16", "16UC1"}) {
    const bool is_small = std::string(encoding).find('8') != std::string::npos;
    BagWriter bag = with_infrared(
        {.encoding = encoding, .is_big_endian = !is_small, .padding = 3, .bytes = is_small ? 1U : 2U});
    const RosbagSource source = open(bag);
    for (const std::int64_t i : {7, 0, 3}) {
      const Frame frame = source.read(i);
      EXPECT_EQ(frame.depth_mm(0, 0), 500 + i);
      ASSERT_EQ(frame.infrared.width(), 8) << encoding;
      EXPECT_EQ(frame.infrared(0, 0), 20 + i) << encoding;
      EXPECT_EQ(frame.infrared(7, 5), 20 + i + 57) << encoding;
    }
  }
}

TEST_F(RosbagInfrared, MayBeChosenOrLeftOut) {
  BagWriter bag = with_infrared();
  EXPECT_EQ(open(bag, {.infrared = kRight}).read(2).infrared(0, 0), 82);
  EXPECT_TRUE(open(bag, {.infrared = "none"}).read(2).infrared.empty());
  EXPECT_EQ(open_dataset("rosbag:" + path().string() + "?infrared=" + kRight)->read(0).infrared(0, 0), 80);
  EXPECT_THAT(fault(bag, {.infrared = "/nothing"}), HasSubstr("no images on the topic '/nothing'"));
  EXPECT_THAT(fault(bag, {.infrared = "/camera/rgb/image_raw"}),
              HasSubstr("no infrared images of 8x6 pixels"));
}

TEST_F(RosbagInfrared, IsThatOfTheSameMoment) {
  BagWriter near = with_infrared({.encoding = "mono8", .bytes = 1}, 0.009);
  EXPECT_EQ(open(near).read(3).infrared(0, 0), 23);
  BagWriter before = with_infrared({.encoding = "mono8", .bytes = 1}, -0.009);
  EXPECT_EQ(open(before).read(3).infrared(0, 0), 23);
  BagWriter far = with_infrared({.encoding = "mono8", .bytes = 1}, 0.0111);
  EXPECT_TRUE(open(far).read(3).infrared.empty());
}

TEST_F(RosbagInfrared, OfAnotherSizeIsLeftAlone) {
  BagWriter bag = with_infrared({.width = 16, .height = 12, .encoding = "mono8", .bytes = 1});
  EXPECT_TRUE(open(bag).read(0).infrared.empty());
  EXPECT_THAT(fault(bag, {.infrared = kLeft}), HasSubstr("no infrared images of 8x6 pixels"));
}

/// Images of 16 bits in a topic that is named so are no depth.
TEST_F(RosbagInfrared, IsNotTakenForDepth) {
  BagWriter bag = recording("none");
  bag.add("/camera/ir/image_raw", kImage, 1000.0, image_message({.stamp_s = 1000.0}, 30));
  const RosbagSource source = open(bag);
  EXPECT_EQ(source.read(0).depth_mm(0, 0), 500);
  EXPECT_EQ(source.read(0).infrared(0, 0), 30);
  EXPECT_TRUE(source.read(1).infrared.empty());
}

TEST_F(RosbagInfrared, DamagedIsAFaultOfItsFrame) {
  BagWriter short_row = with_infrared();
  TestImage wide{.width = 8, .encoding = "mono8", .stamp_s = 1010.0, .bytes = 1};
  std::string message = image_message(wide, 1);
  message.resize(message.size() - 5);
  short_row.add(kLeft, kImage, 1010.0, message);
  short_row.add(kDepth, kImage, 1010.0, image_message({.stamp_s = 1010.0}, 900));
  const RosbagSource cut = open(short_row);
  EXPECT_EQ(cut.read(7).infrared(0, 0), 27);
  EXPECT_THAT(error_of([&] { cut.read(8); }), AllOf(HasSubstr(kLeft), HasSubstr("frame 8")));
}

TEST_F(RosbagTest, ARectifiedTopicHasTheRectifiedCamera) {
  BagWriter bag;
  bag.add(kInfo, kCameraInfo, 0.0, camera_message({}));
  bag.add("/camera/depth/image_rect_raw", kImage, 1.0, image_message({}, 700));
  EXPECT_EQ(open(bag).read(0).camera, (Camera{CameraModel::projective, 8, 6, 7.0, 6.5, 3.0, 2.0, {}}));
}

class RosbagCamera : public RosbagTest {
 protected:
  BagWriter with(const TestCameraInfo& info) const {
    BagWriter bag;
    bag.add(kInfo, kCameraInfo, 0.0, camera_message(info));
    bag.add(kDepth, kImage, 1.0, image_message({}, 700));
    return bag;
  }
  std::string fault_with(const TestCameraInfo& info) const {
    BagWriter bag = with(info);
    return fault(bag);
  }
};

TEST_F(RosbagCamera, TakesOpenCvsDistortions) {
  const std::vector<double> d{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8};
  BagWriter bag = with({.model = "rational_polynomial", .d = d});
  const Camera camera = open(bag).read(0).camera;
  EXPECT_EQ(std::vector<double>(camera.distortion.begin(), camera.distortion.end()), d);
}

TEST_F(RosbagCamera, NamesWhatIsWrong) {
  EXPECT_THAT(fault_with({.model = "equidistant"}), AllOf(HasSubstr("'equidistant'"), HasSubstr("?camera=")));
  EXPECT_THAT(fault_with({.d = std::vector<double>(9, 0.1)}), HasSubstr("9 coefficients"));
  EXPECT_THAT(fault_with({.k = {}}), HasSubstr("camera_info: the camera was not calibrated"));
  EXPECT_THAT(fault_with({.k = {7, 0, std::nan(""), 0, 7, 2, 0, 0, 1}}), HasSubstr("camera_info"));
  EXPECT_THAT(fault_with({.width = 0}), HasSubstr("camera_info"));
  EXPECT_THAT(fault_with({.width = 4000000000u}), HasSubstr("at most 16384 a side"));
  EXPECT_THAT(fault_with({.width = 16}), HasSubstr("frame 0: is 8x6 pixels, expected 16x6"));
}

TEST_F(RosbagCamera, MayComeFromAFile) {
  BagWriter bag;
  bag.add(kDepth, kImage, 1.0, image_message({}, 700));
  EXPECT_THAT(fault(bag), AllOf(HasSubstr("no camera on the topic '/camera/depth/camera_info'"),
                                HasSubstr("?camera=FILE.toml")));
  put_file(folder_ / "camera.toml",
           "pixel_origin='corner'\n[camera]\nwidth=8\nheight=6\nfx=7\nfy=7\ncx=4\ncy=3\n");
  const Camera camera = open(bag, {.camera = (folder_ / "camera.toml").string()}).read(0).camera;
  EXPECT_EQ(camera.cx, 3.5);
}

TEST_F(RosbagTest, RefusesWhatItCannotRead) {
  const auto fault_of = [&](const auto& change) {
    BagWriter bag = recording("none");
    change(bag);
    return fault(bag);
  };
  EXPECT_THAT(fault_of([](BagWriter& bag) { bag.version = "#ROSBAG V1.2\n"; }),
              HasSubstr("version '1.2', expected 2.0"));
  EXPECT_THAT(fault_of([](BagWriter& bag) { bag.version = "#ROSBAG V2.1\n"; }), HasSubstr("version '2.1'"));
  EXPECT_THAT(fault_of([](BagWriter& bag) { bag.version = "SQLite format"; }), HasSubstr("not a ROS 1 bag"));
  EXPECT_THAT(fault_of([](BagWriter& bag) { bag.encryptor = "rosbag/AesCbcEncryptor"; }),
              HasSubstr("is encrypted"));
  EXPECT_THAT(fault_of([](BagWriter& bag) { bag.is_closed = false; }), HasSubstr("rosbag reindex"));
  EXPECT_THAT(fault_of([](BagWriter& bag) { bag.more_chunks = 1; }), HasSubstr("cut short or damaged: has"));
  EXPECT_THAT(fault_of([](BagWriter& bag) { bag.more_connections = 1; }),
              HasSubstr("cut short or damaged: has"));
  BagWriter zstd("zstd");
  zstd.add(kDepth, kImage, 1.0, image_message({}, 700));
  EXPECT_THAT(fault(zstd), HasSubstr("compression 'zstd', expected none, bz2 or lz4"));
}

/// The beginning of a bag that says how many connections and chunks it has, and where its index begins.
std::string bag_header(std::uint32_t connections, std::uint32_t chunks, std::uint64_t index_at = 1) {
  return "#ROSBAG V2.0\n" + record(3,
                                   {{"index_pos", little(index_at)},
                                    {"conn_count", little(connections)},
                                    {"chunk_count", little(chunks)}},
                                   "");
}

std::string connection_record(std::uint32_t number, const std::string& topic) {
  return record(7, {{"conn", little(number)}, {"topic", topic}}, with_length(std::string("type=") + kImage));
}

std::string plain_chunk(const std::string& content, std::uint32_t bytes) {
  return record(5, {{"compression", "none"}, {"size", little(bytes)}}, content);
}

std::string index_record(std::uint32_t version, std::uint32_t connection, std::uint32_t count,
                         const std::string& entries) {
  return record(4, {{"ver", little(version)}, {"conn", little(connection)}, {"count", little(count)}},
                entries);
}

class DamagedRosbag : public RosbagTest {
 protected:
  std::string fault_of(const std::string& bytes) const {
    put_file(path(), bytes);
    return error_of([&] { Rosbag bag(path()); });
  }
};

TEST_F(DamagedRosbag, IsReadWhereNothingIsWrong) {
  put_file(path(),
           bag_header(1, 1) + plain_chunk("abc", 3) + index_record(1, 0, 0, "") + connection_record(0, "/a"));
  EXPECT_NO_THROW(Rosbag{path()});
}

TEST_F(DamagedRosbag, OfOtherRecordsThanItSaysIsRefused) {
  EXPECT_THAT(
      fault_of(bag_header(1, 0)),
      HasSubstr("a.bag: the bag is cut short or damaged: has 0 chunks and 0 connections, expected 0 and 1"));
  EXPECT_THAT(fault_of(bag_header(1, 1) + connection_record(0, "/a")),
              HasSubstr("has 0 chunks and 1 connections, expected 1 and 1"));
  EXPECT_THAT(fault_of("#ROSBAG V2.0\n" + connection_record(0, "/a")),
              HasSubstr("a.bag: the bag is damaged: it does not begin with its header"));
  EXPECT_THAT(fault_of(bag_header(0, 0, 1'000'000)), HasSubstr("and its index begins at 1000000"));
  EXPECT_THAT(fault_of(bag_header(0, 0) + record(9, {}, "")),
              HasSubstr("the bag is damaged: a record of an unknown kind"));
}

TEST_F(DamagedRosbag, RecordsThatCannotBeReadAreNamed) {
  EXPECT_THAT(fault_of(bag_header(0, 0) + with_length(with_length("nothing")) + with_length("")),
              HasSubstr("the bag is damaged: a field has no '='"));
  EXPECT_THAT(fault_of(bag_header(0, 0) + with_length(with_length("op=ab")) + with_length("")),
              HasSubstr("the field 'op' has 2 bytes, expected 1"));
  EXPECT_THAT(fault_of(bag_header(0, 0) + record(7, {{"conn", "12"}}, "")),
              HasSubstr("the field 'conn' has 2 bytes, expected 4"));
  EXPECT_THAT(fault_of(bag_header(0, 0) + "ab"), HasSubstr("a record ends after byte"));
  EXPECT_THAT(fault_of(bag_header(0, 0) + little(std::uint32_t{5}) + "ab"),
              HasSubstr("a record ends after byte"));
  EXPECT_THAT(fault_of(bag_header(0, 0) + record(9, {}, "ab").substr(0, 13)),
              HasSubstr("a record ends after byte"));
  const std::string long_text((1 << 20) + 1, 'x');
  EXPECT_THAT(fault_of(bag_header(0, 0) + record(7, {{"topic", long_text}}, "")),
              HasSubstr("bytes, expected at most 1048576"));
  EXPECT_THAT(
      fault_of(bag_header(1, 0) + record(7, {{"conn", little(0u)}}, with_length("type=" + long_text))),
      HasSubstr("the description of a connection has 1048586 bytes, expected at most 1048576"));
}

TEST_F(DamagedRosbag, ChunksAndIndexesThatDoNotFitAreRefused) {
  EXPECT_THAT(fault_of(bag_header(0, 1) + plain_chunk("abc", 5)),
              HasSubstr("a chunk has 3 bytes, expected 5"));
  const std::string chunk = plain_chunk("abc", 3);
  EXPECT_THAT(fault_of(bag_header(0, 1) + chunk + index_record(2, 0, 0, "")),
              HasSubstr("an index of version 2, expected 1"));
  EXPECT_THAT(fault_of(bag_header(0, 1) + chunk + index_record(1, 0, 2, std::string(12, '\0'))),
              HasSubstr("the bag is damaged: 2 entries in 12 bytes"));
  EXPECT_THAT(fault_of(bag_header(0, 0) + index_record(1, 0, 0, "")),
              HasSubstr("the bag is damaged: an index without a chunk"));
}

TEST_F(DamagedRosbag, AMessageOfAnotherConnectionIsNotTheOneThatIsMeant) {
  const std::string message = record(2, {{"conn", little(0u)}, {"time", bag_time(1.0)}}, "content");
  const std::string rest = index_record(1, 1, 1, bag_time(1.0) + little(0u)) + connection_record(0, "/a") +
                           connection_record(1, "/b");
  const std::string as_bz2 =
      record(5, {{"compression", "bz2"}, {"size", little(static_cast<std::uint32_t>(message.size()))}},
             packed(message, "bz2"));
  for (const std::string& chunk :
       {plain_chunk(message, static_cast<std::uint32_t>(message.size())), as_bz2}) {
    put_file(path(), bag_header(2, 1) + chunk + rest);
    const Rosbag bag(path());
    const std::vector<RecordedMessage> messages = bag.messages_of("/b");
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_THAT(error_of([&] { bag.read(messages[0], 100); }),
                HasSubstr("the bag is damaged: not the message that its index says"));
  }
}

TEST_F(DamagedRosbag, AMessageLargerThanItMayBeIsRefused) {
  constexpr std::uint32_t kBytes = (1u << 28) + 1;
  const std::string all_but_content = record(2, {{"conn", little(0u)}, {"time", bag_time(1.0)}}, "");
  const std::string message_head = all_but_content.substr(0, all_but_content.size() - 4) + little(kBytes);
  const auto chunk_bytes = static_cast<std::uint32_t>(message_head.size()) + kBytes;
  const std::string chunk = plain_chunk("", chunk_bytes);
  const std::string start = bag_header(1, 1) + chunk.substr(0, chunk.size() - 4) + little(chunk_bytes);
  {
    std::ofstream file(path(), std::ios::binary);  // of which hardly anything takes room on the disk
    file << start << message_head;
    file.seekp(static_cast<std::streamoff>(start.size() + chunk_bytes));
    file << index_record(1, 0, 1, bag_time(1.0) + little(0u)) << connection_record(0, "/a");
  }
  const Rosbag bag(path());
  EXPECT_THAT(error_of([&] { bag.read(bag.messages_of("/a").at(0), 100); }),
              HasSubstr("a message has 268435457 bytes, expected at most 268435456"));
}

TEST_F(RosbagTest, TooManyConnectionsAreRefused) {
  BagWriter bag;
  for (int i = 0; i <= 16384; ++i) bag.add(fmt::format("/{}", i), kImage, 1.0, "");
  EXPECT_THAT(fault(bag), HasSubstr("more than 16384 connections"));
}

TEST_F(RosbagTest, DescriptionsAreBounded) {
  BagWriter of_long_topic;
  of_long_topic.add("/" + std::string(std::size_t{1} << 20, 't'), kImage, 1.0, "");
  EXPECT_THAT(fault(of_long_topic), HasSubstr("bytes, expected at most 1048576"));
  BagWriter of_long_type;
  of_long_type.add(kDepth, std::string(std::size_t{1} << 20, 't'), 1.0, "");
  EXPECT_THAT(fault(of_long_type), HasSubstr("the description of a connection has"));
}

TEST_F(RosbagTest, AChunkThatSaysMoreThanItHoldsIsRefused) {
  for (const char* compression : {"bz2", "lz4"}) {
    for (const std::uint32_t more : {1u, 200'000'000u, ~0u}) {
      BagWriter bag(compression);
      bag.more_chunk_bytes = more;
      bag.add(kInfo, kCameraInfo, 0.0, camera_message({}));
      bag.add(kDepth, kImage, 1.0, image_message({}, 700));
      EXPECT_THAT(fault(bag), HasSubstr("a.bag")) << compression << " " << more;
    }
    BagWriter huge(compression);
    huge.more_chunk_bytes = 400'000'000;
    huge.add(kDepth, kImage, 1.0, image_message({}, 700));
    EXPECT_THAT(fault(huge), HasSubstr("expected at most 268435456"));
  }
}

TEST_F(RosbagTest, SizesOfImagesAreChecked) {
  const auto fault_with = [&](std::uint32_t width, std::uint32_t height, std::uint32_t step) {
    BagWriter bag;
    bag.add(kInfo, kCameraInfo, 0.0, camera_message({}));
    bag.add(kDepth, kImage, 1.0,
            message_header(1.0) + little(height) + little(width) + with_length("16UC1") +
                little(std::uint8_t{0}) + little(step) + with_length(std::string(96, '\1')));
    return fault(bag);
  };
  EXPECT_THAT(fault_with(8, 6, 15), HasSubstr("rows of 15 bytes, expected at least 16"));
  EXPECT_THAT(fault_with(8, 5, 16), HasSubstr("96 bytes, expected 80"));
  EXPECT_THAT(fault_with(0, 6, 16), HasSubstr("0x6 pixels"));
  EXPECT_THAT(fault_with(4294967295u, 4294967295u, 4294967295u), HasSubstr("1 to 16384 a side"));
  EXPECT_THAT(fault_with(16384, 2048, 32768), HasSubstr("96 bytes, expected 67108864"));
  EXPECT_THAT(fault_with(16384, 2049, 32768), HasSubstr("16384 x 2049 pixels, expected at most 33554432"));
}

TEST_F(RosbagTest, ADamagedChunkIsAFaultOfItsFramesAlone) {
  BagWriter bag = recording("bz2");
  std::string bytes = bag.bytes();
  const std::size_t second_chunk = bytes.find("BZh9", bytes.find("BZh9") + 1);
  bytes[second_chunk + 40] ^= 0x10;
  put_file(path(), bytes);
  const RosbagSource source(path());
  ASSERT_EQ(source.size(), 8);
  int faults = 0;
  for (std::int64_t i = 0; i < source.size(); ++i) {
    try {
      (void)source.read(i);
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("a.bag"));
      ++faults;
    }
  }
  EXPECT_EQ(faults, 3);
}

}  // namespace
}  // namespace knuckle
