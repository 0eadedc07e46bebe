// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/folder_source.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/data/writers/folder_writer.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::noise_frame;
using testing::put_file;
using testing::small_camera;

constexpr std::string_view kDescription =
    "convention = \"icg20\"\n"
    "[camera]\nwidth = 24\nheight = 18\nfx = 30.5\nfy = 31.25\ncx = 11.7\ncy = 8.4\n";

/// A set of two frames to spoil: depth of 500 counts, no joints.
void put_set(const fs::path& folder, std::string_view description = kDescription) {
  put_file(folder / "dataset.toml", description);
  make_folder(folder / "depth");
  for (const std::string name : {"a.png", "b.png"})
    write_png(folder / "depth" / name, Image<std::uint16_t>(24, 18, 500));
}

std::string error_of_folder_set(const fs::path& folder, int frame = -1) {
  return error_of([&] {
    const FolderSource source(folder);
    if (frame >= 0) source.read(frame);
  });
}

struct FolderRoundTrip : ::testing::TestWithParam<PixelOrigin> {};

TEST(Folder, LabelsNeedNoImages) {
  const testing::TemporaryFolder folder;
  FolderWriter writer(folder / "set", {});
  for (std::int64_t i = 0; i < 2; ++i)
    writer.write(i, noise_frame(small_camera(), convention_from_name("icg20"), i));
  writer.finish();
  const FolderSource source(folder / "set");
  const std::optional<HandPose> truth = source.read(1).truth;
  fs::remove_all(folder / "set" / "depth");
  EXPECT_THAT(error_of([&] { source.read(1); }), HasSubstr("00000001.png"));
  testing::expect_near(*source.read_label(1).truth, *truth, 0.0, 0.0);
}

TEST_P(FolderRoundTrip, ReadsWhatWasWritten) {
  const testing::TemporaryFolder folder;
  const Camera camera = testing::distorted_camera();
  const Convention convention = convention_from_name("msra21");
  FrameWriterOptions options;
  options.pixel_origin = GetParam();
  FolderWriter writer(folder / "set", options);
  parallel_for(6, [&](std::int64_t i) { writer.write(5 - i, noise_frame(camera, convention, 5 - i)); });
  writer.finish();

  const FolderSource source(folder / "set");
  ASSERT_EQ(source.size(), 6);
  EXPECT_EQ(source.convention()->name, "msra21");
  EXPECT_EQ(source.pixel_origin(), GetParam());
  testing::expect_labels_like_frames(source);
  parallel_for(6, [&](std::int64_t i) {
    const Frame expected = noise_frame(camera, convention, i);
    const Frame actual = source.read(i);
    testing::expect_near(actual.camera, camera);
    testing::expect_near(actual.depth_mm, expected.depth_mm, 0.0501);
    EXPECT_EQ(actual.infrared, expected.infrared);
    EXPECT_EQ(actual.mask, expected.mask);
    testing::expect_near(*actual.truth, *expected.truth, 1e-12, 0.0);
  });
}

INSTANTIATE_TEST_SUITE_P(Origins, FolderRoundTrip,
                         ::testing::Values(PixelOrigin::centre, PixelOrigin::corner));

/// Six frames in two sequences, which begin at frames 0 and 4, of right hands.
Frame timed_frame(std::int64_t index) {
  Frame frame = noise_frame(small_camera(), convention_from_name("icg20"), static_cast<std::uint64_t>(index));
  frame.time_s = 0.025 * static_cast<double>(index % 4);
  frame.sequence = static_cast<int>(3 + index / 4);
  frame.side = HandSide::right;
  return frame;
}

TEST(Folder, KeepsTimesSequencesAndSide) {
  const testing::TemporaryFolder folder;
  FolderWriter writer(folder.path(), {});
  parallel_for(6, [&](std::int64_t i) { writer.write(5 - i, timed_frame(5 - i)); });
  writer.finish();
  const FolderSource source(folder.path());
  testing::expect_labels_like_frames(source);
  for (std::int64_t i = 0; i < 6; ++i) {
    EXPECT_EQ(source.read(i).time_s, timed_frame(i).time_s);
    EXPECT_EQ(source.read(i).sequence, i / 4);
    EXPECT_EQ(source.read(i).side, HandSide::right);
  }
  const std::string description = read_text_file(folder / "dataset.toml");
  EXPECT_THAT(description, AllOf(HasSubstr("side = \"right\""), HasSubstr("rate_hz = 40\n")));
  fs::remove(folder / "times.txt");
  EXPECT_EQ(FolderSource(folder.path()).read(5).time_s, 0.025) << "the rate says the same";
}

TEST(Folder, HandsOfBothSidesAreNotToldApart) {
  const testing::TemporaryFolder folder;
  FolderWriter writer(folder.path(), {});
  for (std::int64_t i = 0; i < 2; ++i) {
    Frame frame = timed_frame(i);
    if (i == 1) frame.side = HandSide::left;
    writer.write(i, frame);
  }
  writer.finish();
  EXPECT_THAT(read_text_file(folder / "dataset.toml"), HasSubstr("side = \"both\""));
  EXPECT_EQ(FolderSource(folder.path()).read(1).side, std::nullopt);
}

TEST(Folder, RefusesToWriteATimeThatGoesBackOrIsMissingInBetween) {
  const testing::TemporaryFolder folder;
  FolderWriter backwards(folder / "a", {});
  Frame frame = timed_frame(1);
  backwards.write(0, frame);
  frame.time_s = 0.0;
  backwards.write(1, frame);
  EXPECT_THAT(error_of([&] { backwards.finish(); }), HasSubstr("frame 1: the time goes back"));
  EXPECT_FALSE(fs::exists(folder / "a" / "dataset.toml"));
  FolderWriter gap(folder / "b", {});
  gap.write(0, frame);
  frame.time_s.reset();
  EXPECT_THAT(error_of([&] { gap.write(1, frame); }),
              HasSubstr("frame 1 has no time, the frames before have one"));
}

TEST(Folder, RefusesToWriteAnotherConventionOrBesideAnEarlierRun) {
  const testing::TemporaryFolder folder;
  FolderWriter mixed(folder / "mixed", {});
  mixed.write(0, noise_frame(small_camera(), convention_from_name("icg20"), 0));
  EXPECT_THAT(
      error_of([&] { mixed.write(1, noise_frame(small_camera(), convention_from_name("mediapipe21"), 1)); }),
      HasSubstr("frame 1 is labelled in mediapipe21, frames before in icg20"));
  FolderWriter writer(folder / "set", {});
  writer.write(0, noise_frame(small_camera(), convention_from_name("icg20"), 0));
  write_png(folder / "set" / "depth" / "00000007.png", Image<std::uint16_t>(24, 18, 500));
  EXPECT_THAT(error_of([&] { writer.finish(); }), HasSubstr("holds 2 images, 1 were written"));
}

TEST(Folder, AFileInPlaceOfAFolderIsNamed) {
  const testing::TemporaryFolder folder;
  put_set(folder.path());
  fs::remove_all(folder / "depth");
  put_file(folder / "depth", "");
  EXPECT_THAT(error_of_folder_set(folder.path()), HasSubstr("depth: is not a folder"));
}

TEST(Folder, AMistypedKeyIsNamedBeforeTheOneThatIsMissing) {
  const testing::TemporaryFolder folder;
  put_set(folder.path(), "[camera]\nwidht = 24\nheight = 18\nfx = 30\nfy = 30\ncx = 12\ncy = 9\n");
  EXPECT_THAT(error_of_folder_set(folder.path()),
              HasSubstr("dataset.toml:2: camera.widht: unknown key (did you mean 'width'?)"));
  put_set(folder.path(), "[camra]\nwidth = 24\n");
  EXPECT_THAT(error_of_folder_set(folder.path()), HasSubstr("camra: unknown key (did you mean 'camera'?)"));
}

TEST(Folder, AFileThatVanishesOrShrinksAfterOpeningIsAFaultOfItsFrame) {
  const testing::TemporaryFolder folder;
  FolderWriter writer(folder.path(), {});
  for (std::int64_t i = 0; i < 3; ++i) writer.write(i, timed_frame(i));
  writer.finish();
  const FolderSource source(folder.path());
  const fs::path image = folder / "depth" / "00000001.png";
  testing::cut_file(image, fs::file_size(image) / 2);
  fs::remove(folder / "mask" / "00000002.png");
  EXPECT_THAT(error_of([&] { source.read(1); }), AllOf(HasSubstr("00000001.png"), HasSubstr("cut short")));
  EXPECT_THAT(error_of([&] { source.read(2); }), HasSubstr("mask/00000002.png"));
  EXPECT_NO_THROW(source.read(0));
  const fs::path joints = folder / "joints.txt";
  testing::cut_file(joints, fs::file_size(joints) / 2);
  EXPECT_NO_THROW(source.read_label(0));
  EXPECT_THAT(error_of([&] { source.read_label(2); }), HasSubstr("joints.txt"));
  fs::remove(joints);
  EXPECT_THAT(error_of([&] { source.read_label(0); }), HasSubstr("joints.txt"));
}

TEST(Folder, AFrameOfAnotherSizeAmongOthersIsAFaultOfItsOwn) {
  const testing::TemporaryFolder folder;
  put_set(folder.path());
  write_png(folder / "depth" / "b.png", Image<std::uint16_t>(30, 18, 500));
  const FolderSource source(folder.path());
  EXPECT_NO_THROW(source.read(0));
  EXPECT_THAT(error_of([&] { source.read(1); }), AllOf(HasSubstr("b.png"), HasSubstr("30x18")));
}

TEST(Folder, WritesFramesWithoutTruthInfraredAndMask) {
  const testing::TemporaryFolder folder;
  FolderWriter writer(folder.path(), {});
  Frame frame = noise_frame(small_camera(), convention_from_name("icg20"), 1);
  frame.truth.reset();
  frame.infrared = {};
  frame.mask = {};
  writer.write(0, frame);
  writer.finish();
  const FolderSource source(folder.path());
  EXPECT_FALSE(source.convention());
  const Frame back = source.read(0);
  EXPECT_FALSE(back.truth);
  EXPECT_TRUE(back.infrared.empty());
  EXPECT_TRUE(back.mask.empty());
}

TEST(Folder, AFrameWithoutTruthAmongOthersStaysWithout) {
  const testing::TemporaryFolder folder;
  FolderWriter writer(folder.path(), {});
  Frame frame = noise_frame(small_camera(), convention_from_name("icg20"), 1);
  writer.write(0, frame);
  frame.truth.reset();
  writer.write(1, frame);
  writer.finish();
  const FolderSource source(folder.path());
  EXPECT_TRUE(source.read(0).truth);
  EXPECT_FALSE(source.read(1).truth);
}

TEST(Folder, HoldsOrthographicCameras) {
  const testing::TemporaryFolder folder;
  Camera camera{CameraModel::orthographic, 24, 18, 0.25, 0.5, 12.0, 9.0, {}};
  FolderWriter writer(folder.path(), {});
  writer.write(3, noise_frame(camera, convention_from_name("icg20"), 1));
  writer.finish();
  EXPECT_EQ(FolderSource(folder.path()).read(0).camera, camera);
}

TEST(Folder, CornerCoordinatesAreHalfAPixelMore) {
  const testing::TemporaryFolder folder;
  put_set(folder.path(), "pixel_origin = \"corner\"\n" + std::string(kDescription));
  std::string line = "10.5 9 500";
  for (int i = 1; i < 20; ++i) line += " nan nan nan";
  put_file(folder / "joints.txt", line + "\n" + line + "\n");
  const Frame frame = FolderSource(folder.path()).read(0);
  EXPECT_DOUBLE_EQ(frame.camera.cx, 11.2);
  EXPECT_DOUBLE_EQ(frame.camera.cy, 7.9);
  EXPECT_DOUBLE_EQ(frame.truth->joints[0].u, 10.0);
  EXPECT_DOUBLE_EQ(frame.truth->joints[0].v, 8.5);
  EXPECT_TRUE(frame.truth->joints[1].is_missing());
}

TEST(Folder, ReadsInfraredOfEightBitsAndAnyMaskThatIsNotZero) {
  const testing::TemporaryFolder folder;
  put_set(folder.path());
  make_folder(folder / "infrared");
  make_folder(folder / "mask");
  write_png(folder / "infrared" / "a.png", Image<std::uint8_t>(24, 18, 77));
  write_png(folder / "mask" / "a.png", Image<std::uint8_t>(24, 18, 3));
  const FolderSource source(folder.path());
  const Frame frame = source.read(0);
  EXPECT_EQ(frame.name, "a");
  EXPECT_EQ(frame.infrared(5, 5), 77);
  EXPECT_EQ(frame.mask(5, 5), 1);
  EXPECT_THAT(error_of([&] { source.read(1); }), HasSubstr("infrared/b.png"));
}

TEST(Folder, NamesWhatIsMissing) {
  const testing::TemporaryFolder folder;
  EXPECT_THAT(error_of_folder_set(folder / "none"), AllOf(HasSubstr("none"), HasSubstr("no such folder")));
  EXPECT_THAT(error_of_folder_set(folder.path()), HasSubstr("dataset.toml"));
  put_set(folder.path());
  fs::remove_all(folder / "depth");
  EXPECT_THAT(error_of_folder_set(folder.path()), AllOf(HasSubstr("depth"), HasSubstr("no such folder")));
  make_folder(folder / "depth");
  EXPECT_THAT(error_of_folder_set(folder.path()), AllOf(HasSubstr("depth"), HasSubstr("no .png")));
}

TEST(Folder, RefusesADescriptionWithFaults) {
  const testing::TemporaryFolder folder;
  const std::string good(kDescription);
  const auto error_with = [&](const std::string& description) {
    put_set(folder.path(), description);
    return error_of_folder_set(folder.path());
  };
  EXPECT_THAT(error_with("colour = 1\n" + good), AllOf(HasSubstr("dataset.toml"), HasSubstr("colour")));
  EXPECT_THAT(error_with(good + "zoom = 2\n"), AllOf(HasSubstr("dataset.toml"), HasSubstr("zoom")));
  EXPECT_THAT(error_with("depth_unit_mm = \"one\"\n" + good), HasSubstr("depth_unit_mm"));
  EXPECT_THAT(error_with("depth_unit_mm = 0\n" + good), HasSubstr("depth_unit_mm"));
  EXPECT_THAT(error_with("pixel_origin = \"middle\"\n" + good),
              AllOf(HasSubstr("middle"), HasSubstr("corner")));
  EXPECT_THAT(error_with("[camera]\nwidth = 24\n"), HasSubstr("dataset.toml: [camera] lacks 'height'"));
  EXPECT_THAT(error_with("depth_unit_mm = 1\n"), HasSubstr("dataset.toml: lacks the table [camera]"));
  EXPECT_THAT(error_with("convention = \"../own.toml\"\n" + good.substr(good.find('['))),
              HasSubstr("expected the name of a file in the same folder"));
  EXPECT_THAT(error_with("[camera]\nwidth = 24\nheight = 18\nfx = 0\nfy = 1\ncx = 0\ncy = 0\n"),
              AllOf(HasSubstr("dataset.toml"), HasSubstr("fx")));
  EXPECT_THAT(error_with(good + "width = 0\n"), HasSubstr("width"));
  EXPECT_THAT(error_with("convention = \"icg21\"\n" + good.substr(good.find('['))),
              AllOf(HasSubstr("dataset.toml"), HasSubstr("icg21"), HasSubstr("icg20")));
  EXPECT_THAT(error_with("not toml"), HasSubstr("dataset.toml"));
}

TEST(Folder, RefusesJointsThatDoNotFit) {
  const testing::TemporaryFolder folder;
  put_set(folder.path());
  const std::string line = testing::numbers_text(60, 1.0);
  put_file(folder / "joints.txt", line + "\n");
  EXPECT_THAT(error_of_folder_set(folder.path()),
              AllOf(HasSubstr("joints.txt"), HasSubstr("1 lines"), HasSubstr("2 depth")));
  put_file(folder / "joints.txt", line + "\n" + line + "\n" + line + "\n");
  EXPECT_THAT(error_of_folder_set(folder.path()), AllOf(HasSubstr("joints.txt"), HasSubstr("3 lines")));
  put_file(folder / "joints.txt", line + "\n1 2 3\n");
  EXPECT_THAT(error_of_folder_set(folder.path(), 1),
              AllOf(HasSubstr("joints.txt:2"), HasSubstr("expected 60")));
  put_file(folder / "joints.txt", line + "\n" + line + "x\n");
  EXPECT_THAT(error_of_folder_set(folder.path(), 1), AllOf(HasSubstr("joints.txt:2"), HasSubstr("'60x'")));
  put_set(folder.path(), kDescription.substr(kDescription.find('[')));
  EXPECT_THAT(error_of_folder_set(folder.path()), AllOf(HasSubstr("dataset.toml"), HasSubstr("convention")));
}

TEST(Folder, RefusesImagesOfTheWrongKindSizeOrLength) {
  const testing::TemporaryFolder folder;
  put_set(folder.path());
  const fs::path image = folder / "depth" / "a.png";
  write_png(image, Image<std::uint16_t>(25, 18, 500));
  EXPECT_THAT(error_of_folder_set(folder.path(), 0),
              AllOf(HasSubstr("a.png"), HasSubstr("25x18"), HasSubstr("24x18")));
  write_png(image, Image<std::uint8_t>(24, 18, 50));
  EXPECT_THAT(error_of_folder_set(folder.path(), 0), AllOf(HasSubstr("a.png"), HasSubstr("16 bits")));
  put_file(image, "no png at all");
  EXPECT_THAT(error_of_folder_set(folder.path(), 0), AllOf(HasSubstr("a.png"), HasSubstr("PNG")));
  write_png(image, Image<std::uint16_t>(24, 18, 500));
  testing::cut_file(image, fs::file_size(image) / 2);
  EXPECT_THAT(error_of_folder_set(folder.path(), 0), AllOf(HasSubstr("a.png"), HasSubstr("cut short")));
  make_folder(folder / "mask");
  write_png(folder / "mask" / "b.png", Image<std::uint8_t>(18, 24, 1));
  EXPECT_THAT(error_of_folder_set(folder.path(), 1), AllOf(HasSubstr("mask/b.png"), HasSubstr("18x24")));
}

TEST(Folder, ReadsTheRealSequenceWithItsTruth) {
  KNUCKLE_REQUIRE_SHARED_DATA(shared);
  const FolderSource source(shared / "real/rgbd_sequence");
  ASSERT_EQ(source.size(), 20);
  EXPECT_EQ(source.convention()->name, "mediapipe21");
  for (std::int64_t i = 0; i < source.size(); ++i) {
    const Frame frame = source.read(i);
    ASSERT_EQ(frame.depth_mm.width(), 640);
    ASSERT_TRUE(frame.truth);
    // The labels lie on the hand: most joints are within 50 mm of the surface that is measured there.
    int near_surface = 0;
    for (const ImagePoint& joint : frame.truth->joints) {
      const float depth =
          frame.depth_mm(static_cast<int>(std::lround(joint.u)), static_cast<int>(std::lround(joint.v)));
      if (std::abs(depth - joint.depth_mm) < 50) ++near_surface;
    }
    EXPECT_GE(near_surface, 15) << frame.name;
  }
}

TEST(Folder, ReadsAllOtherRealFolders) {
  KNUCKLE_REQUIRE_SHARED_DATA(shared);
  const std::pair<const char*, int> folders[] = {
      {"sr305_open_hand", 8}, {"sr305_other", 11}, {"kinect_scenes", 3}, {"kinect_hand_mask", 1}};
  for (const auto& [name, size] : folders) {
    const FolderSource source(shared / "real" / name);
    EXPECT_EQ(source.size(), size) << name;
    EXPECT_FALSE(source.convention()) << name;
    const Frame frame = source.read(0);
    const auto valid =
        std::ranges::count_if(frame.depth_mm.pixels(), [](float d) { return d > 0 && d < 10000; });
    EXPECT_GT(valid, static_cast<std::ptrdiff_t>(frame.depth_mm.size() / 10)) << name;
    EXPECT_EQ(frame.mask.empty(), std::string(name) != "kinect_hand_mask") << name;
  }
}

}  // namespace
}  // namespace knuckle
