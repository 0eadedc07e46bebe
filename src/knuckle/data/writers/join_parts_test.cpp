// SPDX-License-Identifier: Apache-2.0
// Parts of a set, joined or read as one.
#include "knuckle/data/writers/join_parts.h"

#include <array>
#include <functional>
#include <optional>

#include "knuckle/core/parallel.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/h5_parts.h"
#include "knuckle/data/readers/open_dataset.h"
#include "knuckle/data/writers/h5_writer.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::noise_frame;
using ::testing::Not;
using testing::put_file;

constexpr IndexRange kWhole{40, 23};

/// Unlike its neighbours in all that a set holds: side, time, sequence, labels, number of hands, camera.
Frame frame_of(std::int64_t index) {
  Frame frame =
      noise_frame(testing::small_camera(), superset_convention(), static_cast<std::uint64_t>(index));
  frame.camera.fx += 0.25 * static_cast<double>(index);
  if (index % 3 != 0) frame.side = index % 3 == 1 ? HandSide::left : HandSide::right;
  frame.time_s = 0.04 * static_cast<double>(index % 10);
  frame.sequence = static_cast<int>(index / 10);
  frame.labels = Image<std::uint8_t>(frame.camera.width, frame.camera.height);
  Random random(9, static_cast<std::uint64_t>(index));
  for (std::uint8_t& label : frame.labels.pixels()) label = static_cast<std::uint8_t>(random.below(5));
  for (std::int64_t i = 0; i < index % 3; ++i) {
    HandTruth hand;
    hand.side = i == 0 ? HandSide::left : HandSide::right;
    hand.pose = *frame.truth;
    for (int joint = 0; joint < kSupersetSize; ++joint)
      hand.occluders.push_back(static_cast<Occluder>(random.below(6)));
    hand.visible_share = random.uniform();
    frame.hands.push_back(hand);
  }
  return frame;
}

/// How a part was made.
struct Making {
  std::string manifest = "a = 1";
  std::string generator = "test 1";
  double depth_unit_mm = 0.1;
  std::function<void(Frame&)> change = [](Frame&) {};
};

class JoinParts : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const IndexRange& frames, const std::optional<IndexRange>& part_of,
                 const Making& making = {}) const {
    FrameWriterOptions options;
    options.first = frames.first;
    options.count = frames.count;
    options.manifest = making.manifest;
    options.generator = making.generator;
    options.depth_unit_mm = making.depth_unit_mm;
    options.part_of = part_of;
    H5Writer writer(folder_ / name, options);
    parallel_for(frames.count, [&](std::int64_t i) {
      Frame frame = frame_of(frames.first + i);
      making.change(frame);
      writer.write(frames.first + i, frame);
    });
    writer.finish();
    return folder_ / name;
  }
  std::vector<fs::path> write_parts(std::int64_t count) const {
    std::vector<fs::path> parts;
    for (std::int64_t i = 0; i < count; ++i)
      parts.push_back(write(fmt::format("part{}.h5", i), part_of(kWhole, {i, count}), kWhole));
    return parts;
  }
  std::string fault(const std::vector<fs::path>& parts) const {
    const std::string fault = error_of([&] { join_parts(parts, folder_ / "out.h5"); });
    EXPECT_FALSE(fs::exists(folder_ / "out.h5"));
    EXPECT_FALSE(fs::exists(folder_ / "out.h5.assembled"));
    return fault;
  }

  testing::TemporaryFolder folder_;
};

TEST_F(JoinParts, HasTheBytesOfASetMadeInOnePiece) {
  const std::string whole = read_text_file(write("whole.h5", kWhole, std::nullopt));
  for (const std::int64_t count : {1, 2, 7, 23}) {
    std::vector<fs::path> parts = write_parts(count);
    std::ranges::reverse(parts);
    const fs::path out = folder_ / fmt::format("joined{}.h5", count);
    EXPECT_EQ(join_parts(parts, out), kWhole);
    EXPECT_TRUE(read_text_file(out) == whole) << count;
    for (const fs::path& part : parts) fs::remove(part);
  }
}

TEST_F(JoinParts, AreReadAsOneSourceWithoutJoining) {
  write("whole.h5", kWhole, std::nullopt);
  fs::create_directory(folder_ / "parts");
  for (const fs::path& part : write_parts(5)) fs::rename(part, folder_ / "parts" / part.filename());
  const auto whole = open_dataset("h5:" + (folder_ / "whole.h5").string());
  const auto parts = open_dataset("h5:" + (folder_ / "parts/*.h5").string());
  ASSERT_EQ(parts->size(), kWhole.count);
  EXPECT_EQ(parts->convention()->name, whole->convention()->name);
  parallel_for(kWhole.count, [&](std::int64_t i) {
    const Frame expected = whole->read(i);
    const Frame frame = parts->read(i);
    EXPECT_EQ(frame.name, expected.name);
    EXPECT_EQ(frame.depth_mm, expected.depth_mm);
    EXPECT_EQ(frame.labels, expected.labels);
    EXPECT_EQ(frame.hands.size(), expected.hands.size());
    EXPECT_EQ(frame.camera, expected.camera);
    EXPECT_EQ(frame.sequence, expected.sequence);
    EXPECT_EQ(parts->read_label(i).name, expected.name);
  });
  EXPECT_THAT(error_of([&] { parts->read(kWhole.count); }), HasSubstr("have 23 frames"));
  EXPECT_EQ(open_dataset("h5:" + (folder_ / "parts/*.h5?first=3&count=2").string())->read(1).name,
            "00000044");
  EXPECT_THAT(error_of([&] { open_dataset("h5:" + (folder_ / "none/*.h5").string()); }),
              HasSubstr("no file is named so"));
}

/// More parts than are kept open.
TEST_F(JoinParts, ManyPartsAreReadInAnyOrder) {
  constexpr std::int64_t kMany = 150;
  std::vector<fs::path> paths;
  for (std::int64_t i = 0; i < kMany; ++i)
    paths.push_back(write(fmt::format("{:03}.h5", i), {i, 1}, std::nullopt));
  const H5PartsSource source(paths);
  for (std::int64_t i = 0; i < 2 * kMany; ++i) {
    const std::int64_t index = i * 67 % kMany;
    ASSERT_EQ(source.read(index).name, fmt::format("{:08}", index));
  }
}

TEST_F(JoinParts, MissingFramesAreNamed) {
  std::vector<fs::path> parts = write_parts(4);  // 40 to 44, 45 to 50, 51 to 56, 57 to 62
  const auto without = [&](std::size_t part) {
    std::vector<fs::path> others = parts;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(part));
    return fault(others);
  };
  EXPECT_THAT(without(0), AllOf(HasSubstr("part1.h5"), HasSubstr("frames 40 to 44 are missing before it")));
  EXPECT_THAT(without(2), HasSubstr("frames 51 to 56 are missing before it"));
  EXPECT_THAT(without(3), AllOf(HasSubstr("part2.h5"), HasSubstr("frames 57 to 62 are missing after it")));
  EXPECT_THAT(fault({}), HasSubstr("no part"));
}

TEST_F(JoinParts, FramesThatAreThereTwiceAreNamed) {
  std::vector<fs::path> parts = write_parts(2);
  parts.push_back(parts[0]);
  EXPECT_THAT(fault(parts), HasSubstr("frames 40 to 50 are in"));
  EXPECT_THAT(fault({write("a.h5", {0, 4}, std::nullopt), write("b.h5", {3, 4}, std::nullopt)}),
              AllOf(HasSubstr("b.h5"), HasSubstr("frame 3 is in"), HasSubstr("a.h5")));
  EXPECT_THAT(fault({write("c.h5", {0, 8}, std::nullopt), write("d.h5", {2, 3}, std::nullopt),
                     write("e.h5", {8, 2}, std::nullopt)}),
              AllOf(HasSubstr("d.h5: frames 2 to 4 are in"), HasSubstr("c.h5"), Not(HasSubstr("missing"))));
}

TEST_F(JoinParts, PartsOfDifferentSetsAreRefused) {
  const fs::path first = write("first.h5", {0, 2}, IndexRange{0, 4});
  EXPECT_THAT(fault({first, write("b.h5", {2, 2}, IndexRange{0, 4}, {.manifest = "a = 2"})}),
              AllOf(HasSubstr("b.h5"), HasSubstr("another manifest"), HasSubstr("first.h5")));
  EXPECT_THAT(fault({first, write("c.h5", {2, 2}, IndexRange{0, 5})}), HasSubstr("part of another set"));
  EXPECT_THAT(fault({first, write("d.h5", {2, 2}, std::nullopt)}), HasSubstr("part of another set"));
  EXPECT_THAT(fault({first, write("e.h5", {2, 2}, IndexRange{0, 4}, {.depth_unit_mm = 0.25})}),
              HasSubstr("e.h5: has another unit of depth"));
  EXPECT_THAT(
      fault({first, write("f.h5", {2, 2}, IndexRange{0, 4}, {.generator = "test 2"})}),
      AllOf(HasSubstr("f.h5: was made by another program (test 2, not test 1)"), HasSubstr("first.h5")));
  EXPECT_THAT(fault({first, write("g.h5", {2, 2}, IndexRange{0, 4}, {.generator = ""})}),
              HasSubstr("g.h5: was made by another program (a program that does not say its version"));
}

TEST_F(JoinParts, PartsWithOtherImagesAreRefused) {
  const fs::path first = write("first.h5", {0, 2}, IndexRange{0, 4});
  const auto fault_where = [&](const std::function<void(Frame&)>& change) {
    const fs::path other = write("other.h5", {2, 2}, IndexRange{0, 4}, {.change = change});
    std::string said = fault({first, other});
    fs::remove(other);
    return said;
  };
  const auto of_size = [](int width, int height) {
    return [=](Frame& frame) {
      Camera camera = testing::small_camera();
      camera.width = width;
      camera.height = height;
      frame = noise_frame(camera, superset_convention(), 1);
    };
  };
  const std::array<std::function<void(Frame&)>, 4> cameras = {
      of_size(23, 18), of_size(24, 17),
      [](Frame& frame) { frame.camera.distortion = testing::distorted_camera().distortion; },
      [](Frame& frame) { frame.camera.model = CameraModel::orthographic; }};
  for (const auto& change : cameras)
    EXPECT_THAT(fault_where(change), HasSubstr("other.h5: has another size or kind of camera"));
  const std::array<std::function<void(Frame&)>, 4> images = {
      [](Frame& frame) { frame.infrared = {}; }, [](Frame& frame) { frame.mask = {}; },
      [](Frame& frame) { frame.labels = {}; }, [](Frame& frame) { frame.time_s.reset(); }};
  for (const auto& change : images)
    EXPECT_THAT(fault_where(change), HasSubstr("other.h5: has other kinds of images or times"));
}

TEST_F(JoinParts, BrokenAndUnfinishedPartsAreNamed) {
  const std::vector<fs::path> parts = write_parts(2);
  const std::string whole = read_text_file(parts[1]);
  put_file(parts[1], whole.substr(0, whole.size() / 2));
  EXPECT_THAT(fault(parts), HasSubstr("part1.h5"));
  fs::remove(parts[1]);
  EXPECT_THAT(fault(parts), HasSubstr("part1.h5"));
  FrameWriterOptions options;
  options.count = 2;
  const H5Writer unfinished(folder_ / "u.h5", options);
  EXPECT_THAT(fault({folder_ / "u.h5.partial"}), HasSubstr("is unfinished"));
}

/// Whatever byte of a part is changed: it is noticed while it is joined, and nothing is left of the joined
/// file, or the joined file has the bytes that it has without.
TEST_F(JoinParts, AChangedByteIsNoticed) {
  const std::vector<fs::path> parts = write_parts(2);
  join_parts(parts, folder_ / "out.h5");
  const std::string expected = read_text_file(folder_ / "out.h5");
  const std::string whole = read_text_file(parts[0]);
  int noticed = 0;
  constexpr int kChanges = 60;
  Random random(4);
  for (int i = 0; i < kChanges; ++i) {
    fs::remove(folder_ / "out.h5");
    std::string damaged = whole;
    const std::size_t place = random.below(static_cast<std::uint32_t>(whole.size()));
    damaged[place] = static_cast<char>(damaged[place] ^ 0x10);
    put_file(parts[0], damaged);
    try {
      join_parts(parts, folder_ / "out.h5");
      EXPECT_TRUE(read_text_file(folder_ / "out.h5") == expected) << "byte " << place;
    } catch (const Error& error) {
      ++noticed;
      EXPECT_THAT(error.what(), HasSubstr("part0.h5"));
      EXPECT_FALSE(fs::exists(folder_ / "out.h5"));
    }
  }
  EXPECT_GT(noticed, kChanges / 2);
}

TEST_F(JoinParts, AllFaultsAreNamedInOneLine) {
  std::vector<fs::path> parts = write_parts(7);  // 40 to 42, 43 to 45, ..., 59 to 62
  fs::remove(parts[1]);
  put_file(parts[3], "no set");
  write("part5.h5", {56, 3}, kWhole, {.manifest = "a = 2"});
  parts.push_back(parts[6]);
  const std::string line = fault(parts);
  for (const char* const expected :
       {"part1.h5: the file is missing; ", "part3.h5: ", "part5.h5: was made from another manifest than",
        "frames 43 to 45 are missing before it", "frames 49 to 52 are missing before it",
        "frames 56 to 58 are missing before it", "part6.h5: frames 59 to 62 are in"}) {
    EXPECT_THAT(line, HasSubstr(expected));
  }
  EXPECT_THAT(line, Not(HasSubstr("\n")));
  EXPECT_THAT(line, Not(HasSubstr("more")));
}

/// Of three parts the one that is unlike the others is foreign, wherever it stands.
TEST_F(JoinParts, WhatMostPartsAreIsTheSet) {
  std::vector<fs::path> parts{write("a.h5", {0, 2}, IndexRange{0, 6}, {.manifest = "a = 2"}),
                              write("b.h5", {2, 2}, IndexRange{0, 6}),
                              write("c.h5", {4, 2}, IndexRange{0, 6})};
  const std::string line = fault(parts);
  EXPECT_THAT(line, HasSubstr("a.h5: was made from another manifest than " + parts[1].string()));
  EXPECT_THAT(line, Not(HasSubstr("c.h5: was made")));
  EXPECT_THAT(line, HasSubstr("b.h5: frames 0 to 1 are missing before it"));
}

TEST_F(JoinParts, OfManyFaultsThereIsANumber) {
  std::vector<fs::path> parts;
  for (int i = 0; i < 31; ++i) parts.push_back(folder_ / fmt::format("none{}.h5", i));
  const std::string line = fault(parts);
  EXPECT_THAT(line, AllOf(HasSubstr("none0.h5"), HasSubstr("none19.h5"), Not(HasSubstr("none20.h5"))));
  EXPECT_THAT(line, ::testing::EndsWith("; ... and 11 more"));
}

/// Damage of images and numbers shows when frames are read: all parts are, not those up to the first.
TEST_F(JoinParts, AllDamagedPartsAreNamed) {
  const std::vector<fs::path> parts = write_parts(4);
  for (const std::size_t damaged : {1U, 3U}) {
    Hdf5Writer file = Hdf5Writer::open(parts[damaged]);
    const std::array<float, 66> joints{};
    file.write_rows("joints_mm", 2, 1, joints.data());
    file.close();
  }
  EXPECT_THAT(fault(parts), AllOf(HasSubstr("part1.h5: frame 2: its numbers"), HasSubstr("; "),
                                  HasSubstr("part3.h5: frame 2: its numbers"), Not(HasSubstr("part0.h5"))));
}

TEST_F(JoinParts, NothingIsOverwritten) {
  const std::vector<fs::path> parts = write_parts(2);
  put_file(folder_ / "there.h5", "mine");
  EXPECT_THAT(error_of([&] { join_parts(parts, folder_ / "there.h5"); }), HasSubstr("exists already"));
  EXPECT_EQ(read_text_file(folder_ / "there.h5"), "mine");
  EXPECT_THAT(error_of([&] { join_parts(parts, folder_ / "no/such/out.h5"); }), HasSubstr("out.h5"));
}

TEST_F(JoinParts, APartLiesInWhatItIsAPartOf) {
  for (const IndexRange& whole : {IndexRange{3, 5}, IndexRange{0, 3}}) {
    fs::remove(folder_ / "a.h5");
    const fs::path part = write("a.h5", {2, 2}, whole);
    EXPECT_THAT(error_of([&] { H5PartsSource source({part}); }),
                HasSubstr(fmt::format("a.h5: holds frames 2 to 3, but calls itself a part of {} to {}",
                                      whole.first, whole.end() - 1)));
  }
}

TEST_F(JoinParts, PartsThatChangeWhileTheyAreReadAreRefused) {
  const std::vector<fs::path> paths{write("a.h5", {0, 2}, std::nullopt), write("b.h5", {2, 2}, std::nullopt)};
  const H5PartsSource source(paths);
  fs::remove(paths[1]);
  write("b.h5", {2, 3}, std::nullopt);
  EXPECT_THAT(error_of([&] { source.read(2); }), HasSubstr("b.h5: was changed while it was read"));
}

}  // namespace
}  // namespace knuckle
