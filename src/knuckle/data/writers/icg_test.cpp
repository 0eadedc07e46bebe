// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/data/readers/csv_image.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/exr_image.h"
#include "knuckle/data/readers/icg_format.h"
#include "knuckle/data/readers/icg_source.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/data/writers/icg_writer.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::noise_frame;
using testing::numbers_text;
using testing::put_file;
using testing::small_camera;

std::string error_of_icg_set(const fs::path& folder, const IcgOptions& options = {}) {
  return error_of([&] { IcgSource(folder, options).read(0); });
}

/// One recorded frame of 4 x 2 pixels in a sub-folder, its calibration above.
void put_recorded(const fs::path& folder) {
  put_file(folder / "calibration_depth.txt", "224.5 230.5\n160.5 120.25\n");
  put_file(folder / "s1" / "0007_123_depth.csv", "100,200,300,-1\n400,1000,1001,nan\n");
  put_file(folder / "s1" / "0007_123_infrared.csv", "250,249,9000,300\n300,300,300,300\n");
}

TEST(Icg, TakesNamesApart) {
  const auto synthetic = parse_icg_depth_name("clean/3_5_depth_0002.exr");
  ASSERT_TRUE(synthetic);
  EXPECT_EQ(synthetic->stem, "clean/3_5");
  EXPECT_EQ(synthetic->number, "_0002");
  EXPECT_TRUE(synthetic->is_synthetic);
  const auto recorded = parse_icg_depth_name("3_5_depth.csv");
  ASSERT_TRUE(recorded);
  EXPECT_FALSE(recorded->is_synthetic);
  for (const char* other :
       {"3_5_infrared.csv", "3_5_depth.txt", "3_5_depth_x.exr", "_depth.csv", "a/_depth.csv"})
    EXPECT_FALSE(parse_icg_depth_name(other)) << other;
  EXPECT_EQ(icg_annotator_of("a_b/3_5_anno_me_too.txt"), "me_too");
  EXPECT_EQ(icg_annotator_of("x_anno_y/calib.txt"), "");
}

TEST(Icg, ReadsWhatWasWritten) {
  const testing::TemporaryFolder folder;
  const Camera camera = testing::distorted_camera();
  const Convention convention = convention_from_name("icg20");
  IcgWriter writer(folder.path(), {});
  parallel_for(5, [&](std::int64_t i) { writer.write(i, noise_frame(camera, convention, i)); });
  writer.finish();
  const IcgSource source(folder.path(), {});
  ASSERT_EQ(source.size(), 5);
  EXPECT_EQ(source.convention()->name, "icg20");
  EXPECT_EQ(source.pixel_origin(), PixelOrigin::corner);
  testing::expect_labels_like_frames(source);
  parallel_for(5, [&](std::int64_t i) {
    const Frame expected = noise_frame(camera, convention, i);
    const Frame actual = source.read(i);
    testing::expect_near(actual.camera, camera);
    testing::expect_near(actual.depth_mm, expected.depth_mm, 1e-3);
    EXPECT_EQ(actual.infrared, expected.infrared);
    EXPECT_EQ(actual.mask, expected.mask);
    testing::expect_near(*actual.truth, *expected.truth, 1e-12, 0.0);
  });
}

TEST(Icg, KeepsTheSharedLandmarksOfOtherConventions) {
  const testing::TemporaryFolder folder;
  IcgWriter writer(folder.path(), {});
  const Frame frame = noise_frame(small_camera(), convention_from_name("mediapipe21"), 3);
  writer.write(0, frame);
  writer.finish();
  const Frame back = IcgSource(folder.path(), {}).read(0);
  testing::expect_near(*back.truth, converted(*frame.truth, convention_from_name("icg20")), 1e-12, 0.0);
}

TEST(Icg, BackgroundIsNoMeasurement) {
  const testing::TemporaryFolder folder;
  put_recorded(folder.path());
  const Image<float> depth = IcgSource(folder.path(), {}).read(0).depth_mm;
  const float expected[] = {100, 0,    300, 0,
                            400, 1000, 0,   0};  // 200: too little infrared; -1, 1001, nan: background
  for (std::size_t i = 0; i < depth.size(); ++i) EXPECT_EQ(depth.data()[i], expected[i]) << i;
  const Image<float> lenient = IcgSource(folder.path(), {"", 1500, 0}).read(0).depth_mm;
  EXPECT_EQ(lenient(1, 0), 200.0f);
  EXPECT_EQ(lenient(2, 1), 1001.0f);
}

TEST(Icg, FindsTheNearestCalibrationAndMovesItToPixelCentres) {
  const testing::TemporaryFolder folder;
  put_recorded(folder.path());
  const auto camera = [&] { return IcgSource(folder.path(), {}).read(0).camera; };
  EXPECT_EQ(camera().cx, 160.0);
  EXPECT_EQ(camera().cy, 119.75);
  EXPECT_EQ(camera().width, 4);
  EXPECT_EQ(camera().height, 2);
  put_file(folder / "s1" / "calib.txt", "300 301\n2 1\n0.1 0.2 0 0 0.3\n");
  EXPECT_EQ(camera().fx, 300.0);
  EXPECT_EQ(camera().distortion[4], 0.3);
}

TEST(Icg, PrefersVerifiedLabels) {
  const testing::TemporaryFolder folder;
  put_recorded(folder.path());
  const auto first_u = [&](const IcgOptions& options = {}) {
    return IcgSource(folder.path(), options).read(0).truth->joints[0].u;
  };
  EXPECT_FALSE(IcgSource(folder.path(), {}).convention());
  EXPECT_FALSE(IcgSource(folder.path(), {}).read(0).truth);
  put_file(folder / "s1/0007_123_anno_init.txt", numbers_text(60, 10.5));
  EXPECT_EQ(first_u(), 10.0);
  put_file(folder / "s1/0007_123_anno_extrapolated.txt", numbers_text(60, 20.5));
  EXPECT_EQ(first_u(), 20.0);
  put_file(folder / "s1/0007_123_anno_zoe.txt", numbers_text(60, 30.5, '\n'));
  EXPECT_EQ(first_u(), 30.0);
  EXPECT_EQ(first_u({"init", 1000, 250}), 10.0);
  EXPECT_THAT(error_of_icg_set(folder.path(), {"max", 1000, 250}),
              AllOf(HasSubstr("'max'"), HasSubstr("extrapolated, init, zoe")));
}

TEST(Icg, TheHandIsRed) {
  const testing::TemporaryFolder folder;
  put_file(folder / "calib.txt", "300 300 2 1");
  write_exr(folder / "1_2_depth_0002.exr", Image<float>(4, 1, 0.5f));
  Image<Rgb> colours(4, 1);
  colours(0, 0) = {128, 32, 32};
  colours(1, 0) = {127, 0, 0};
  colours(2, 0) = {255, 33, 0};
  colours(3, 0) = {255, 0, 33};
  write_png(folder / "1_2_rgb_0002.png", colours);
  const Frame frame = IcgSource(folder.path(), {}).read(0);
  EXPECT_EQ(frame.mask(0, 0), 1);
  for (const int column : {1, 2, 3}) EXPECT_EQ(frame.mask(column, 0), 0);
  EXPECT_EQ(frame.depth_mm(0, 0), 500.0f);
}

TEST(Icg, NamesFileAndFault) {
  const testing::TemporaryFolder folder;
  EXPECT_THAT(error_of_icg_set(folder / "none"), AllOf(HasSubstr("none"), HasSubstr("no such folder")));
  EXPECT_THAT(error_of_icg_set(folder.path()),
              AllOf(HasSubstr(folder.path().string()), HasSubstr("_depth.csv")));
  put_recorded(folder.path());
  put_file(folder / "s1/0007_123_anno_me.txt", numbers_text(59, 1));
  EXPECT_THAT(error_of_icg_set(folder.path()),
              AllOf(HasSubstr("_anno_me.txt"), HasSubstr("59 numbers, expected 60")));
  put_file(folder / "s1/0007_123_anno_me.txt", numbers_text(59, 1) + " many");
  EXPECT_THAT(error_of_icg_set(folder.path()), AllOf(HasSubstr("_anno_me.txt"), HasSubstr("'many'")));
  put_file(folder / "s1/0007_123_infrared.csv", "250,249,nan,300\n300,300,300,300\n");
  EXPECT_THAT(error_of_icg_set(folder.path()),
              AllOf(HasSubstr("_infrared.csv"), HasSubstr("holds the value nan, expected a number")));
  put_file(folder / "s1/0007_123_infrared.csv", "1,2,3\n4,5,6\n");
  EXPECT_THAT(error_of_icg_set(folder.path()),
              AllOf(HasSubstr("_infrared.csv"), HasSubstr("3x2"), HasSubstr("4x2")));
  put_file(folder / "s1/0007_123_depth.csv", "100,200,300,-1\n400,10");
  EXPECT_THAT(error_of_icg_set(folder.path()), AllOf(HasSubstr("_depth.csv:2"), HasSubstr("expected 4")));
}

TEST(Icg, NamesAMissingOrBrokenCalibration) {
  const testing::TemporaryFolder folder;
  put_recorded(folder.path());
  const fs::path calibration = folder / "calibration_depth.txt";
  put_file(calibration, "224 224\n160\n");
  EXPECT_THAT(error_of_icg_set(folder.path()),
              AllOf(HasSubstr("calibration_depth.txt"), HasSubstr("3 numbers")));
  put_file(calibration, "224 224\n160 wide\n");
  EXPECT_THAT(error_of_icg_set(folder.path()),
              AllOf(HasSubstr("calibration_depth.txt"), HasSubstr("'wide'")));
  put_file(calibration, "0 224\n160 120\n");
  EXPECT_THAT(error_of_icg_set(folder.path()), AllOf(HasSubstr("calibration_depth.txt"), HasSubstr("fx")));
  fs::remove(calibration);
  EXPECT_THAT(error_of_icg_set(folder.path()), AllOf(HasSubstr("s1"), HasSubstr("calibration_depth.txt")));
}

TEST(Icg, RefusesCamerasThatItsCalibrationCannotExpress) {
  const testing::TemporaryFolder folder;
  IcgWriter writer(folder / "set", {});
  Camera camera{CameraModel::orthographic, 24, 18, 0.25, 0.5, 12.0, 9.0, {}};
  EXPECT_THAT(error_of([&] { writer.write(0, noise_frame(camera, convention_from_name("icg20"), 1)); }),
              HasSubstr("projective"));
}

}  // namespace
}  // namespace knuckle
