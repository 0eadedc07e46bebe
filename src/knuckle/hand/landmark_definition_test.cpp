// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/landmark_definition.h"

#include <array>
#include <fstream>
#include <numbers>

#include <Eigen/Geometry>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/hand/landmark_points.h"
#include "knuckle/hand/skeleton_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

/// A random hand within its limits, anywhere before the camera.
SupersetPoints random_hand(Random& random) {
  const HandSkeleton& adult = adult_skeleton();
  const HandAngles angles = testing::random_angles(adult.limits, random);
  const Eigen::Vector3d axis =
      Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
  RigidTransform pose = RigidTransform::Identity();
  pose.linear() = Eigen::AngleAxisd(random.uniform(-3.0, 3.0), axis).toRotationMatrix();
  pose.translation() = Point3(random.uniform(-200, 200), random.uniform(-200, 200), random.uniform(300, 900));
  return landmarks(adult, angles, pose);
}

LandmarkDefinition random_definition(const Convention& convention, Random& random) {
  LandmarkDefinition definition = LandmarkDefinition::plain(convention);
  const auto offset = [&]() -> Eigen::Vector3d {
    return {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)};
  };
  for (DefinedLandmark& landmark : definition.landmarks) {
    landmark.offset = offset();
    if (landmark.bone != Landmark::wrist) landmark.bent = offset();
  }
  return definition;
}

SupersetPoints moved_hand(const SupersetPoints& hand, const Eigen::Matrix3d& matrix, const Point3& shift) {
  SupersetPoints result = hand;
  for (Point3& point : result) point = matrix * point + shift;
  return result;
}

TEST(BoneAxesTest, AreOrthonormalAndPointAsSaid) {
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const SupersetPoints hand = random_hand(random);
    for (const Landmark landmark : superset_convention().landmarks) {
      const auto axes = bone_axes(hand, HandSide::right, landmark);
      ASSERT_TRUE(axes) << name_of(landmark);
      EXPECT_LT((axes->transpose() * *axes - Eigen::Matrix3d::Identity()).norm(), 1e-12);
      EXPECT_GT(axes->determinant(), 0.0);
    }
  }
  // The straight hand's axes are named in HandSkeleton: x to the thumb's side, y to the fingers, z out of the
  // palm.
  const auto straight = landmarks(adult_skeleton(), HandAngles{}, RigidTransform::Identity());
  for (const Landmark landmark :
       {Landmark::wrist, Landmark::middle_mcp, Landmark::middle_pip, Landmark::middle_tip}) {
    const auto axes = bone_axes(straight, HandSide::right, landmark);
    EXPECT_GT(axes->col(0).y(), 0.98) << name_of(landmark);
    EXPECT_GT(axes->col(1).x(), 0.98) << name_of(landmark);
    EXPECT_LT(axes->col(2).z(), -0.98) << name_of(landmark);
  }
}

TEST(BoneAxesTest, AreNothingWhereTheHandIsNotKnownOrFlatAsALine) {
  Random random(2);
  SupersetPoints hand = random_hand(random);
  hand[static_cast<std::size_t>(Landmark::ring_dip)] = Point3::Constant(kNaN);
  EXPECT_FALSE(bone_axes(hand, HandSide::right, Landmark::ring_pip));
  EXPECT_FALSE(bone_axes(hand, HandSide::right, Landmark::ring_dip));
  EXPECT_TRUE(bone_axes(hand, HandSide::right, Landmark::ring_mcp));
  hand[static_cast<std::size_t>(Landmark::little_mcp)] = Point3::Constant(kNaN);
  EXPECT_FALSE(bone_axes(hand, HandSide::right, Landmark::index_tip));
  SupersetPoints line;
  for (std::size_t i = 0; i < line.size(); ++i) line[i] = {0, 10.0 * static_cast<double>(i), 500};
  EXPECT_FALSE(bone_axes(line, HandSide::right, Landmark::wrist));
  SupersetPoints point;
  point.fill({1, 2, 3});
  EXPECT_FALSE(bone_axes(point, HandSide::right, Landmark::wrist));
}

std::vector<Landmark> bones_of(const char* convention) {
  std::vector<Landmark> bones;
  for (const DefinedLandmark& landmark :
       LandmarkDefinition::plain(convention_from_name(convention)).landmarks)
    bones.push_back(landmark.bone);
  return bones;
}

TEST(LandmarkDefinitionTest, SetsWithLandmarksOfTheirOwnHaveThemOnTheNearestBones) {
  using enum Landmark;
  EXPECT_EQ(bones_of("icvl16"), (std::vector{palm, thumb_cmc, thumb_mcp, thumb_ip, index_mcp, index_pip,
                                             index_dip, middle_mcp, middle_pip, middle_dip, ring_mcp,
                                             ring_pip, ring_dip, little_mcp, little_pip, little_dip}));
  EXPECT_EQ(bones_of("nyu14"),
            (std::vector{little_tip, little_mcp, ring_tip, ring_mcp, middle_tip, middle_mcp, index_tip,
                         index_mcp, thumb_tip, thumb_ip, thumb_mcp, wrist, wrist, palm}));
  const auto superset = superset_convention().landmarks;
  EXPECT_EQ(bones_of("knuckle22"), std::vector<Landmark>(superset.begin(), superset.end()));
}

TEST(LandmarkDefinitionTest, FollowsMotionSizeAndMirrors) {
  Random random(3);
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  mirror(0, 0) = -1.0;
  for (const Convention& convention : conventions()) {
    const SupersetPoints hand = random_hand(random);
    const LandmarkDefinition definition = random_definition(convention, random);
    const std::vector<Point3> points = definition.on(hand, HandSide::right);
    ASSERT_EQ(std::ssize(points), convention.size());
    const Eigen::Matrix3d turn =
        1.7 * Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    const Point3 shift(10, -20, 400);
    const auto turned = definition.on(moved_hand(hand, turn, shift), HandSide::right);
    const auto left = definition.on(moved_hand(hand, mirror, Point3::Zero()), HandSide::left);
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_LT((turned[i] - (turn * points[i] + shift)).norm(), 1e-9);
      EXPECT_LT((left[i] - mirror * points[i]).norm(), 1e-9);
    }
  }
}

TEST(LandmarkDefinitionTest, OffsetsArePalmLengthsAlongTheBone) {
  const auto hand = landmarks(adult_skeleton(), HandAngles{}, RigidTransform::Identity());
  LandmarkDefinition definition = LandmarkDefinition::plain(convention_from_name("icg20"));
  const int index = definition.convention.index_of(Landmark::index_pip);
  definition.landmarks[static_cast<std::size_t>(index)].offset = {0.1, 0.0, 0.0};
  const auto points = definition.on(hand, HandSide::right);
  const Point3& from = hand[static_cast<std::size_t>(Landmark::index_pip)];
  const Point3& to = hand[static_cast<std::size_t>(Landmark::index_dip)];
  const Point3 expected = from + 0.1 * palm_length(hand) * (to - from).normalized();
  EXPECT_LT((points[static_cast<std::size_t>(index)] - expected).norm(), 1e-9);
  const int other = definition.convention.index_of(Landmark::ring_dip);
  EXPECT_EQ(points[static_cast<std::size_t>(other)], hand[static_cast<std::size_t>(Landmark::ring_dip)]);
}

TEST(LandmarkDefinitionTest, AreReadAsTheyWereWritten) {
  const TemporaryFolder folder;
  Random random(4);
  for (const Convention& convention : conventions()) {
    const LandmarkDefinition written = random_definition(convention, random);
    const auto path = folder / (std::string(convention.name) + ".toml");
    std::ofstream(path) << written.as_toml();
    const LandmarkDefinition read = LandmarkDefinition::load(path);
    EXPECT_EQ(read.convention, convention);
    ASSERT_EQ(read.landmarks.size(), written.landmarks.size());
    for (std::size_t i = 0; i < read.landmarks.size(); ++i) {
      EXPECT_EQ(read.landmarks[i].bone, written.landmarks[i].bone);
      EXPECT_LT((read.landmarks[i].offset - written.landmarks[i].offset).norm(), 1e-5);
      ASSERT_EQ(read.landmarks[i].bent.has_value(), written.landmarks[i].bent.has_value());
      const Eigen::Vector3d none = Eigen::Vector3d::Zero();
      EXPECT_LT((read.landmarks[i].bent.value_or(none) - written.landmarks[i].bent.value_or(none)).norm(),
                1e-5);
    }
  }
}

TEST(LandmarkDefinitionTest, ALandmarkMayLieOnTheWayToAnother) {
  Random random(9);
  LandmarkDefinition definition = LandmarkDefinition::plain(convention_from_name("icvl16"));
  const int root = definition.convention.index_of(Landmark::icvl_ring_root);
  definition.landmarks[root] = {Landmark::ring_mcp, {0.0, 0.0, 0.1}, Landmark::ring_pip, 0.25};
  for (int i = 0; i < 10; ++i) {
    const SupersetPoints hand = random_hand(random);
    const Point3& mcp = hand[static_cast<std::size_t>(Landmark::ring_mcp)];
    const Point3& pip = hand[static_cast<std::size_t>(Landmark::ring_pip)];
    const auto axes = bone_axes(hand, HandSide::right, Landmark::ring_mcp);
    const Point3 expected = 0.75 * mcp + 0.25 * pip + 0.1 * palm_length(hand) * axes->col(2);
    EXPECT_LT((definition.on(hand, HandSide::right)[root] - expected).norm(), 1e-9);
  }
}

TEST(LandmarkDefinitionTest, OfAConventionOfOnesOwnIsReadAndWritten) {
  const TemporaryFolder folder;
  std::ofstream(folder / "lab.toml")
      << "format = \"knuckle-landmarks\"\nversion = 1\nconvention = \"hand_lab\"\n"
         "landmarks = [\"wrist\", \"hand_lab_middle\"]\n[hand_lab_middle]\n"
         "bone = \"middle_mcp\"\ntowards = \"middle_pip\"\nshare = 0.5\n";
  const LandmarkDefinition definition = LandmarkDefinition::load(folder / "lab.toml");
  Random random(4);
  const SupersetPoints hand = random_hand(random);
  const std::vector<Point3> points = definition.on(hand, HandSide::left);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0], hand[0]);
  const Point3 middle = (hand[static_cast<std::size_t>(Landmark::middle_mcp)] +
                         hand[static_cast<std::size_t>(Landmark::middle_pip)]) /
                        2;
  EXPECT_LT((points[1] - middle).norm(), 1e-9);
  std::ofstream(folder / "again.toml") << definition.as_toml();
  const LandmarkDefinition again = LandmarkDefinition::load(folder / "again.toml");
  EXPECT_EQ(again.on(hand, HandSide::left), points);
  EXPECT_EQ(again.convention, definition.convention);
}

TEST(LandmarkDefinitionTest, ThoseThatAreShippedCoverTheirConventions) {
  Random random(6);
  const SupersetPoints hand = random_hand(random);
  for (const char* name : {"icg20", "icvl16", "mediapipe21", "nyu14"}) {
    const LandmarkDefinition definition =
        LandmarkDefinition::load(testing::project_folder() / "landmarks" / (std::string(name) + ".toml"));
    EXPECT_EQ(definition.convention.name, name);
    for (const Point3& point : definition.on(hand, HandSide::right)) EXPECT_TRUE(point.allFinite());
  }
  // The two of NYU's wrist are 29 mm apart on a hand whose palm is 93 mm long, at the end of the forearm.
  const LandmarkDefinition nyu = LandmarkDefinition::load(testing::project_folder() / "landmarks/nyu14.toml");
  const SupersetPoints adult = landmarks(adult_skeleton(), HandAngles{}, RigidTransform::Identity());
  const std::vector<Point3> points = nyu.on(adult, HandSide::right);
  const Point3& first = points[nyu.convention.index_of(Landmark::nyu_wrist_1)];
  const Point3& second = points[nyu.convention.index_of(Landmark::nyu_wrist_2)];
  EXPECT_NEAR((first - second).norm(), 0.31 * palm_length(adult), 1e-6);
  EXPECT_GT(second.x(), first.x());  // x points to the thumb's side
  EXPECT_LT(first.y(), adult[0].y());
}

/// The bones of a digit, from its first joint outwards, and the way there from the wrist [mm].
struct DigitLengths {
  double from_wrist;
  std::array<double, 3> bones;
};

// MANO's mean hand, thumb to little.
constexpr std::array<DigitLengths, 5> kManoDigits = {{{38.6, {30.8, 27.1, 34.7}},
                                                      {90.6, {33.0, 22.2, 23.6}},
                                                      {94.7, {31.7, 23.3, 26.5}},
                                                      {86.1, {28.8, 24.8, 24.4}},
                                                      {81.8, {21.1, 18.9, 19.1}}}};

TEST(LandmarkDefinitionTest, ThatOfMediaPipeHasTheProportionsOfManosMeanHand) {
  const auto definition = LandmarkDefinition::load(testing::project_folder() / "landmarks/mediapipe21.toml");
  const SupersetPoints adult = landmarks(adult_skeleton(), HandAngles{}, RigidTransform::Identity());
  const std::vector<Point3> points = definition.on(adult, HandSide::right);
  const auto point = [&](int digit, int joint) {
    return points[static_cast<std::size_t>(definition.convention.index_of(landmark_of_digit(digit, joint)))];
  };
  // MANO's mean hand spreads its fingers, so between our straight ones and its MCP joints lies more than its
  // first bones, most at the little finger.
  constexpr double kScale = 1.067;
  for (int digit = 0; digit < 5; ++digit) {
    const DigitLengths& published = kManoDigits[static_cast<std::size_t>(digit)];
    EXPECT_NEAR((point(digit, 0) - points[0]).norm(), kScale * published.from_wrist, 1.0) << digit;
    for (int bone = 1; bone < 3; ++bone) {
      EXPECT_NEAR((point(digit, bone + 1) - point(digit, bone)).norm(),
                  kScale * published.bones[static_cast<std::size_t>(bone)], 0.5)
          << digit << bone;
    }
    if (digit == 0) continue;
    const double first = (point(digit, 1) - point(digit, 0)).norm();
    EXPECT_NEAR(first, kScale * published.bones[0], digit == 4 ? 9.0 : 4.5) << digit;
    const Landmark mcp = landmark_of_digit(digit, 0);
    EXPECT_GT((point(digit, 0) - adult[static_cast<std::size_t>(mcp)]).y(), 4.0) << "farther out";
  }
}

TEST(LandmarkDefinitionTest, ThatOfIcgHasTheJointsOfAnatomyAndTheTipsOfTheSkin) {
  const auto definition = LandmarkDefinition::load(testing::project_folder() / "landmarks/icg20.toml");
  Random random(8);
  const SupersetPoints hand = random_hand(random);
  const std::vector<Point3> points = definition.on(hand, HandSide::right);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Landmark landmark = definition.convention.landmarks[i];
    const double moved = (points[i] - hand[static_cast<std::size_t>(landmark)]).norm();
    const bool is_tip = std::string(name_of(landmark)).ends_with("_tip");
    EXPECT_NEAR(moved, is_tip ? 2.0 : 0.0, is_tip ? 1.0 : 0.0) << name_of(landmark);
  }
}

TEST(LandmarkDefinitionTest, ShippedOnesAreFoundByName) {
  EXPECT_EQ(shipped_definition(convention_from_name("mediapipe21"))->convention.name, "mediapipe21");
  EXPECT_FALSE(shipped_definition(superset_convention()));
  EXPECT_EQ(definition_file("mediapipe21").filename(), "mediapipe21.toml");
  EXPECT_TRUE(std::filesystem::exists(definition_file("mediapipe21")));
  EXPECT_EQ(definition_file("no_such"), "no_such");
  const TemporaryFolder folder;
  std::ofstream(folder / "icg20") << "mine";
  EXPECT_EQ(definition_file(folder / "icg20"), folder / "icg20");
}

TEST(LandmarkDefinitionTest, AnOffsetMayChangeWithTheBend) {
  const HandSkeleton& adult = adult_skeleton();
  LandmarkDefinition definition = LandmarkDefinition::plain(convention_from_name("mediapipe21"));
  const auto index = static_cast<std::size_t>(definition.convention.index_of(Landmark::middle_mcp));
  definition.landmarks[index].offset = {0.1, 0.0, 0.0};
  definition.landmarks[index].bent = Eigen::Vector3d(0.0, 0.0, 0.3);
  HandAngles angles;
  const SupersetPoints straight = landmarks(adult, angles, RigidTransform::Identity());
  EXPECT_NEAR(finger_bend(straight, Landmark::middle_tip), 0.0, 1e-6);
  EXPECT_NEAR((definition.on(straight, HandSide::right)[index] - straight[10]).norm(),
              0.1 * palm_length(straight), 1e-6);
  angles[HandAngle::middle_pip] = 0.5 * std::numbers::pi;
  const SupersetPoints bent = landmarks(adult, angles, RigidTransform::Identity());
  EXPECT_NEAR(finger_bend(bent, Landmark::middle_mcp), 0.5, 1e-6);
  EXPECT_NEAR(finger_bend(bent, Landmark::wrist), 0.5, 1e-6) << "the wrist follows the middle finger";
  EXPECT_NEAR(finger_bend(bent, Landmark::index_pip), 0.0, 1e-6);
  const auto axes = bone_axes(bent, HandSide::right, Landmark::middle_mcp);
  const Point3 expected = bent[10] + palm_length(bent) * (*axes * Eigen::Vector3d(0.05, 0.0, 0.15));
  EXPECT_LT((definition.on(bent, HandSide::right)[index] - expected).norm(), 1e-9);
}

TEST(LandmarkDefinitionTest, BadFilesAreRefusedByName) {
  const TemporaryFolder folder;
  const std::string good = LandmarkDefinition::plain(convention_from_name("icg20")).as_toml();
  const auto error_with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const auto path = folder / "bad.toml";
    std::ofstream(path) << text;
    return error_of([&] { LandmarkDefinition::load(path); });
  };
  EXPECT_THAT(error_with("bone = \"palm\"", "bone = \"tail\""), HasSubstr("bad.toml"));
  EXPECT_THAT(error_with("bone = \"palm\"", "bone = \"tail\""), HasSubstr("tail"));
  EXPECT_THAT(error_with("[0.00000, 0.00000, 0.00000]", "[0.0, nan, 0.0]"), HasSubstr("offset"));
  EXPECT_THAT(error_with("[0.00000, 0.00000, 0.00000]", "[0.0, 3.0, 0.0]"), HasSubstr("offset"));
  EXPECT_THAT(error_with("[0.00000, 0.00000, 0.00000]", "[0.0, 0.0]"), HasSubstr("offset"));
  EXPECT_THAT(error_with("bone = \"palm\"", "bone = \"palm\"\nbent = [0.0, 3.0, 0.0]"), HasSubstr("bent"));
  EXPECT_THAT(error_with("icg20", "icg99"), HasSubstr("is \"icg99\"; `knuckle info` lists"));
  EXPECT_THAT(error_with("[index_tip]", "[index_top]"), HasSubstr("lacks the table [index_tip]"));
  EXPECT_THAT(error_with("bone = \"palm\"\n", ""), HasSubstr("'bone'"));
  EXPECT_THAT(error_with("version = 1", "version = 2"), HasSubstr("version"));
  EXPECT_THAT(error_with("format = \"knuckle-landmarks\"\n", ""), HasSubstr("'format'"));
  EXPECT_THAT(error_with("bone = \"palm\"", "bone = \"palm\"\nscale = 2"), HasSubstr("scale"));
  EXPECT_THAT(error_with("bone = \"palm\"", "bone = \"palm\"\nshare = 0.5"), HasSubstr("lacks 'towards'"));
  EXPECT_THAT(error_with("bone = \"palm\"", "bone = \"palm\"\ntowards = \"wrist\""),
              HasSubstr("lacks 'share'"));
  EXPECT_THAT(error_with("bone = \"palm\"", "bone = \"palm\"\ntowards = \"wrist\"\nshare = 9"),
              HasSubstr("share"));
}

TEST(LandmarkDefinitionTest, NoLandmarkLiesOnTheWayToItself) {
  const TemporaryFolder folder;
  const auto path = folder / "own_way.toml";
  std::ofstream(path) << "format = \"knuckle-landmarks\"\nversion = 1\nconvention = \"own_way\"\n"
                         "landmarks = [\"one\", \"two\"]\n"
                         "[one]\nbone = \"palm\"\ntowards = \"two\"\nshare = 0.5\n"
                         "[two]\nbone = \"palm\"\ntowards = \"one\"\nshare = 0.5\n";
  EXPECT_THAT(error_of([&] { LandmarkDefinition::load(path); }), HasSubstr("own_way.toml:7: one.towards"));
}

}  // namespace
}  // namespace knuckle
