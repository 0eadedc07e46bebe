// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/poses_file.h"

#include <cmath>

#include <fmt/format.h>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using knuckle::testing::error_of;
using knuckle::testing::TemporaryFolder;
using ::testing::HasSubstr;

const Convention& nyu() {
  return convention_from_name("nyu14");
}

/// A line of `count` values 1, 2, 3, ...
std::string line_of(int count, const std::string& separator = " ") {
  std::string line;
  for (int i = 1; i <= count; ++i) line += (i == 1 ? "" : separator) + std::to_string(i);
  return line;
}

std::vector<HandPose> random_poses(const Convention& convention, int count) {
  Random random(7);
  std::vector<HandPose> poses;
  for (int i = 0; i < count; ++i) {
    HandPose pose = HandPose::missing(convention);
    for (ImagePoint& joint : pose.joints) {
      if (random.uniform() < 0.2) continue;
      joint = {random.uniform(-50.0, 700.0), random.uniform(-50.0, 500.0), random.uniform(100.0, 1500.0)};
    }
    poses.push_back(pose);
  }
  return poses;
}

class PosesFile : public ::testing::Test {
 protected:
  std::filesystem::path file(const std::string& text) const {
    write_text_file(path_, text);
    return path_;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "poses.txt";
};

TEST_F(PosesFile, KeepsPosesOverARoundTripInBothOrigins) {
  const Convention convention = convention_from_name("icg20");
  const std::vector<HandPose> poses = random_poses(convention, 30);
  for (const PixelOrigin origin : {PixelOrigin::centre, PixelOrigin::corner}) {
    write_poses_file(path_, convention, poses, origin);
    const PoseSequence read = read_poses_file(path_, std::nullopt, origin);
    EXPECT_EQ(read.convention, convention);
    ASSERT_EQ(read.poses.size(), poses.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      for (std::size_t j = 0; j < poses[i].joints.size(); ++j) {
        const ImagePoint& wrote = poses[i].joints[j];
        const ImagePoint& got = read.poses[i].joints[j];
        ASSERT_EQ(got.is_missing(), wrote.is_missing());
        if (wrote.is_missing()) continue;
        EXPECT_NEAR(got.u, wrote.u, 5.1e-5);
        EXPECT_NEAR(got.v, wrote.v, 5.1e-5);
        EXPECT_NEAR(got.depth_mm, wrote.depth_mm, 5.1e-5);
      }
    }
  }
}

TEST_F(PosesFile, CountsFromThePixelOriginThatIsAskedFor) {
  HandPose pose = HandPose::missing(nyu());
  pose.joints[0] = {10.0, 20.0, 300.0};
  write_poses_file(path_, nyu(), std::vector{pose}, PixelOrigin::corner);
  EXPECT_THAT(read_text_file(path_), HasSubstr("# convention: nyu14\n10.5000 20.5000 300.0000 nan nan nan"));
  EXPECT_EQ(read_poses_file(path_, std::nullopt, PixelOrigin::corner).poses[0].joints[0].u, 10.0);
}

TEST_F(PosesFile, ToleratesBlanksSeparatorsAndEmptyLinesAtTheEnd) {
  const std::string text = "\xEF\xBB\xBF# made by hand\r\n#convention:  nyu14 \r\n  " + line_of(42, "  \t") +
                           " , \r\n" + line_of(42, ", ") + "\n\n  \n";
  const PoseSequence sequence = read_poses_file(file(text));
  ASSERT_EQ(sequence.poses.size(), 2u);
  for (const HandPose& pose : sequence.poses) {
    EXPECT_EQ(pose.joints[0].u, 1.0);
    EXPECT_EQ(pose.joints[13].depth_mm, 42.0);
  }
}

TEST_F(PosesFile, AJointWithOneUnknownValueIsMissing) {
  std::string text = line_of(42);
  text.replace(text.find("2 "), 1, "NaN");
  const PoseSequence sequence = read_poses_file(file(text), nyu());
  EXPECT_TRUE(std::isnan(sequence.poses[0].joints[0].u));
  EXPECT_TRUE(sequence.poses[0].joints[0].is_missing());
  EXPECT_FALSE(sequence.poses[0].joints[1].is_missing());
}

TEST_F(PosesFile, TheFilesOwnConventionCountsFirst) {
  const std::string text = "# convention: nyu14\n" + line_of(42);
  EXPECT_EQ(read_poses_file(file(text), convention_from_name("icg20")).convention, nyu());
}

TEST_F(PosesFile, ErrorsNameFileLineAndFault) {
  const std::string good = line_of(42) + "\n";
  const auto error = [&](const std::string& text) {
    return error_of([&] { read_poses_file(file(text), nyu()); });
  };
  const std::string name = path_.string();
  EXPECT_THAT(error(good + line_of(41)), AllOf(HasSubstr(name + ":2"), HasSubstr("42"), HasSubstr("41")));
  EXPECT_THAT(error(good + line_of(45)), AllOf(HasSubstr(name + ":2"), HasSubstr("45")));
  EXPECT_THAT(error(good + line_of(41) + " 3x"), AllOf(HasSubstr(name + ":2"), HasSubstr("'3x'")));
  EXPECT_THAT(error(line_of(41) + " inf"), AllOf(HasSubstr(name + ":1"), HasSubstr("range")));
  EXPECT_THAT(error(line_of(41) + " -2e12"), AllOf(HasSubstr(name + ":1"), HasSubstr("range")));
  EXPECT_THAT(error(good + "\n" + good),
              AllOf(HasSubstr(name + ":2"), HasSubstr("has 0 numbers, expected 42")));
  EXPECT_THAT(error("# convention: nyu15\n" + good),
              AllOf(HasSubstr(name + ":1"), HasSubstr("nyu15"), HasSubstr("icvl16")));
  EXPECT_THAT(error(good + "# convention: nyu14\n"), HasSubstr(name + ":2"));
  EXPECT_THAT(error(""), HasSubstr(name));
}

TEST_F(PosesFile, WithoutAnyConventionItSaysWhatToDo) {
  EXPECT_THAT(error_of([&] { read_poses_file(file(line_of(42))); }),
              AllOf(HasSubstr(path_.string() + ":1"), HasSubstr("# convention: NAME")));
}

TEST_F(PosesFile, MissingAndUnwritableFilesAreNamed) {
  EXPECT_THAT(error_of([&] { read_poses_file(folder_ / "none.txt", nyu()); }), HasSubstr("none.txt"));
  const std::filesystem::path nowhere = folder_ / "no_folder" / "poses.txt";
  EXPECT_THAT(error_of([&] { write_poses_file(nowhere, nyu(), random_poses(nyu(), 1)); }),
              HasSubstr("no_folder"));
}

TEST_F(PosesFile, RefusesToWriteAPoseOfAnotherConvention) {
  const std::vector<HandPose> poses = random_poses(convention_from_name("icg20"), 1);
  EXPECT_THAT(error_of([&] { write_poses_file(path_, nyu(), poses); }),
              AllOf(HasSubstr(path_.string()), HasSubstr("nyu14"), HasSubstr("icg20")));
  EXPECT_FALSE(std::filesystem::exists(path_));
}

/// A line of x y z [m] in OpenGL's axes of 14 joints 0.5 m away, the k-th k cm to the right and 1 cm up.
std::string line_in_metres() {
  std::string line;
  for (int k = 0; k < 14; ++k) line += fmt::format("{:.2f} 0.01 -0.5 ", 0.01 * k);
  return line + "\n";
}

TEST_F(PosesFile, SaysItselfThatItHoldsPointsInSpace) {
  file("# convention: nyu14\n# format: xyz\n# axes: x,-y,-z\n# unit: m\n" + line_in_metres() +
       line_in_metres());
  const PoseNumbers numbers = read_pose_numbers(path_);
  EXPECT_EQ(numbers.frames(), 2);
  const Projection projection({.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240});
  const PoseSequence poses = poses_from(numbers, std::span(&projection, 1), PixelOrigin::corner);
  ASSERT_EQ(poses.poses.size(), 2u);
  for (int k = 0; k < 14; ++k) {  // wherever pixels are counted from: a point in space lies where it lies
    EXPECT_NEAR(poses.poses[1].joints[k].u, 320.0 + 10.0 * k, 1e-6);
    EXPECT_NEAR(poses.poses[1].joints[k].v, 230.0, 1e-6);
    EXPECT_NEAR(poses.poses[1].joints[k].depth_mm, 500.0, 1e-6);
  }
  EXPECT_THAT(error_of([&] { read_poses_file(path_); }), HasSubstr("holds x y z, which need a camera"));
  const std::vector<Projection> three(3, projection);
  EXPECT_THAT(error_of([&] { poses_from(numbers, three); }),
              HasSubstr("2 frames predicted, but there are 3"));
}

TEST_F(PosesFile, WhatItSaysItselfCountsMoreThanAnOption) {
  file("# format: uvd\n" + line_of(42) + "\n");
  const PoseCoordinates xyz{PoseCoordinates::Kind::xyz};
  EXPECT_EQ(read_pose_numbers(path_, nyu(), xyz).coordinates.kind, PoseCoordinates::Kind::uvd);
  file(line_of(42) + "\n");
  EXPECT_EQ(read_pose_numbers(path_, nyu(), xyz).coordinates.kind, PoseCoordinates::Kind::xyz);
}

TEST_F(PosesFile, FaultsInItsHeadAreNamed) {
  for (const auto& [head, fault] : std::vector<std::pair<std::string, std::string>>{
           {"# format: xy", "poses.txt:1: unknown format of poses 'xy'"},
           {"# axes: x,y", "poses.txt:1: axes 'x,y'"},
           {"#\n# unit: inch", "poses.txt:2: unknown unit 'inch'"},
           {"# axes: x,-y,-z", "axes are told of x y z, but its format is u v d"}}) {
    file(head + "\n" + line_of(42) + "\n");
    EXPECT_THAT(error_of([&] { read_pose_numbers(path_, nyu()); }), HasSubstr(fault));
  }
  file(line_of(42) + "\n# unit: m\n" + line_of(42) + "\n");
  EXPECT_THAT(error_of([&] { read_pose_numbers(path_, nyu()); }),
              HasSubstr("must stand before the first one"));
}

TEST_F(PosesFile, IsReadNoFurtherThanToItsFault) {
  file("# convention: nyu14\n1 2\n" + std::string(std::size_t{2} << 20, '1'));
  EXPECT_THAT(error_of([&] { read_poses_file(path_, {}, PixelOrigin::centre); }),
              HasSubstr("poses.txt:2: has 2 numbers, expected 42"));
}

TEST_F(PosesFile, BlankLinesMayFollowTheLastPoseAlone) {
  const std::string line = line_of(42) + "\n";
  EXPECT_EQ(read_poses_file(file(line + line + "\n \n\n"), nyu(), PixelOrigin::centre).poses.size(), 2);
  EXPECT_THAT(error_of([&] { read_poses_file(file(line + "\n\n" + line), nyu(), PixelOrigin::centre); }),
              HasSubstr("poses.txt:2: has 0 numbers, expected 42"));
}

}  // namespace
}  // namespace knuckle
