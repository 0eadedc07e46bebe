// SPDX-License-Identifier: Apache-2.0
// Sets that were damaged after they were written.
#include <array>
#include <fstream>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/h5_source.h"
#include "knuckle/data/writers/h5_writer.h"
#include "knuckle/storage/hdf5/hdf5_file.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::put_file;

constexpr std::int64_t kFrames = 3;

/// Of as few pixels as tell images apart; with a hand more than the frame before has.
Frame tiny_frame(std::int64_t index) {
  const Camera camera{CameraModel::projective, 4, 3, 30.5, 31.25, 1.7, 1.4, {}};
  Frame frame = testing::noise_frame(camera, superset_convention(), static_cast<std::uint64_t>(index));
  frame.side = index == 1 ? HandSide::left : HandSide::right;
  frame.time_s = 0.04 * static_cast<double>(index);
  frame.sequence = static_cast<int>(index / 2);
  frame.labels = Image<std::uint8_t>(camera.width, camera.height, 2);
  for (std::int64_t i = 0; i < index; ++i) {
    HandTruth hand;
    hand.side = HandSide::left;
    hand.pose = *frame.truth;
    hand.occluders.assign(kSupersetSize, Occluder{});
    hand.visible_share = 0.25 * static_cast<double>(index);
    frame.hands.push_back(hand);
  }
  return frame;
}

void write_tiny_set(const fs::path& path) {
  FrameWriterOptions options{.first = 40, .count = kFrames, .manifest = "a = 1", .generator = "test 1"};
  options.part_of = IndexRange{30, 20};
  H5Writer writer(path, options);
  for (std::int64_t i = 0; i < kFrames; ++i) writer.write(40 + i, tiny_frame(i));
  writer.finish();
}

/// All that a set says, as text.
std::string content_of(const fs::path& path) {
  const H5Source source(path);
  const H5Facts facts = source.facts();
  const IndexRange whole = facts.part_of.value_or(IndexRange{});
  std::string content =
      fmt::format("{} {} {} {} {} {} {}", facts.frames.first, facts.frames.count, whole.first, whole.count,
                  facts.manifest, facts.generator, facts.depth_unit_mm);
  const auto add = [&](const auto& values) {
    for (const auto value : values) content += fmt::format(" {}", value);
  };
  for (std::int64_t i = 0; i < source.size(); ++i) {
    const StoredFrame frame = source.read_stored(i);
    const Camera& camera = frame.camera;
    add(std::array{camera.fx, camera.fy, camera.cx, camera.cy, frame.time_s,
                   static_cast<double>(camera.model)});
    add(camera.distortion);
    add(std::array{int{frame.side}, int{frame.sequence}, camera.width, camera.height});
    add(frame.joints_mm);
    for (const auto* image : {&frame.depth, &frame.infrared, &frame.mask, &frame.labels}) add(*image);
    for (const StoredHand& hand : frame.hands) {
      add(std::array{double{hand.visible_share}, static_cast<double>(hand.side)});
      add(hand.occluders);
      add(hand.joints_mm);
    }
  }
  return content;
}

/// Whatever byte of the file is another: it is noticed, or nothing that is read is another.
TEST(H5Damage, EachChangedByteIsNoticed) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  write_tiny_set(path);
  const std::string expected = content_of(path);
  const std::string whole = read_text_file(path);
  std::size_t noticed = 0;
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  const auto put = [&](std::size_t place, int byte) {
    file.seekp(static_cast<std::streamoff>(place)).put(static_cast<char>(byte)).flush();
  };
  for (std::size_t place = 0; place < whole.size(); ++place) {
    put(place, whole[place] ^ (1 << place % 8));
    try {
      ASSERT_EQ(content_of(path), expected) << "byte " << place << " of " << whole.size();
    } catch (const Error& error) {
      ASSERT_THAT(error.what(), HasSubstr("a.h5"));
      ++noticed;
    }
    put(place, whole[place]);
  }
  EXPECT_GT(noticed, whole.size() / 6);  // libhdf5 leaves much room
}

/// A value of each array that is not deflated, by its name: as great as the one before, and possible.
TEST(H5Damage, AChangedNumberIsNoticedWhereItIsRead) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  const auto fault_after = [&](const std::function<void(Hdf5Writer&)>& change, std::int64_t frame) {
    write_tiny_set(path);
    Hdf5Writer file = Hdf5Writer::open(path);
    change(file);
    file.close();
    const H5Source source(path);
    for (std::int64_t i = 0; i < kFrames; ++i) {
      if (i == frame) continue;
      source.read(i);
      source.read_label(i);
    }
    const std::string fault = error_of([&] { source.read(frame); });
    EXPECT_EQ(error_of([&] { source.read_stored(frame); }), fault);
    EXPECT_EQ(error_of([&] { source.read_label(frame); }), fault);
    return fault;
  };
  const auto expected = [](int frame) {
    return HasSubstr(fmt::format("a.h5: frame {}: its numbers are not those that were written", frame));
  };
  const auto change = [](std::string_view array, std::uint64_t row, const auto& values) {
    return [=](Hdf5Writer& file) { file.write_rows(array, row, 1, values.data()); };
  };
  EXPECT_THAT(fault_after(change("intrinsics", 1, std::array{30.5, 31.25, 1.7, 1.5}), 1), expected(1));
  EXPECT_THAT(fault_after(change("side", 1, std::array{std::int8_t{0}}), 1), expected(1));
  EXPECT_THAT(fault_after(change("time_s", 1, std::array{0.05}), 1), expected(1));
  EXPECT_THAT(fault_after(change("sequence", 2, std::array{std::int32_t{2}}), 2), expected(2));
  EXPECT_THAT(fault_after(change("joints_mm", 0, std::array<float, 66>{}), 0), expected(0));
  EXPECT_THAT(fault_after(change("hands_side", 0, std::array{std::int8_t{0}}), 1), expected(1));
  EXPECT_THAT(fault_after(change("hands_joints_mm", 1, std::array<float, 66>{}), 2), expected(2));
  EXPECT_THAT(fault_after(change("hands_occluders", 2, std::array<std::uint8_t, 22>{1}), 2), expected(2));
  EXPECT_THAT(fault_after(change("hands_visible_share", 2, std::array{0.75}), 2), expected(2));
  EXPECT_THAT(fault_after(change("frame_sums", 1, std::array<std::uint64_t, 2>{}), 1), expected(1));
}

/// A chunk that the file's index no longer leads to is read as zeros, a mask that has lost its name as none.
TEST(H5Damage, ImagesThatAreGoneAreNoticed) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  for (const std::string_view image : {"depth", "infrared", "mask", "labels"}) {
    write_tiny_set(path);
    Hdf5Writer file = Hdf5Writer::open(path);
    constexpr std::array<std::uint8_t, 12> kZeros{};
    constexpr std::array<std::uint16_t, 12> kWideZeros{};
    if (image == "depth" || image == "infrared") {
      file.write_rows(image, 1, 1, kWideZeros.data());
    } else {
      file.write_rows(image, 1, 1, kZeros.data());
    }
    file.close();
    const H5Source source(path);
    source.read_label(1);
    EXPECT_THAT(error_of([&] { source.read(1); }), HasSubstr("frame 1: its images are not those"));
  }
  write_tiny_set(path);
  std::string bytes = read_text_file(path);
  const std::size_t name = bytes.find(std::string("mask\0", 5));
  ASSERT_NE(name, std::string::npos);
  bytes[name] = 'n';
  put_file(path, bytes);
  EXPECT_THAT(error_of([&] { H5Source(path).read(0); }), HasSubstr("a.h5"));
}

/// What all frames share is in the sum of each.
TEST(H5Damage, AnotherAttributeIsNoticed) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  const auto fault_after = [&](const std::function<void(Hdf5Writer&)>& change) {
    write_tiny_set(path);
    Hdf5Writer file = Hdf5Writer::open(path);
    change(file);
    file.close();
    return error_of([&] { H5Source(path).read(0); });
  };
  const auto expected = HasSubstr("frame 0: its numbers are not those");
  EXPECT_THAT(fault_after([](Hdf5Writer& file) { file.set_attribute("manifest", "a = 2"); }), expected);
  EXPECT_THAT(fault_after([](Hdf5Writer& file) { file.set_attribute("generator", "test 2"); }), expected);
  EXPECT_THAT(fault_after([](Hdf5Writer& file) { file.set_attribute("first_index", 41); }), expected);
  EXPECT_THAT(fault_after([](Hdf5Writer& file) { file.set_attribute("part_of_first", 31); }), expected);
  EXPECT_THAT(fault_after([](Hdf5Writer& file) { file.set_attribute("part_of_count", 21); }), expected);
  EXPECT_THAT(fault_after([](Hdf5Writer& file) { file.set_attribute("depth_unit_mm", 0.2); }), expected);
  EXPECT_THAT(fault_after([](Hdf5Writer& file) {
                file.set_attribute("distortion", std::vector<double>{0.1, 0, 0, 0, 0, 0, 0, 0});
              }),
              expected);
  EXPECT_THAT(fault_after([](Hdf5Writer& file) { file.set_attribute("camera_model", "orthographic"); }),
              expected);
}

TEST(H5Damage, ASetOfAnOlderVersionIsReadWithoutSums) {
  const testing::TemporaryFolder folder;
  fs::copy_file(testing::project_folder() / "fuzz/corpus/h5_set/small", folder / "old.h5");
  ASSERT_EQ(Hdf5File::open(folder / "old.h5").number_attribute("version"), 2);
  check_h5(folder / "old.h5");
  EXPECT_EQ(H5Source(folder / "old.h5").facts().generator, "");
}

TEST(H5Damage, ANewSetWithoutItsSumsIsRefused) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  fs::copy_file(testing::project_folder() / "fuzz/corpus/h5_set/small", path);
  Hdf5Writer file = Hdf5Writer::open(path);
  file.set_attribute("version", 3);
  file.close();
  EXPECT_THAT(error_of([&] { H5Source source(path); }), HasSubstr("a.h5: frame_sums: the array is missing"));
}

}  // namespace
}  // namespace knuckle
