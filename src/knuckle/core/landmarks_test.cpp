// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/landmarks.h"

#include <set>

#include "knuckle/core/frame.h"
#include "knuckle/core/pose.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

/// A pose whose joint i lies at (i, 10 i, 100 i).
HandPose counted_pose(const Convention& convention) {
  HandPose pose = HandPose::missing(convention);
  for (int i = 0; i < convention.size(); ++i) pose.joints[i] = {1.0 * i, 10.0 * i, 100.0 * i};
  return pose;
}

class EachConvention : public ::testing::TestWithParam<Convention> {};

TEST_P(EachConvention, HasTheSizeOfItsNameAndNoLandmarkTwice) {
  const Convention convention = GetParam();
  const std::string name(convention.name);
  const int size = std::stoi(name.substr(name.find_first_of("0123456789")));
  EXPECT_EQ(convention.size(), size);
  EXPECT_EQ(std::set(convention.landmarks.begin(), convention.landmarks.end()).size(),
            static_cast<std::size_t>(size));
}

TEST_P(EachConvention, IsFoundByItsName) {
  EXPECT_EQ(convention_from_name(GetParam().name), GetParam());
}

TEST_P(EachConvention, ConvertsToItselfUnchanged) {
  const HandPose pose = counted_pose(GetParam());
  const HandPose same = converted(pose, GetParam());
  for (int i = 0; i < GetParam().size(); ++i) EXPECT_EQ(same.joints[i].u, pose.joints[i].u);
}

TEST_P(EachConvention, SkeletonIsATreeOverAllLandmarks) {
  std::vector<int> parents(GetParam().size(), -1);
  for (const Bone& bone : skeleton_of(GetParam())) {
    EXPECT_EQ(parents[bone.to], -1) << "two bones end at " << name_of(GetParam().landmarks[bone.to]);
    parents[bone.to] = bone.from;
  }
  EXPECT_EQ(std::ranges::count(parents, -1), 1) << "one root";
  for (int i = 0; i < GetParam().size(); ++i) {
    int steps = 0;
    for (int at = i; parents[at] >= 0; at = parents[at]) ASSERT_LT(++steps, GetParam().size()) << "a cycle";
  }
}

TEST_P(EachConvention, RoundTripThroughTheSupersetKeepsWhatItHolds) {
  const HandPose pose = counted_pose(GetParam());
  const HandPose back = converted(converted(pose, superset_convention()), GetParam());
  for (int i = 0; i < GetParam().size(); ++i) {
    const bool is_shared = superset_convention().index_of(GetParam().landmarks[i]) >= 0;
    EXPECT_EQ(back.joints[i].is_missing(), !is_shared);
    if (is_shared) {
      EXPECT_EQ(back.joints[i].depth_mm, pose.joints[i].depth_mm);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, EachConvention, ::testing::ValuesIn(conventions().begin(), conventions().end()),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(LandmarksTest, NamesAreUnique) {
  std::set<std::string_view> names;
  for (int i = 0; i <= static_cast<int>(Landmark::nyu_wrist_2); ++i)
    names.insert(name_of(static_cast<Landmark>(i)));
  EXPECT_EQ(names.size(), static_cast<std::size_t>(Landmark::nyu_wrist_2) + 1);
  EXPECT_EQ(name_of(Landmark::index_pip), "index_pip");
  EXPECT_EQ(name_of(Landmark::nyu_wrist_2), "nyu_wrist_2");
}

TEST(LandmarksTest, AnUnknownConventionListsTheKnownOnes) {
  const std::string message = error_of([] { convention_from_name("icg21"); });
  EXPECT_THAT(message, HasSubstr("'icg21'"));
  EXPECT_THAT(message, HasSubstr("icg20"));
  EXPECT_THAT(message, HasSubstr("nyu14"));
}

TEST(LandmarksTest, MappingTellsWhatIsSharedDroppedAndMissing) {
  const ConventionMapping mapping =
      map_convention(convention_from_name("mediapipe21"), convention_from_name("icg20"));
  EXPECT_EQ(mapping.shared.size(), 19u);
  EXPECT_THAT(mapping.dropped, ::testing::ElementsAre(Landmark::wrist, Landmark::thumb_cmc));
  EXPECT_THAT(mapping.missing, ::testing::ElementsAre(Landmark::palm));
}

std::vector<std::string> names_in(std::string_view convention) {
  std::vector<std::string> names;
  for (const Landmark landmark : convention_from_name(convention).landmarks)
    names.emplace_back(name_of(landmark));
  return names;
}

// The whole orders, as the data sets and MediaPipe publish them.
TEST(LandmarksTest, EveryConventionHasItsPublishedOrder) {
  using ::testing::ElementsAre;
  EXPECT_THAT(names_in("mediapipe21"),
              ElementsAre("wrist", "thumb_cmc", "thumb_mcp", "thumb_ip", "thumb_tip", "index_mcp",
                          "index_pip", "index_dip", "index_tip", "middle_mcp", "middle_pip", "middle_dip",
                          "middle_tip", "ring_mcp", "ring_pip", "ring_dip", "ring_tip", "little_mcp",
                          "little_pip", "little_dip", "little_tip"));
  EXPECT_THAT(names_in("knuckle22"),
              ElementsAre("wrist", "palm", "thumb_cmc", "thumb_mcp", "thumb_ip", "thumb_tip", "index_mcp",
                          "index_pip", "index_dip", "index_tip", "middle_mcp", "middle_pip", "middle_dip",
                          "middle_tip", "ring_mcp", "ring_pip", "ring_dip", "ring_tip", "little_mcp",
                          "little_pip", "little_dip", "little_tip"));
  EXPECT_THAT(
      names_in("icg20"),
      ElementsAre("palm", "thumb_mcp", "thumb_ip", "thumb_tip", "index_mcp", "index_pip", "index_dip",
                  "index_tip", "middle_mcp", "middle_pip", "middle_dip", "middle_tip", "ring_mcp", "ring_pip",
                  "ring_dip", "ring_tip", "little_mcp", "little_pip", "little_dip", "little_tip"));
  EXPECT_THAT(names_in("msra21"),
              ElementsAre("wrist", "index_mcp", "index_pip", "index_dip", "index_tip", "middle_mcp",
                          "middle_pip", "middle_dip", "middle_tip", "ring_mcp", "ring_pip", "ring_dip",
                          "ring_tip", "little_mcp", "little_pip", "little_dip", "little_tip", "thumb_cmc",
                          "thumb_mcp", "thumb_ip", "thumb_tip"));
  EXPECT_THAT(names_in("hands21"),
              ElementsAre("wrist", "thumb_cmc", "index_mcp", "middle_mcp", "ring_mcp", "little_mcp",
                          "thumb_mcp", "thumb_ip", "thumb_tip", "index_pip", "index_dip", "index_tip",
                          "middle_pip", "middle_dip", "middle_tip", "ring_pip", "ring_dip", "ring_tip",
                          "little_pip", "little_dip", "little_tip"));
  EXPECT_THAT(names_in("icvl16"),
              ElementsAre("palm", "icvl_thumb_root", "icvl_thumb_mid", "icvl_thumb_tip", "icvl_index_root",
                          "icvl_index_mid", "icvl_index_tip", "icvl_middle_root", "icvl_middle_mid",
                          "icvl_middle_tip", "icvl_ring_root", "icvl_ring_mid", "icvl_ring_tip",
                          "icvl_little_root", "icvl_little_mid", "icvl_little_tip"));
  EXPECT_THAT(names_in("nyu14"),
              ElementsAre("little_tip", "nyu_little_base", "ring_tip", "nyu_ring_base", "middle_tip",
                          "nyu_middle_base", "index_tip", "nyu_index_base", "thumb_tip", "nyu_thumb_mid",
                          "nyu_thumb_base", "nyu_wrist_1", "nyu_wrist_2", "palm"));
}

TEST(LandmarksTest, BonesFollowTheDigits) {
  std::set<std::pair<std::string, std::string>> bones;
  const Convention& nyu = convention_from_name("nyu14");
  for (const Bone& bone : skeleton_of(nyu))
    bones.emplace(name_of(nyu.landmarks[bone.from]), name_of(nyu.landmarks[bone.to]));
  const std::set<std::pair<std::string, std::string>> expected{
      {"palm", "nyu_wrist_1"},           {"palm", "nyu_wrist_2"},
      {"palm", "nyu_thumb_base"},        {"nyu_thumb_base", "nyu_thumb_mid"},
      {"nyu_thumb_mid", "thumb_tip"},    {"palm", "nyu_index_base"},
      {"nyu_index_base", "index_tip"},   {"palm", "nyu_middle_base"},
      {"nyu_middle_base", "middle_tip"}, {"palm", "nyu_ring_base"},
      {"nyu_ring_base", "ring_tip"},     {"palm", "nyu_little_base"},
      {"nyu_little_base", "little_tip"}};
  EXPECT_EQ(bones, expected);
}

TEST(LandmarksTest, PublicOrdersAreThoseOfTheDataSets) {
  const auto at = [](std::string_view convention, int index) {
    return convention_from_name(convention).landmarks[index];
  };
  EXPECT_EQ(at("icg20", 0), Landmark::palm);
  EXPECT_EQ(at("icg20", 1), Landmark::thumb_mcp);
  EXPECT_EQ(at("icg20", 4), Landmark::index_mcp);
  EXPECT_EQ(at("hands21", 5), Landmark::little_mcp);
  EXPECT_EQ(at("hands21", 6), Landmark::thumb_mcp);
  EXPECT_EQ(at("hands21", 9), Landmark::index_pip);
  EXPECT_EQ(at("msra21", 17), Landmark::thumb_cmc);
  EXPECT_EQ(at("nyu14", 8), Landmark::thumb_tip);
  EXPECT_EQ(at("nyu14", 13), Landmark::palm);
}

TEST(PoseTest, ConfidenceFollowsItsJoint) {
  HandPose pose = counted_pose(convention_from_name("hands21"));
  pose.confidence.assign(21, 0.5f);
  pose.confidence[9] = 0.9f;  // index_pip
  const HandPose result = converted(pose, convention_from_name("icg20"));
  EXPECT_EQ(result.confidence[result.convention.index_of(Landmark::index_pip)], 0.9f);
  EXPECT_EQ(result.confidence[result.convention.index_of(Landmark::palm)], 0.0f);
}

TEST(PoseTest, MirrorIsItsOwnInverseAndKeepsMissingJointsMissing) {
  HandPose pose = counted_pose(superset_convention());
  pose.joints[3] = {};
  const HandPose mirror = mirrored(pose, 320);
  EXPECT_EQ(mirror.joints[5].u, 319.0 - 5.0);
  EXPECT_TRUE(mirror.joints[3].is_missing());
  EXPECT_EQ(mirrored(mirror, 320).joints[5].u, pose.joints[5].u);
}

TEST(PoseTest, EveryConfidenceFollowsItsJoint) {
  HandPose pose = counted_pose(convention_from_name("hands21"));
  for (int i = 0; i < 21; ++i) pose.confidence.push_back(0.01f * static_cast<float>(i));
  const HandPose result = converted(pose, convention_from_name("msra21"));
  for (std::size_t i = 0; i < result.joints.size(); ++i)
    EXPECT_FLOAT_EQ(result.confidence[i], static_cast<float>(0.01 * result.joints[i].u)) << i;
}

TEST(PoseTest, TheMeanIsOfTheJointsThatAreKnown) {
  HandPose pose = HandPose::missing(convention_from_name("nyu14"));
  EXPECT_TRUE(mean_joint(pose).is_missing());
  pose.joints[2] = {10.0, 100.0, 500.0};
  pose.joints[3] = {12.0, 40.0, kNaN};  // of a joint without depth nothing counts
  pose.joints[7] = {40.0, 20.0, 620.0};
  pose.joints[9] = {1.0, 0.0, 710.0};
  const ImagePoint mean = mean_joint(pose);
  EXPECT_DOUBLE_EQ(mean.u, 17.0);
  EXPECT_DOUBLE_EQ(mean.v, 40.0);
  EXPECT_DOUBLE_EQ(mean.depth_mm, 610.0);
}

TEST(PoseTest, OnlyAPoseWithoutAnyJointIsMissing) {
  HandPose pose = HandPose::missing(superset_convention());
  EXPECT_TRUE(pose.is_missing());
  pose.joints[4] = {1.0, 2.0, 3.0};
  EXPECT_FALSE(pose.is_missing());
}

}  // namespace
}  // namespace knuckle
