// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <limits>
#include <memory>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/h5_format.h"
#include "knuckle/data/readers/h5_source.h"
#include "knuckle/data/writers/h5_writer.h"
#include "knuckle/storage/hdf5/hdf5_file.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::noise_frame;
using testing::put_file;
using testing::small_camera;

FrameWriterOptions options_for(std::int64_t first, std::int64_t count,
                               const std::string& manifest = "a = 1") {
  FrameWriterOptions options;
  options.first = first;
  options.count = count;
  options.manifest = manifest;
  return options;
}

Frame noisy_frame(std::int64_t index) {
  Frame frame = noise_frame(small_camera(), superset_convention(), static_cast<std::uint64_t>(index));
  if (index % 3 != 0) frame.side = index % 3 == 1 ? HandSide::left : HandSide::right;
  frame.time_s = 0.04 * static_cast<double>(index % 10);
  frame.sequence = static_cast<int>(index / 10);
  return frame;
}

void write_set(const fs::path& path, std::int64_t first, std::int64_t count) {
  H5Writer writer(path, options_for(first, count));
  parallel_for(count, [&](std::int64_t i) { writer.write(first + i, noisy_frame(first + i)); });
  writer.finish();
}

void expect_frames(const fs::path& path, std::int64_t first, std::int64_t count) {
  const H5Source source(path);
  ASSERT_EQ(source.size(), count);
  parallel_for(count, [&](std::int64_t i) {
    const Frame expected = noisy_frame(first + i);
    const Frame actual = source.read(i);
    EXPECT_EQ(actual.name, fmt::format("{:08}", first + i));
    EXPECT_EQ(actual.camera, expected.camera);
    EXPECT_EQ(actual.side, expected.side);
    EXPECT_EQ(actual.time_s, expected.time_s);
    EXPECT_EQ(actual.sequence, expected.sequence);
    testing::expect_near(actual.depth_mm, expected.depth_mm, 0.0501);
    EXPECT_EQ(actual.infrared, expected.infrared);
    EXPECT_EQ(actual.mask, expected.mask);
    testing::expect_near(*actual.truth, *expected.truth, 1e-4, 1e-4);
  });
}

std::string error_of_h5_set(const fs::path& path) {
  return error_of([&] { H5Source(path).read(0); });
}

TEST(H5, ReadsWhatWasWrittenFromManyThreads) {
  const testing::TemporaryFolder folder;
  write_set(folder / "a.h5", 40, 23);
  expect_frames(folder / "a.h5", 40, 23);
  EXPECT_FALSE(fs::exists(folder / "a.h5.partial"));
}

TEST(H5, StatesWhatOtherProgramsNeed) {
  const testing::TemporaryFolder folder;
  write_set(folder / "a.h5", 40, 2);
  const Hdf5File file = Hdf5File::open(folder / "a.h5");
  EXPECT_EQ(file.text_attribute("format"), "knuckle-dataset");
  EXPECT_EQ(file.number_attribute("version"), 3);
  EXPECT_EQ(file.number_attribute("depth_unit_mm"), 0.1);
  EXPECT_EQ(file.text_attribute("manifest"), "a = 1");
  EXPECT_EQ(file.number_attribute("fx"), small_camera().fx);
  EXPECT_THAT(file.text_attribute("landmarks"), HasSubstr("wrist, palm, thumb_cmc"));
  EXPECT_EQ(file.shape("depth"), (std::vector<std::uint64_t>{2, 18, 24}));
  EXPECT_EQ(file.shape("joints_mm"), (std::vector<std::uint64_t>{2, 22, 3}));
}

TEST(H5, SidesHaveTheCodesOfTheFormat) {
  const testing::TemporaryFolder folder;
  write_set(folder / "a.h5", 0, 6);  // not known, left, right, ...
  const Hdf5File file = Hdf5File::open(folder / "a.h5");
  EXPECT_EQ(file.read<std::int8_t>("side").values, (std::vector<std::int8_t>{-1, 1, 0, -1, 1, 0}));
}

TEST(H5, HoldsOrthographicCamerasAndOtherUnitsOfDepth) {
  const testing::TemporaryFolder folder;
  Frame frame = noisy_frame(0);
  frame.camera.model = CameraModel::orthographic;
  frame.depth_mm(3, 2) = 500.25f;
  FrameWriterOptions options = options_for(0, 1);
  options.depth_unit_mm = 0.25;
  H5Writer writer(folder / "a.h5", options);
  writer.write(0, frame);
  writer.finish();
  const Frame read = H5Source(folder / "a.h5").read(0);
  EXPECT_EQ(read.camera, frame.camera);
  EXPECT_EQ(read.depth_mm(3, 2), 500.25f);
  testing::expect_near(read.depth_mm, frame.depth_mm, 0.1251);
}

/// A frame of as many hands as its number, and labels.
Frame frame_of_hands(std::int64_t index) {
  Frame frame = noisy_frame(index);
  Random random(9, static_cast<std::uint64_t>(index));
  frame.labels = Image<std::uint8_t>(frame.camera.width, frame.camera.height);
  for (std::uint8_t& label : frame.labels.pixels()) label = static_cast<std::uint8_t>(random.below(5));
  for (std::int64_t i = 0; i < index; ++i) {
    HandTruth hand;
    hand.side = (i + index) % 2 == 0 ? HandSide::left : HandSide::right;
    hand.pose = *noisy_frame(100 + 10 * index + i).truth;
    if (i == 1) hand.pose.joints[4] = ImagePoint{};
    for (int joint = 0; joint < kSupersetSize; ++joint)
      hand.occluders.push_back(static_cast<Occluder>(random.below(6)));
    hand.visible_share = random.uniform();
    frame.hands.push_back(hand);
  }
  return frame;
}

void write_hands(const fs::path& path) {
  H5Writer writer(path, options_for(0, 4));
  for (const std::int64_t i : {0, 3, 1, 2}) writer.write(i, frame_of_hands(i));
  writer.finish();
}

TEST(H5, KeepsLabelsAndAllHandsOfAFrame) {
  const testing::TemporaryFolder folder;
  write_hands(folder / "a.h5");
  EXPECT_EQ(Hdf5File::open(folder / "a.h5").read<std::int64_t>("hands_end").values,
            (std::vector<std::int64_t>{0, 1, 3, 6}));
  const H5Source source(folder / "a.h5");
  for (std::int64_t i = 0; i < 4; ++i) {
    const Frame expected = frame_of_hands(i);
    const Frame actual = source.read(i);
    EXPECT_EQ(actual.labels, expected.labels);
    ASSERT_EQ(actual.hands.size(), expected.hands.size());
    for (std::size_t k = 0; k < actual.hands.size(); ++k) {
      EXPECT_EQ(actual.hands[k].side, expected.hands[k].side);
      EXPECT_EQ(actual.hands[k].occluders, expected.hands[k].occluders);
      EXPECT_EQ(actual.hands[k].visible_share, expected.hands[k].visible_share);
      EXPECT_EQ(actual.hands[k].pose.joints[4].is_missing(), k == 1);
      testing::expect_near(actual.hands[k].pose, expected.hands[k].pose, 1e-4, 1e-4);
    }
  }
}

TEST(H5, LabelsAndHandsThatCannotBeAreRefused) {
  const testing::TemporaryFolder folder;
  const auto fault_after = [&](const std::function<void(Hdf5Writer&)>& spoil) {
    write_hands(folder / "a.h5");
    Hdf5Writer file = Hdf5Writer::open(folder / "a.h5");
    spoil(file);
    file.close();
    return error_of([&] {
      const H5Source source(folder / "a.h5");
      for (std::int64_t i = 0; i < 4; ++i) source.read(i);
    });
  };
  const std::vector<std::uint8_t> nines(18 * 24, 9);
  EXPECT_THAT(fault_after([&](Hdf5Writer& file) { file.write_rows("labels", 2, 1, nines.data()); }),
              HasSubstr("a.h5: labels: frame 2: a pixel has the label 9, expected 0 to 4"));
  const std::int64_t less = 0;
  EXPECT_THAT(fault_after([&](Hdf5Writer& file) { file.write_rows("hands_end", 2, 1, &less); }),
              HasSubstr("hands_end: a frame has -1 hands"));
  const std::int64_t more = 7;
  EXPECT_THAT(fault_after([&](Hdf5Writer& file) { file.write_rows("hands_end", 3, 1, &more); }),
              HasSubstr("hands_side: has the shape 6, expected 7"));
  const std::int8_t unknown = -1;
  EXPECT_THAT(fault_after([&](Hdf5Writer& file) { file.write_rows("hands_side", 2, 1, &unknown); }),
              HasSubstr("frame 2: one of its hands has no side"));
  EXPECT_THAT(fault_after([&](Hdf5Writer& file) { file.write_rows("hands_occluders", 5, 1, nines.data()); }),
              HasSubstr("frame 3: hands_occluders: holds 9, expected 0 to 5"));
  const std::vector<float> far(std::size_t{kSupersetSize} * 3, -2e9f);
  EXPECT_THAT(fault_after([&](Hdf5Writer& file) { file.write_rows("hands_joints_mm", 0, 1, far.data()); }),
              HasSubstr("frame 1: hands_joints_mm: -2000000000 is out of range"));
  const double two = 2.0;
  EXPECT_THAT(fault_after([&](Hdf5Writer& file) { file.write_rows("hands_visible_share", 0, 1, &two); }),
              HasSubstr("frame 1: hands_visible_share: is 2"));
}

TEST(H5, KeepsWhatHasNoTimes) {
  const testing::TemporaryFolder folder;
  Frame frame = noisy_frame(0);
  frame.time_s.reset();
  H5Writer writer(folder / "a.h5", options_for(0, 2));
  writer.write(0, frame);
  EXPECT_THAT(error_of([&] { writer.write(1, noisy_frame(1)); }),
              HasSubstr("frame 1 has a time, the frames before have none"));
  writer.write(1, frame);
  writer.finish();
  EXPECT_EQ(H5Source(folder / "a.h5").read(1).time_s, std::nullopt);
  EXPECT_FALSE(Hdf5File::open(folder / "a.h5").has(kH5Time));
}

TEST(H5, RefusesToWriteATimeThatGoesBack) {
  const testing::TemporaryFolder folder;
  H5Writer writer(folder / "a.h5", options_for(0, 2));
  writer.write(0, noisy_frame(1));
  writer.write(1, noisy_frame(0));
  EXPECT_THAT(error_of([&] { writer.finish(); }), HasSubstr("a.h5: frame 1: the time goes back"));
  EXPECT_FALSE(fs::exists(folder / "a.h5"));
}

TEST(H5, RefusesToEndWithAFrameLeftOut) {
  const testing::TemporaryFolder folder;
  FrameWriterOptions options = options_for(0, 2);
  options.count = 0;  // nobody knows how many will come
  H5Writer writer(folder / "a.h5", options);
  writer.write(0, noisy_frame(0));
  writer.write(2, noisy_frame(2));
  EXPECT_THAT(error_of([&] { writer.finish(); }), HasSubstr("a.h5: frame 1 was not written"));
}

TEST(H5, AFileThatShrinksOrGrowsAfterOpeningIsAFaultOfEveryFrame) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  for (const double share : {0.3, 0.7, 0.99, 1.1}) {
    write_set(path, 0, 12);
    const H5Source source(path);
    const auto bytes = static_cast<double>(fs::file_size(path));
    fs::resize_file(path, static_cast<std::uintmax_t>(share * bytes));
    for (std::int64_t i = 0; i < 12; ++i) {
      EXPECT_THAT(error_of([&] { source.read(i); }), HasSubstr("a.h5")) << share << " of it, frame " << i;
      EXPECT_THAT(error_of([&] { source.read_label(i); }), HasSubstr("a.h5"))
          << share << " of it, frame " << i;
    }
  }
}

TEST(H5, AFileThatVanishesAfterOpeningIsReadToTheEnd) {
  const testing::TemporaryFolder folder;
  write_set(folder / "a.h5", 0, 3);
  const H5Source source(folder / "a.h5");
  fs::remove(folder / "a.h5");
  for (std::int64_t i = 0; i < 3; ++i) EXPECT_EQ(source.read(i).infrared, noisy_frame(i).infrared);
}

TEST(H5, HoldsALongManifest) {
  const testing::TemporaryFolder folder;
  const std::string manifest(300000, 'm');
  H5Writer writer(folder / "a.h5", options_for(0, 1, manifest));
  writer.write(0, noisy_frame(0));
  writer.finish();
  EXPECT_EQ(Hdf5File::open(folder / "a.h5").text_attribute("manifest"), manifest);
}

TEST(H5, KeepsEachFramesFocalLengthAndPrincipalPoint) {
  const testing::TemporaryFolder folder;
  H5Writer writer(folder / "a.h5", options_for(0, 3));
  std::vector<Frame> frames;
  for (std::int64_t i = 0; i < 3; ++i) {
    frames.push_back(noisy_frame(i));
    frames.back().camera.fx += static_cast<double>(i);
    frames.back().camera.cy -= 0.25 * static_cast<double>(i);
    writer.write(i, frames.back());
  }
  writer.finish();
  const H5Source source(folder / "a.h5");
  for (std::int64_t i = 0; i < 3; ++i) {
    const Frame& expected = frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(source.read(i).camera, expected.camera);
    testing::expect_near(*source.read(i).truth, *expected.truth, 1e-4, 1e-4);
    EXPECT_EQ(source.read_label(i).camera, expected.camera);
    testing::expect_near(*source.read_label(i).truth, *expected.truth, 1e-4, 1e-4);
  }
}

TEST(H5, HasTheSameBytesWhateverThreadsAndInterruptions) {
  const testing::TemporaryFolder folder;
  write_set(folder / "a.h5", 5, 30);
  {
    H5Writer backwards(folder / "b.h5", options_for(5, 30));
    for (std::int64_t i = 34; i > 20; --i) backwards.write(i, noisy_frame(i));
  }
  H5Writer rest(folder / "b.h5", options_for(5, 30));
  for (std::int64_t i = 5; i < 35; ++i)
    if (!rest.has(i)) rest.write(i, noisy_frame(i));
  rest.finish();
  EXPECT_TRUE(read_text_file(folder / "a.h5") == read_text_file(folder / "b.h5"));
  EXPECT_FALSE(fs::exists(folder / "b.h5.partial"));
  EXPECT_FALSE(fs::exists(folder / "b.h5.assembled"));
}

TEST(H5, KeepsTheSharedLandmarksOfOtherConventions) {
  const testing::TemporaryFolder folder;
  const Frame frame = noise_frame(small_camera(), convention_from_name("icg20"), 3);
  Frame unlabelled = frame;
  unlabelled.truth.reset();
  H5Writer writer(folder / "a.h5", options_for(0, 2));
  writer.write(0, frame);
  writer.write(1, unlabelled);
  writer.finish();
  const H5Source source(folder / "a.h5");
  testing::expect_near(*source.read(0).truth, converted(*frame.truth, superset_convention()), 1e-4, 1e-4);
  EXPECT_FALSE(source.read(1).truth);
}

TEST(H5, AnInterruptedRunGoesOn) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  {
    H5Writer writer(path, options_for(10, 6));
    for (const int i : {12, 10, 15}) writer.write(i, noisy_frame(i));
  }
  EXPECT_FALSE(fs::exists(path));
  H5Writer writer(path, options_for(10, 6));
  for (std::int64_t i = 10; i < 16; ++i) {
    EXPECT_EQ(writer.has(i), i == 10 || i == 12 || i == 15) << i;
    if (!writer.has(i)) writer.write(i, noisy_frame(i));
  }
  writer.finish();
  expect_frames(path, 10, 6);
}

TEST(H5, AKilledRunGoesOn) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  constexpr std::int64_t kCount = 700;
  // The child dies without closing the file, in the midst of its work.
  EXPECT_EXIT(
      {
        H5Writer writer(path, options_for(0, kCount));
        for (std::int64_t i = 0; i < 600; ++i) writer.write(i, noisy_frame(i));
        std::_Exit(7);
      },
      ::testing::ExitedWithCode(7), "");
  EXPECT_THAT(error_of_h5_set(folder / "a.h5.partial"), HasSubstr("a.h5.partial"));
  H5Writer writer(path, options_for(0, kCount));
  std::int64_t kept = 0;
  for (std::int64_t i = 0; i < kCount; ++i) {
    if (writer.has(i)) {
      ++kept;
    } else {
      writer.write(i, noisy_frame(i));
    }
  }
  EXPECT_EQ(kept, 600);
  writer.finish();
  expect_frames(path, 0, kCount);
}

TEST(H5, ADamagedRemainderIsBegunAnew) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  for (const int cut : {0, 1, 50, 2000, 20000}) {
    {
      H5Writer writer(path, options_for(0, 20));
      for (std::int64_t i = 0; i < 19; ++i) writer.write(i, noisy_frame(i));
    }
    fs::remove(path);
    testing::cut_file(folder / "a.h5.partial", static_cast<std::uintmax_t>(cut));
    H5Writer writer(path, options_for(0, 20));
    for (std::int64_t i = 0; i < 20; ++i)
      if (!writer.has(i)) writer.write(i, noisy_frame(i));
    writer.finish();
    expect_frames(path, 0, 20);
  }
}

TEST(H5, ARemainderOfAnotherRunIsNotTouched) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  { H5Writer(path, options_for(0, 4)).write(1, noisy_frame(1)); }
  EXPECT_THAT(error_of([&] { H5Writer(path, options_for(0, 4, "a = 2")); }),
              AllOf(HasSubstr("a.h5.partial"), HasSubstr("another manifest")));
  EXPECT_THAT(error_of([&] { H5Writer(path, options_for(0, 5)); }), HasSubstr("other frames"));
  EXPECT_THAT(error_of([&] { H5Writer(path, options_for(1, 4)); }), HasSubstr("other frames"));
  EXPECT_TRUE(H5Writer(path, options_for(0, 4)).has(1));
}

TEST(H5, AnUnfinishedSetIsNoSource) {
  const testing::TemporaryFolder folder;
  { H5Writer(folder / "a.h5", options_for(0, 4)).write(1, noisy_frame(1)); }
  EXPECT_THAT(error_of_h5_set(folder / "a.h5.partial"),
              AllOf(HasSubstr("a.h5.partial"), HasSubstr("unfinished")));
  H5Writer writer(folder / "a.h5", options_for(0, 4));
  EXPECT_THAT(error_of([&] { writer.finish(); }), AllOf(HasSubstr("a.h5"), HasSubstr("3 of 4 frames")));
  EXPECT_FALSE(fs::exists(folder / "a.h5"));
}

TEST(H5, NamesFileAndFault) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  EXPECT_THAT(error_of_h5_set(path), AllOf(HasSubstr("a.h5"), HasSubstr("missing")));
  put_file(path, "this is not an HDF5 file");
  EXPECT_THAT(error_of_h5_set(path), AllOf(HasSubstr("a.h5"), HasSubstr("HDF5")));
  Hdf5Writer::create(path).close();
  EXPECT_THAT(error_of_h5_set(path), AllOf(HasSubstr("a.h5"), HasSubstr("format")));
}

TEST(H5, RefusesAnotherVersionAndArraysThatDoNotFit) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  const auto error_after = [&](const std::function<void(Hdf5Writer&)>& spoil) {
    fs::remove(path);
    write_set(path, 0, 3);
    Hdf5Writer file = Hdf5Writer::open(path);
    spoil(file);
    file.close();
    return error_of_h5_set(path);
  };
  EXPECT_THAT(error_after([](Hdf5Writer& file) { file.set_attribute("version", 4); }),
              AllOf(HasSubstr("a.h5"), HasSubstr("version 4")));
  EXPECT_THAT(error_after([](Hdf5Writer& file) { file.set_attribute("complete", 0); }),
              AllOf(HasSubstr("a.h5"), HasSubstr("unfinished")));
  EXPECT_THAT(error_after([](Hdf5Writer& file) {
                const double no_focal_length[] = {0.0, 31.25, 11.7, 8.4};
                file.write_rows(kH5Intrinsics, 0, 1, no_focal_length);
              }),
              AllOf(HasSubstr("a.h5: intrinsics: frame 0"), HasSubstr("fx")));
  EXPECT_THAT(error_after([](Hdf5Writer& file) {
                const std::int8_t third_hand = 2;
                file.write_rows(kH5Side, 0, 1, &third_hand);
              }),
              AllOf(HasSubstr("a.h5: frame 0"), HasSubstr("side is 2")));
  EXPECT_THAT(error_after([](Hdf5Writer& file) {
                const double back[] = {1.0, 0.5};
                file.write_rows(kH5Time, 0, 2, back);
              }),
              HasSubstr("a.h5: frame 1: the time goes back from 1 to 0.5 s"));
  EXPECT_THAT(error_after([](Hdf5Writer& file) {
                const double never = std::numeric_limits<double>::quiet_NaN();
                file.write_rows(kH5Time, 2, 1, &never);
              }),
              HasSubstr("a.h5: frame 2: the time is nan"));
  EXPECT_THAT(error_after([](Hdf5Writer& file) {
                const std::int32_t below = -1;
                file.write_rows(kH5Sequence, 0, 1, &below);
              }),
              HasSubstr("a.h5: frame 0: the sequence is -1"));
  EXPECT_THAT(error_after([](Hdf5Writer& file) { file.set_attribute("format", "knuckle-body"); }),
              AllOf(HasSubstr("a.h5"), HasSubstr("knuckle-body")));
  EXPECT_THAT(error_after([](Hdf5Writer& file) { file.set_attribute("width", 25); }),
              AllOf(HasSubstr("a.h5"), HasSubstr("3 x 18 x 24, expected 3 x 18 x 25")));
  EXPECT_THAT(error_after([](Hdf5Writer& file) { file.set_attribute("height", 17.5); }),
              HasSubstr("'height' is 17.5"));
  for (const double index : {0.5, -1.0, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(error_after([&](Hdf5Writer& file) { file.set_attribute("first_index", index); }),
                HasSubstr(fmt::format("'first_index' is {}, expected a whole number", index)));
  }
  EXPECT_THAT(error_after([](Hdf5Writer& file) { file.set_attribute("width", 1e300); }),
              HasSubstr("'width' is 1e+300"));
  EXPECT_THAT(error_after([](Hdf5Writer& file) { file.set_attribute("width", 16385); }),
              HasSubstr("'width' is 16385"));
  EXPECT_THAT(error_after([](Hdf5Writer& file) { file.set_attribute("fx", 0); }),
              AllOf(HasSubstr("a.h5"), HasSubstr("fx")));
  EXPECT_THAT(error_after([](Hdf5Writer& file) { file.set_attribute("depth_unit_mm", -1); }),
              HasSubstr("depth_unit_mm"));
  EXPECT_THAT(error_after([](Hdf5Writer& file) { file.set_attribute("depth_unit_mm", 1000.5); }),
              HasSubstr("'depth_unit_mm' is 1000.5, expected more than 0, at most 1000"));
  EXPECT_THAT(error_after([](Hdf5Writer& file) {
                const float endless = std::numeric_limits<float>::infinity();
                const std::vector<float> joints(std::size_t{kSupersetSize} * 3, endless);
                file.write_rows(kH5Joints, 0, 1, joints.data());
              }),
              HasSubstr("a.h5: joints_mm: frame 0: inf is out of range, expected at most 1000000000"));
  EXPECT_THAT(error_after([](Hdf5Writer& file) { file.set_attribute("camera_model", "fisheye"); }),
              HasSubstr("'camera_model' is 'fisheye', expected projective or orthographic"));
  EXPECT_THAT(error_after([](Hdf5Writer& file) {
                file.set_attribute("distortion", std::vector<double>{0.1, 0.2});
              }),
              HasSubstr("a.h5: the attribute 'distortion' has 2 numbers, expected 8"));
}

TEST(H5, WithoutAFrameItIsRefused) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  {
    Hdf5Writer file = Hdf5Writer::create(path);
    file.set_attribute("format", kH5Format);
    file.set_attribute("version", 2);  // without sums
    file.set_attribute("complete", 1);
    file.set_attribute("first_index", 0);
    file.set_attribute("depth_unit_mm", 0.1);
    write_camera(file, small_camera());
    file.create_dataset<std::uint16_t>(kH5Depth, {0, 18, 24}, {});
    file.close();
  }
  EXPECT_THAT(error_of_h5_set(path), HasSubstr("a.h5: holds no frame"));
}

/// Zeros, deflated to next to nothing: what has a number per frame is read whole.
TEST(H5, OfMoreFramesThanAFileOfItsSizeCanHoldIsRefused) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  constexpr std::uint64_t kManyFrames = 200'000;
  Camera camera = small_camera();
  camera.width = camera.height = 1;
  Hdf5Writer file = Hdf5Writer::create(path);
  file.set_attribute("format", kH5Format);
  file.set_attribute("version", 2);  // before there were sums
  file.set_attribute("complete", 1);
  file.set_attribute("first_index", 0);
  file.set_attribute("depth_unit_mm", 0.1);
  write_camera(file, camera);
  const std::vector<std::uint16_t> depth(kManyFrames, 0);
  file.write(kH5Depth, {kManyFrames, 1, 1}, depth.data(), {kManyFrames, 9});
  file.close();
  EXPECT_THAT(
      error_of_h5_set(path),
      HasSubstr(fmt::format("a.h5: says that it holds 200000 frames, more than a file of {} bytes can",
                            fs::file_size(path))));
}

TEST(H5, ThatChangesWhileItIsReadIsRefused) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  write_set(path, 0, 3);
  const H5Source source(path);
  const auto bytes = fs::file_size(path);
  fs::resize_file(path, bytes + 1);
  const std::string expected =
      fmt::format("a.h5: was changed while it was read: it has {} bytes, {} when", bytes + 1, bytes);
  EXPECT_THAT(error_of([&] { source.read(0); }), HasSubstr(expected));
  EXPECT_THAT(error_of([&] { source.read_label(0); }), HasSubstr(expected));
  EXPECT_THAT(error_of([&] { source.read_stored(0); }), HasSubstr(expected));
}

TEST(H5, FramesAreThoseOfTheSet) {
  const testing::TemporaryFolder folder;
  write_set(folder / "a.h5", 0, 3);
  const H5Source source(folder / "a.h5");
  for (const std::int64_t index : {-1, 3}) {
    const std::string expected = fmt::format("a.h5: has 3 frames, asked for frame {}", index);
    EXPECT_THAT(error_of([&] { source.read(index); }), HasSubstr(expected));
    EXPECT_THAT(error_of([&] { source.read_label(index); }), HasSubstr(expected));
  }
}

TEST(H5, RefusesEachArrayOfAnotherShape) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  /// A set of two frames in which the array `wrong` has three rows.
  const auto write_with_wrong = [&](std::string_view wrong) {
    const auto rows = [&](std::string_view array) { return std::uint64_t{array == wrong ? 3u : 2u}; };
    Hdf5Writer file = Hdf5Writer::create(path);
    file.set_attribute("format", kH5Format);
    file.set_attribute("version", 2);  // without sums
    file.set_attribute("complete", 1);
    file.set_attribute("first_index", 0);
    file.set_attribute("depth_unit_mm", 0.1);
    write_camera(file, small_camera());
    const std::vector<std::uint16_t> pixels(std::size_t{3} * 18 * 24);
    file.write<std::uint16_t>(kH5Depth, {2, 18, 24}, pixels.data());
    file.write<std::uint16_t>(kH5Infrared, {rows(kH5Infrared), 18, 24}, pixels.data());
    file.write<std::uint16_t>(kH5Mask, {rows(kH5Mask), 18, 24}, pixels.data());
    file.write<float>(kH5Joints, {rows(kH5Joints), 22, 3}, std::vector<float>(198, 500.0f).data());
    file.write<double>(kH5Intrinsics, {rows(kH5Intrinsics), 4}, std::vector<double>(12, 30.0).data());
    file.write<double>(kH5Time, {rows(kH5Time)}, std::vector<double>(3, 0.5).data());
    file.write<std::int32_t>(kH5Sequence, {rows(kH5Sequence)}, std::vector<std::int32_t>(3).data());
    file.close();
  };
  write_with_wrong("");
  EXPECT_EQ(H5Source(path).read(1).camera.fx, 30.0);
  for (const std::string_view array :
       {kH5Infrared, kH5Mask, kH5Joints, kH5Intrinsics, kH5Time, kH5Sequence}) {
    write_with_wrong(array);
    EXPECT_THAT(error_of_h5_set(path), HasSubstr(fmt::format("a.h5: {}: has the shape 3", array)));
  }
}

TEST(H5, RefusesAFileCutShortAnywhere) {
  const testing::TemporaryFolder folder;
  const fs::path path = folder / "a.h5";
  write_set(path, 0, 5);
  const auto bytes = fs::file_size(path);
  for (std::uintmax_t cut = bytes - 1; cut > 0; cut -= std::min(cut, bytes / 25 + 1)) {
    testing::cut_file(path, cut);
    EXPECT_THAT(error_of_h5_set(path), HasSubstr("a.h5")) << cut << " of " << bytes;
  }
}

}  // namespace
}  // namespace knuckle
