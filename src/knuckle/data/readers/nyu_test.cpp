// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstring>

#include <matio.h>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/data_testing.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/data/readers/nyu_source.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::put_file;

/// The value that the fixture holds at [view][frame][joint][axis], all from 0.
double fixture_value(std::size_t view, std::size_t frame, std::size_t joint, std::size_t axis) {
  return 1000.0 * static_cast<double>(view + 1) + 100.0 * static_cast<double>(frame) +
         static_cast<double>(joint) + 0.25 * static_cast<double>(axis);
}

void write_mat(const fs::path& path, std::array<std::size_t, 4> dims, matio_compression compression,
               const char* name = "joint_uvd", matio_classes kind = MAT_C_DOUBLE) {
  std::vector<double> values(dims[0] * dims[1] * dims[2] * dims[3]);
  std::size_t place = 0;  // Matlab's order: the first index runs fastest
  for (std::size_t axis = 0; axis < dims[3]; ++axis) {
    for (std::size_t joint = 0; joint < dims[2]; ++joint) {
      for (std::size_t frame = 0; frame < dims[1]; ++frame) {
        for (std::size_t view = 0; view < dims[0]; ++view)
          values[place++] = fixture_value(view, frame, joint, axis);
      }
    }
  }
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
  ASSERT_NE(file, nullptr);
  const matio_types type = kind == MAT_C_DOUBLE ? MAT_T_DOUBLE : MAT_T_INT32;
  matvar_t* array = Mat_VarCreate(name, kind, type, 4, dims.data(), values.data(), 0);
  Mat_VarWrite(file, array, compression);
  Mat_VarFree(array);
  Mat_Close(file);
}

void put_nyu(const fs::path& folder) {
  Image<Rgb> image(640, 480, Rgb{0, 3, 32});
  image(4, 5) = {0, 2001 / 256, 2001 % 256};
  image(5, 5) = {0, 0, 0};
  for (const int view : {1, 2}) {
    for (const int frame : {1, 2, 3})
      write_png(folder / fmt::format("depth_{}_{:07}.png", view, frame), image);
  }
  write_mat(folder / "joint_data.mat", {3, 3, 36, 3}, MAT_COMPRESSION_ZLIB);
}

TEST(Nyu, DecodesDepth) {
  const testing::TemporaryFolder folder;
  put_nyu(folder.path());
  const NyuSource source(folder.path(), {});
  ASSERT_EQ(source.size(), 3);
  testing::expect_labels_like_frames(source);
  const Frame frame = source.read(1);
  EXPECT_EQ(frame.name, "depth_1_0000002");
  EXPECT_EQ(frame.depth_mm(0, 0), 800.0f);
  EXPECT_EQ(frame.depth_mm(4, 5), 0.0f);
  EXPECT_EQ(frame.depth_mm(5, 5), 0.0f);
  EXPECT_GT(frame.camera.fy, 0);
}

struct NyuTruthTest : ::testing::TestWithParam<matio_compression> {};

TEST_P(NyuTruthTest, FindsViewFrameAndTheFourteenJoints) {
  const testing::TemporaryFolder folder;
  write_mat(folder / "joint_data.mat", {3, 5, 36, 3}, GetParam());
  const std::size_t joints[14] = {0, 3, 6, 9, 12, 15, 18, 21, 24, 25, 27, 30, 31, 32};
  for (const int view : {1, 2, 3}) {
    const NyuTruth truth(folder / "joint_data.mat", view);
    ASSERT_EQ(truth.size(), 5);
    for (std::size_t frame = 0; frame < 5; ++frame) {
      const HandPose pose = truth.pose(static_cast<std::int64_t>(frame));
      ASSERT_EQ(pose.convention.name, "nyu14");
      for (std::size_t j = 0; j < 14; ++j) {
        const std::size_t index = static_cast<std::size_t>(view) - 1;
        EXPECT_EQ(pose.joints[j].u, fixture_value(index, frame, joints[j], 0));
        EXPECT_EQ(pose.joints[j].v, fixture_value(index, frame, joints[j], 1));
        EXPECT_EQ(pose.joints[j].depth_mm, fixture_value(index, frame, joints[j], 2));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Storage, NyuTruthTest,
                         ::testing::Values(MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB));

TEST(Nyu, JoinsImagesAndLabelsByNumberInAnyThread) {
  const testing::TemporaryFolder folder;
  put_nyu(folder.path());
  fs::remove(folder / "depth_2_0000001.png");  // a set with a gap keeps its numbers
  const NyuSource source(folder.path(), {2});
  ASSERT_EQ(source.size(), 2);
  parallel_for(8, [&](std::int64_t i) {
    const Frame frame = source.read(i % 2);
    EXPECT_EQ(frame.truth->joints[0].u, fixture_value(1, static_cast<std::size_t>(i % 2) + 1, 0, 0));
  });
}

TEST(Nyu, WithoutLabelsThereIsNoTruth) {
  const testing::TemporaryFolder folder;
  put_nyu(folder.path());
  fs::remove(folder / "joint_data.mat");
  const NyuSource source(folder.path(), {});
  EXPECT_FALSE(source.convention());
  EXPECT_FALSE(source.read(0).truth);
}

TEST(Nyu, NamesFileAndFault) {
  const testing::TemporaryFolder folder;
  put_nyu(folder.path());
  const fs::path labels = folder / "joint_data.mat";
  const auto error_of_open = [&] { return error_of([&] { NyuSource(folder.path(), {}).read(2); }); };
  EXPECT_THAT(error_of([&] { NyuSource(folder.path(), {3}); }), HasSubstr("depth_3_"));
  EXPECT_THAT(error_of([&] { NyuSource(folder.path(), {4}); }), HasSubstr("view"));
  put_file(labels, "no Matlab file");
  EXPECT_THAT(error_of_open(), AllOf(HasSubstr("joint_data.mat"), HasSubstr("Matlab")));
  fs::remove(labels);
  write_mat(labels, {3, 3, 36, 3}, MAT_COMPRESSION_NONE, "joint_xyz");
  EXPECT_THAT(error_of_open(), AllOf(HasSubstr("joint_data.mat"), HasSubstr("'joint_uvd'")));
  fs::remove(labels);
  write_mat(labels, {3, 3, 35, 3}, MAT_COMPRESSION_NONE);
  EXPECT_THAT(error_of_open(), AllOf(HasSubstr("joint_data.mat"), HasSubstr("36 x 3")));
  fs::remove(labels);
  write_mat(labels, {3, 3, 36, 3}, MAT_COMPRESSION_NONE, "joint_uvd", MAT_C_INT32);
  EXPECT_THAT(error_of_open(), AllOf(HasSubstr("joint_data.mat"), HasSubstr("doubles")));
  fs::remove(labels);
  write_mat(labels, {3, 2, 36, 3}, MAT_COMPRESSION_NONE);
  EXPECT_THAT(error_of_open(),
              AllOf(HasSubstr("joint_data.mat"), HasSubstr("labels 2 frames, asked for frame 3")));
}

TEST(Nyu, LabelsOfTooManyViewsOrFarAwayAreRefused) {
  const testing::TemporaryFolder folder;
  const fs::path labels = folder / "joint_data.mat";
  write_mat(labels, {65, 1, 36, 3}, MAT_COMPRESSION_NONE);
  EXPECT_THAT(error_of([&] { NyuTruth(labels, 1); }),
              HasSubstr("joint_data.mat: 'joint_uvd' has 65 views of 1 frames, expected at most 64"));
  fs::remove(labels);
  write_mat(labels, {1, 1, 36, 3}, MAT_COMPRESSION_NONE);
  EXPECT_THAT(error_of([&] { NyuTruth(labels, 2); }),
              HasSubstr("joint_data.mat: has 1 views, asked for view 2"));
  std::string bytes = read_text_file(labels);
  const double first = fixture_value(0, 0, 0, 0);
  const double far = 2e9;
  const std::size_t place = bytes.find(std::string(reinterpret_cast<const char*>(&first), sizeof(first)));
  ASSERT_NE(place, std::string::npos);
  std::memcpy(bytes.data() + place, &far, sizeof(far));
  put_file(labels, bytes);
  EXPECT_THAT(error_of([&] { NyuTruth(labels, 1); }),
              HasSubstr("joint_data.mat: 'joint_uvd' holds 2000000000, expected at most 1000000000"));
}

TEST(Nyu, RefusesLabelsCutShortAnywhere) {
  const testing::TemporaryFolder folder;
  const fs::path labels = folder / "joint_data.mat";
  for (const matio_compression compression : {MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB}) {
    write_mat(labels, {3, 20, 36, 3}, compression);
    const auto bytes = fs::file_size(labels);
    for (std::uintmax_t cut = bytes - bytes / 20; cut > 0; cut -= std::min(cut, bytes / 20)) {
      testing::cut_file(labels, cut);
      EXPECT_THAT(error_of([&] { NyuTruth(labels, 1); }), HasSubstr("joint_data.mat"))
          << cut << " of " << bytes;
    }
    fs::remove(labels);
  }
}

TEST(Nyu, RefusesImagesOfAnotherKind) {
  const testing::TemporaryFolder folder;
  put_nyu(folder.path());
  write_png(folder / "depth_1_0000001.png", Image<std::uint16_t>(640, 480, 5));
  EXPECT_THAT(error_of([&] { NyuSource(folder.path(), {}).read(0); }),
              AllOf(HasSubstr("depth_1_0000001.png"), HasSubstr("8 bits")));
  write_png(folder / "depth_1_0000001.png", Image<Rgb>(320, 240));
  EXPECT_THAT(error_of([&] { NyuSource(folder.path(), {}).read(0); }), HasSubstr("320x240"));
}

TEST(Nyu, TheRealFramesTruthLiesOnItsHand) {
  KNUCKLE_REQUIRE_SHARED_DATA(shared);
  const NyuSource source(shared / "real/nyu/test", {});
  ASSERT_EQ(source.size(), 1);
  const Frame frame = source.read(0);
  const std::vector<double> uvd =
      parse_numbers(read_text_file(shared / "real/nyu/test/gt_uvd14.txt"), "truth");
  ASSERT_EQ(uvd.size(), 42u);
  int on_hand = 0;
  for (std::size_t i = 0; i < uvd.size(); i += 3) {
    const float depth =
        frame.depth_mm(static_cast<int>(std::lround(uvd[i])), static_cast<int>(std::lround(uvd[i + 1])));
    if (std::abs(depth - uvd[i + 2]) < 40) ++on_hand;
  }
  EXPECT_GE(on_hand, 10);
}

}  // namespace
}  // namespace knuckle
