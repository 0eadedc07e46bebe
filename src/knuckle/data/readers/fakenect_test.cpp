// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cmath>
#include <cstdlib>
#include <functional>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/testing_memory.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/fakenect_source.h"
#include "knuckle/data/readers/folder_format.h"
#include "knuckle/data/readers/open_dataset.h"
#include "knuckle/data/readers/pgm_image.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::peak_memory_kb;
using testing::put_file;

constexpr int kWidth = 640;
constexpr int kHeight = 480;

std::string bytes_of(const Image<std::uint16_t>& image, std::endian order) {
  std::string bytes;
  for (const std::uint16_t value : image.pixels()) {
    const char low = static_cast<char>(value & 0xFF);
    const char high = static_cast<char>(value >> 8);
    bytes += order == std::endian::little ? low : high;
    bytes += order == std::endian::little ? high : low;
  }
  return bytes;
}

std::string pgm_of(const Image<std::uint16_t>& image, std::endian order = std::endian::little) {
  return fmt::format("P5 {} {} 65535\n", image.width(), image.height()) + bytes_of(image, order);
}

/// A slanted wall in raw values, with a strip without measurement as at the right of every raw image.
Image<std::uint16_t> raw_wall(int offset = 0) {
  Image<std::uint16_t> image(kWidth, kHeight);
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      image(column, row) =
          static_cast<std::uint16_t>(column >= 632 ? 2047 : 400 + column / 2 + row / 4 + offset);
    }
  }
  return image;
}

/// The same in millimetres, nearer than 2047 mm.
Image<std::uint16_t> near_wall_mm() {
  Image<std::uint16_t> image = raw_wall(300);
  for (std::uint16_t& value : image.pixels()) value = value == 2047 ? 0 : value;
  return image;
}

class Fakenect : public ::testing::Test {
 protected:
  /// A recording of these depth images, 30 per second, from a number of ticks on.
  void write(const std::vector<std::string>& images, std::uint32_t ticks = 6000000) {
    std::string index;
    for (std::size_t i = 0; i < images.size(); ++i) {
      const std::string name = fmt::format("{:.6f}-{}", 1300000000.0 + static_cast<double>(i) / 30, ticks);
      index += fmt::format("d-{0}.pgm\nr-{0}.ppm\na-{0}.dump\n", name);
      put_file(folder_ / fmt::format("d-{}.pgm", name), images[i]);
      ticks += 2000000;
    }
    put_file(folder_ / "INDEX.txt", index);
  }
  FakenectSource open(const std::string& depth = "auto") const {
    return FakenectSource(folder_.path(), {.camera = "", .depth = depth});
  }
  std::string fault() const {
    return error_of([&] { open().read(0); });
  }

  testing::TemporaryFolder folder_;
};

TEST_F(Fakenect, GivesDepthTimesAndTheKinectsCamera) {
  write({pgm_of(raw_wall()), pgm_of(raw_wall(7))});
  const FakenectSource source = open();
  ASSERT_EQ(source.size(), 2);
  const Frame frame = source.read(1);
  EXPECT_EQ(frame.camera, kinect_camera());
  EXPECT_EQ(frame.name, "d-1300000000.033333-8000000");
  EXPECT_DOUBLE_EQ(*source.read(0).time_s, 0.1);
  EXPECT_NEAR(*frame.time_s, 0.1 + 1.0 / 30, 1e-9);
  EXPECT_EQ(frame.depth_mm(635, 0), 0.0f);
  const double raw = 400 + 7 + 100 / 2 + 40 / 4;
  EXPECT_NEAR(frame.depth_mm(100, 40), 123.6 * std::tan(raw / 2842.5 + 1.1863), 1e-3);
  testing::expect_labels_like_frames(source);
}

TEST_F(Fakenect, ReadsBothOrdersOfBytes) {
  write({pgm_of(raw_wall())});
  const Image<float> little = open().read(0).depth_mm;
  write({pgm_of(raw_wall(), std::endian::big)});
  EXPECT_EQ(open().read(0).depth_mm, little);
}

TEST_F(Fakenect, KnowsMillimetresFromRawValues) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    write({pgm_of(near_wall_mm(), order)});
    EXPECT_EQ(open().read(0).depth_mm(10, 8), 400 + 300 + 5 + 2);
  }
  Image<std::uint16_t> far = raw_wall(3000);  // no hole, but more than 11 bits
  for (std::uint16_t& value : far.pixels()) value = value == 2047 ? 3000 : value;
  write({pgm_of(far)});
  EXPECT_EQ(open().read(0).depth_mm(10, 8), 3407);
}

TEST_F(Fakenect, TheUnitCanBeSaid) {
  write({pgm_of(near_wall_mm())});
  EXPECT_EQ(open("mm").read(0).depth_mm(10, 8), 707);
  EXPECT_EQ(open("raw").read(0).depth_mm(10, 8), depth_of_kinect_raw(707));
  EXPECT_THAT(error_of([&] { open_dataset("fakenect:" + folder_.path().string() + "?depth=cm"); }),
              HasSubstr("'cm'"));
}

TEST_F(Fakenect, AnImageWithoutMeasurementsDoesNotChooseTheFormat) {
  write({pgm_of(Image<std::uint16_t>(kWidth, kHeight)), "damaged", pgm_of(raw_wall())});
  EXPECT_EQ(open().read(2).depth_mm(10, 8), depth_of_kinect_raw(407));
  write({pgm_of(Image<std::uint16_t>(kWidth, kHeight))});
  EXPECT_EQ(open().read(0).depth_mm(0, 0), 0.0f);
}

TEST_F(Fakenect, TakesAnotherCamera) {
  const Image<std::uint16_t> small(8, 6, 900);
  write({pgm_of(small)});
  EXPECT_THAT(fault(), HasSubstr("is 8x6 pixels, expected 640x480"));
  put_file(folder_ / "camera.toml", "[camera]\nwidth=8\nheight=6\nfx=7\nfy=7\ncx=4\ncy=3\n");
  const auto source = open_dataset(
      fmt::format("fakenect:{}?camera={}", folder_.path().string(), (folder_ / "camera.toml").string()));
  EXPECT_EQ(source->read(0).camera.fx, 7);
  EXPECT_EQ(source->read(0).depth_mm(0, 0), depth_of_kinect_raw(900));
  EXPECT_THAT(error_of([&] { open_dataset("fakenect:" + folder_.path().string() + "?camera=no.toml"); }),
              HasSubstr("no.toml"));
}

TEST_F(Fakenect, ReadsDumpsWithoutAHeader) {
  put_file(folder_ / "INDEX.txt", "d-1.5-60000000-614400.dump\r\n");
  put_file(folder_ / "d-1.5-60000000-614400.dump", bytes_of(raw_wall(), std::endian::little));
  EXPECT_EQ(open().read(0).depth_mm(10, 8), depth_of_kinect_raw(407));
  EXPECT_EQ(open().read(0).time_s, 1.0);
  put_file(folder_ / "d-1.5-60000000-614400.dump", "short");
  EXPECT_THAT(fault(), HasSubstr("holds 5 bytes of depth, expected 614400"));
}

TEST_F(Fakenect, OneDamagedImageIsAFaultOfItsFrame) {
  write({pgm_of(raw_wall()), "P5 640 480 65535\nshort", pgm_of(raw_wall())});
  const FakenectSource source = open();
  EXPECT_THAT(error_of([&] { source.read(1); }), HasSubstr("d-1300000000.033333-8000000.pgm: holds 5 bytes"));
  EXPECT_NO_THROW(source.read(2));
  std::filesystem::remove(folder_ / "d-1300000000.066667-10000000.pgm");
  EXPECT_THAT(error_of([&] { source.read(2); }), HasSubstr("d-1300000000.066667-10000000.pgm"));
}

TEST_F(Fakenect, RefusesWhatIsNoKinectsDepth) {
  Image<std::uint16_t> noise(kWidth, kHeight);
  Random random(3);
  for (std::uint16_t& value : noise.pixels()) value = static_cast<std::uint16_t>(random.below(65536));
  write({pgm_of(noise)});
  EXPECT_THAT(fault(), HasSubstr("above 10000 in either order of bytes"));
  write({pgm_of(raw_wall()), pgm_of(raw_wall(1648))});
  const FakenectSource source = open();
  EXPECT_THAT(error_of([&] { source.read(1); }), HasSubstr("raw depth 2048, expected at most 2047"));
}

TEST_F(Fakenect, RefusesAnIndexThatIsNone) {
  EXPECT_THAT(fault(), HasSubstr("INDEX.txt"));
  put_file(folder_ / "INDEX.txt", "");
  EXPECT_THAT(fault(), HasSubstr("lists no depth image"));
  put_file(folder_ / "INDEX.txt", "r-1.0-5.ppm\n");
  EXPECT_THAT(fault(), HasSubstr("lists no depth image"));
}

TEST_F(Fakenect, AMissingFifoOrFolderIsNamed) {
  put_file(folder_ / "INDEX.txt", "d-1.0-5.pgm\n");
  EXPECT_THAT(fault(), HasSubstr("d-1.0-5.pgm"));
  std::filesystem::create_directory(folder_ / "d-1.0-5.pgm");
  EXPECT_THAT(fault(), HasSubstr("expected a file, found a folder"));
}

std::string index_fault(const std::string& line) {
  return error_of([&] { parse_fakenect_index("r-1.0-5.ppm\n" + line, "INDEX.txt"); });
}

TEST(FakenectIndex, NamesFileLineAndFault) {
  EXPECT_THAT(index_fault("d-1.0-5/../../x.pgm"), HasSubstr("INDEX.txt:2: 'd-1.0-5/../../x.pgm' is not in"));
  EXPECT_THAT(index_fault(std::string("d-1.0-5\0.pgm", 12)), HasSubstr("INDEX.txt:2"));
  EXPECT_THAT(index_fault("hello"), HasSubstr("INDEX.txt:2: 'hello' is not TYPE-TIME-TICKS"));
  EXPECT_THAT(index_fault("d-1.0"), HasSubstr("is not TYPE-TIME-TICKS"));
  EXPECT_THAT(index_fault("d--1.0-5.pgm"), HasSubstr("INDEX.txt:2"));
  EXPECT_THAT(index_fault("d-nan-5.pgm"), HasSubstr("not a time in seconds"));
  EXPECT_THAT(index_fault("d-1e300-5.pgm"), HasSubstr("not a time in seconds"));
  EXPECT_THAT(index_fault("d-1.0-4294967296.pgm"), HasSubstr("more than 32 bits"));
  EXPECT_THAT(index_fault("d-1.0-99999999999999999999999.pgm"), HasSubstr("INDEX.txt:2"));
  EXPECT_THAT(index_fault("d-1.0-.pgm"), HasSubstr("INDEX.txt:2"));
  EXPECT_THAT(index_fault("d-1.0-5x.pgm"), HasSubstr("'5x.pgm' is not a number of ticks"));
}

/// Lines of depth images at these times of the Kinect, whose clock turns, and of the computer [s].
std::vector<FakenectImage> images_at(const std::vector<std::pair<double, double>>& times) {
  std::string index;
  for (const auto& [kinect_s, host_s] : times) {
    const auto ticks = static_cast<std::uint64_t>(std::llround(kinect_s * 60e6)) % (std::uint64_t{1} << 32);
    index += fmt::format("d-{:.6f}-{}.pgm\n", 1e9 + host_s, ticks);
  }
  return parse_fakenect_index(index, "INDEX.txt");
}

TEST(FakenectIndex, CountsTheTurnsOfTheClock) {
  std::vector<std::pair<double, double>> times;
  for (int i = 0; i < 9000; ++i) times.emplace_back(70 + i / 30.0, i / 30.0 + (i % 7) * 0.01);
  const std::vector<FakenectImage> images = images_at(times);
  for (std::size_t i = 0; i < images.size(); ++i) {
    ASSERT_NEAR(images[i].time_s, times[i].first, 1e-7) << i;
    ASSERT_EQ(images[i].sequence, 0);
  }
}

TEST(FakenectIndex, BridgesGapsOfManyTurns) {
  const std::vector<FakenectImage> images = images_at({{1, 0}, {2, 1}, {5002, 5001.3}});
  EXPECT_NEAR(images[2].time_s, 5002, 1e-6);
}

TEST(FakenectIndex, AClockThatGoesBackBeginsASequence) {
  const std::vector<FakenectImage> images = images_at({{10, 0}, {11, 1}, {2, 2}, {3, 3}});
  EXPECT_EQ(images[1].sequence, 0);
  EXPECT_EQ(images[2].sequence, 1);
  EXPECT_EQ(images[3].sequence, 1);
  EXPECT_NEAR(images[3].time_s - images[2].time_s, 1.0, 1e-9);
}

TEST(KinectDepth, OfRawValuesIsMonotonousUpToTenMetres) {
  EXPECT_NEAR(depth_of_kinect_raw(0), 123.6 * std::tan(1.1863), 1e-3);
  float last = 0.0f;
  int raw = 0;
  for (; depth_of_kinect_raw(static_cast<std::uint16_t>(raw)) > 0.0f; ++raw) {
    ASSERT_GT(depth_of_kinect_raw(static_cast<std::uint16_t>(raw)), last);
    last = depth_of_kinect_raw(static_cast<std::uint16_t>(raw));
  }
  EXPECT_GT(last, 8000.0f);
  EXPECT_LE(last, 10000.0f);
  for (; raw < 65536; ++raw) ASSERT_EQ(depth_of_kinect_raw(static_cast<std::uint16_t>(raw)), 0.0f) << raw;
}

TEST(PgmImage, ReadsHeadersOfAllWriters) {
  const Image<std::uint16_t> image(2, 1, 0x0102);
  const std::string pixels = bytes_of(image, std::endian::little);
  for (const char* header : {"P5 2 1 65535\n", "P5\n2 1\n65535\n", "P5\n# a comment\n2\t1 # size\n2047 "})
    EXPECT_EQ(decode_pgm16(header + pixels, "a.pgm"), image) << header;
}

TEST(PgmImage, NamesTheFault) {
  const auto fault = [](std::string_view bytes) { return error_of([&] { decode_pgm16(bytes, "a.pgm"); }); };
  EXPECT_THAT(fault(""), HasSubstr("a.pgm: not a binary PGM"));
  EXPECT_THAT(fault("P6 2 1 65535\nabcd"), HasSubstr("not a binary PGM"));
  EXPECT_THAT(fault("P5"), HasSubstr("no width"));
  EXPECT_THAT(fault("P5 # comment"), HasSubstr("no width"));
  EXPECT_THAT(fault("P5 0 1 65535\n"), HasSubstr("no width"));
  EXPECT_THAT(fault("P5 -2 1 65535\n"), HasSubstr("no width"));
  EXPECT_THAT(fault("P5 99999999999999999999 1 65535\n"), HasSubstr("width is above 16384"));
  EXPECT_THAT(fault("P5 1 16385 65535\n"), HasSubstr("height is above 16384"));
  EXPECT_THAT(fault("P5 16384 2048 65535\nabcd"), HasSubstr("holds 4 bytes of depth, expected 67108864"));
  EXPECT_THAT(fault("P5 16384 2930 65535\nabcd"),
              HasSubstr("16384 x 2930 pixels, expected at most 48000000"));
  EXPECT_THAT(fault("P5 2 1 255\nab"), HasSubstr("8 bits per pixel"));
  EXPECT_THAT(fault("P5 2 1 65535"), HasSubstr("cut short"));
  EXPECT_THAT(fault("P5 2 1 65535\nabcde"), HasSubstr("holds 5 bytes"));
}

/// Errors are all that damaged bytes may cause.
void expect_answer_or_error(const std::function<void()>& read) {
  try {
    read();
  } catch (const Error& error) {
    EXPECT_STRNE(error.what(), "");
  }
}

/// `whole` with 1 to 4 bytes changed.
std::string damaged(const std::string& whole, Random& random) {
  std::string bytes = whole;
  for (std::uint32_t changes = 1 + random.below(4); changes > 0; --changes)
    bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] = static_cast<char>(random.below(256));
  return bytes;
}

TEST(FakenectDamage, EveryCutAndChangeOfTheIndexIsReadOrRefused) {
  const std::string whole =
      "d-1300000000.033333-8000000.pgm\nr-1300000000.033333-8000000.ppm\n"
      "d-1300000000.066667-10000000.pgm\na-1300000000.07-10000000.dump\n";
  const auto parse = [](const std::string& text) {
    expect_answer_or_error([&] { (void)parse_fakenect_index(text, "INDEX.txt"); });
  };
  for (std::size_t cut = 0; cut < whole.size(); ++cut) parse(whole.substr(0, cut));
  Random random(11);
  for (int i = 0; i < 5000; ++i) parse(damaged(whole, random));
}

TEST(FakenectDamage, EveryCutOfAnImageIsRefused) {
  const testing::TemporaryFolder folder;
  put_file(folder / "INDEX.txt", "d-1.0-5.pgm\n");
  put_file(folder / "camera.toml", "[camera]\nwidth=8\nheight=6\nfx=7\nfy=7\ncx=4\ncy=3\n");
  const std::string whole = pgm_of(Image<std::uint16_t>(8, 6, 900));
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    put_file(folder / "d-1.0-5.pgm", whole.substr(0, cut));
    EXPECT_THAT(error_of([&] {
                  FakenectSource(folder.path(),
                                 {.camera = (folder / "camera.toml").string(), .depth = "auto"});
                }),
                HasSubstr("d-1.0-5.pgm"))
        << cut;
  }
}

TEST(FakenectDamage, EveryChangeOfAnImageIsReadOrRefused) {
  const std::string whole = pgm_of(Image<std::uint16_t>(8, 6, 900));
  Random random(12);
  for (int i = 0; i < 5000; ++i) {
    expect_answer_or_error([&] {
      const Image<std::uint16_t> stored = decode_pgm16(damaged(whole, random), "a.pgm");
      (void)kinect_depth_mm(stored, kinect_format_of(stored, "", "a.pgm"), "a.pgm");
    });
  }
}

/// libfreenect's own recorder, with a Kinect that its own player makes of a folder of ours.
TEST_F(Fakenect, ReadsWhatFakenectRecordWrites) {
  const char* const library = "/usr/lib/x86_64-linux-gnu/fakenect";
  if (!std::filesystem::exists(library) || !std::filesystem::exists("/usr/bin/fakenect-record"))
    GTEST_SKIP() << "fakenect-record (Debian: libfreenect-bin) is not on this machine";
  const std::string colour = "P6 640 480 255\n" + std::string(std::size_t{3} * kWidth * kHeight, 'c');
  write({pgm_of(raw_wall()), pgm_of(raw_wall(3)), pgm_of(raw_wall(5)), pgm_of(raw_wall(9))}, 4288967296u);
  for (int i = 0; i < 4; ++i) {
    const std::uint32_t ticks = 4288967296u + 2000000u * static_cast<std::uint32_t>(i);
    put_file(folder_ / fmt::format("r-{:.6f}-{}.ppm", 1300000000.0 + i / 30.0, ticks), colour);
    put_file(folder_ / fmt::format("a-{:.6f}-{}.dump", 1300000000.0 + i / 30.0, ticks), std::string(24, 0));
  }
  const std::string out = (folder_ / "recorded").string();
  const std::string command = fmt::format(
      "cd / && FAKENECT_PATH='{}' LD_LIBRARY_PATH={} timeout -s INT 20 fakenect-record '{}' "
      "> /dev/null 2>&1",
      folder_.path().string(), library, out);
  (void)std::system(command.c_str());  // its status says nothing
  const FakenectSource played = open();
  const FakenectSource recorded(out);
  ASSERT_GE(recorded.size(), 3);  // the player may end before the last one
  for (std::int64_t i = 0; i < recorded.size(); ++i) {
    EXPECT_EQ(recorded.read(i).depth_mm, played.read(i).depth_mm) << i;
    EXPECT_EQ(recorded.read(i).time_s, played.read(i).time_s) << i;
  }
}

TEST(FakenectIndex, OfBlankLinesTakesNoMemory) {
  const std::string lines(20'000'000, '\n');
  const long before = peak_memory_kb();
  EXPECT_THAT(error_of([&] { parse_fakenect_index(lines, "INDEX.txt"); }), HasSubstr("lists no depth image"));
  EXPECT_LT(peak_memory_kb() - before, 100'000);
}

}  // namespace
}  // namespace knuckle
