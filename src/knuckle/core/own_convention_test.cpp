// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/own_convention.h"

#include <fstream>
#include <thread>

#include "knuckle/core/error.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using knuckle::testing::error_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class OwnConvention : public ::testing::Test {
 protected:
  const std::filesystem::path& file(const std::string& text) const {
    std::ofstream(path_) << text;
    return path_;
  }
  std::string fault_of(const std::string& text) const {
    return error_of([&] { convention_from_file(file(text)); });
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "lab.toml";
};

TEST_F(OwnConvention, HasTheLandmarksOfItsFileInTheirOrder) {
  const Convention& lab = convention_from_file(
      file("convention = \"own_lab3\"\nlandmarks = [\"thumb_tip\", \"own_knuckle\", \"nyu_wrist_1\"]\n"
           "[own_knuckle]\nbone = \"middle_mcp\"\noffset = [0, 0, 0.1]\n"));
  ASSERT_EQ(lab.size(), 3);
  EXPECT_EQ(lab.name, "own_lab3");
  EXPECT_EQ(lab.landmarks[0], Landmark::thumb_tip);
  EXPECT_EQ(name_of(lab.landmarks[1]), "own_knuckle");
  EXPECT_EQ(lab.landmarks[2], Landmark::nyu_wrist_1);
  EXPECT_TRUE(is_own(lab.landmarks[1]));
  EXPECT_EQ(lab.index_of(lab.landmarks[1]), 1);
  // It is known by its name from now on, and the same file again is the same convention.
  EXPECT_EQ(&convention_from_name("own_lab3"), &lab);
  EXPECT_EQ(&convention_from_file(path_), &lab);
  EXPECT_EQ(&convention_from_option(path_.string()), &lab);
  EXPECT_EQ(convention_from_option("icvl16").size(), 16);
}

TEST_F(OwnConvention, IsTheSameAfterItsTextAndBack) {
  EXPECT_EQ(convention_text(convention_from_name("nyu14")), "nyu14");
  EXPECT_EQ(&convention_from_text("nyu14"), &convention_from_name("nyu14"));
  const Convention& lab = register_convention(
      "own_told",
      {Landmark::wrist, own_landmark("own_told_knob", Landmark::index_mcp), Landmark::nyu_wrist_1});
  EXPECT_EQ(convention_text(lab), "own_told: wrist, own_told_knob~index_mcp, nyu_wrist_1");
  EXPECT_EQ(&convention_from_text(convention_text(lab)), &lab);
  EXPECT_EQ(&convention_from_text("own_told"), &lab) << "it is known by now";

  const Convention& other = convention_from_text("own_heard: own_heard_a~palm, thumb_tip");
  ASSERT_EQ(other.size(), 2);
  EXPECT_EQ(name_of(other.landmarks[0]), "own_heard_a");
  EXPECT_EQ(own_landmark_is_near(other.landmarks[0]), Landmark::palm);
  EXPECT_EQ(other.landmarks[1], Landmark::thumb_tip);
}

TEST_F(OwnConvention, ATextThatSaysNoneIsRefused) {
  const auto fault = [](const std::string& text) { return error_of([&] { convention_from_text(text); }); };
  EXPECT_THAT(fault("own_nowhere"), HasSubstr("unknown convention 'own_nowhere'"));
  EXPECT_THAT(fault("own_wrong: wrist, toe"), HasSubstr("'toe' is no landmark"));
  EXPECT_THAT(fault("own_wrong: "), HasSubstr("'' is no landmark"));
  EXPECT_THAT(fault("own_wrong: a~toe"), HasSubstr("'a~toe' is no landmark of one's own"));
  EXPECT_THAT(fault("own_wrong: a~nyu_wrist_1"), HasSubstr("no landmark of one's own"));
  EXPECT_THAT(fault("own_wrong: wrist~palm"), HasSubstr("no landmark of one's own"));
  EXPECT_THAT(fault("own_wrong: A!~palm"), HasSubstr("cannot name a landmark"));
  EXPECT_THAT(fault("own_wrong: wrist, wrist"), HasSubstr("has the landmark 'wrist' twice"));
  EXPECT_THAT(fault("icg20: wrist"), HasSubstr("every data set knows"));
  EXPECT_THAT(fault("No name: wrist"), HasSubstr("cannot name a convention"));
  EXPECT_THAT(fault(": wrist"), HasSubstr("'' cannot name a convention"));
  EXPECT_THAT(fault("1st: wrist"), HasSubstr("'1st' cannot name a convention"));
  EXPECT_THAT(fault(std::string(65, 'a') + ": wrist"), HasSubstr("at most 64"));
  std::string long_text = "own_long: l0~palm";
  for (int i = 1; i <= 1024; ++i) long_text += fmt::format(", l{}~palm", i);
  EXPECT_THAT(fault(long_text), HasSubstr("expected at most 1024"));
}

TEST_F(OwnConvention, IsDrawnByWhatItsLandmarksAreNear) {
  const Landmark knuckle = own_landmark("own_index_knuckle", Landmark::index_pip);
  const Convention& lab =
      register_convention("own_drawn", {Landmark::wrist, Landmark::index_tip, knuckle, Landmark::index_mcp});
  std::vector<std::pair<int, int>> bones;
  for (const Bone& bone : skeleton_of(lab)) bones.emplace_back(bone.from, bone.to);
  EXPECT_THAT(bones, ElementsAre(std::pair(0, 3), std::pair(3, 2), std::pair(2, 1)));
}

TEST_F(OwnConvention, SharesLandmarksOfTheSameName) {
  const Landmark knob = own_landmark("own_shared", Landmark::palm);
  const Convention& a = register_convention("own_shared_a", {Landmark::palm, knob});
  const Convention& b =
      register_convention("own_shared_b", {own_landmark("own_shared", Landmark::palm), Landmark::wrist});
  const ConventionMapping mapping = map_convention(a, b);
  EXPECT_THAT(mapping.source_index, ElementsAre(1, -1));
  EXPECT_THAT(mapping.shared, ElementsAre(knob));
}

TEST_F(OwnConvention, FaultsNameFileAndLine) {
  const std::string head = "convention = \"own_faulty\"\n";
  for (const auto& [text, fault] : std::vector<std::pair<std::string, std::string>>{
           {"landmarks = [\"palm\"]\n", "lab.toml: lacks 'convention'"},
           {head + "landmarks = []\n", "lab.toml:1: convention: the convention 'own_faulty' has no landmark"},
           {head + "landmarks = [\"palm\", \"palm\"]\n", "has the landmark 'palm' twice"},
           {head + "landmarks = [\"mine\"]\n",
            "lab.toml:2: landmarks: names 'mine', which is no landmark of ours"},
           {head + "landmarks = [\"mine\"]\n[mine]\nbone = \"elbow\"\n",
            "lab.toml:4: mine.bone: is none of the 22"},
           {head + "landmarks = [\"mine\"]\n[mine]\nbone = \"nyu_wrist_1\"\n", "is none of the 22"},
           // Landmarks hang on our 22 alone, so none can hang on itself, however far around.
           {head + "landmarks = [\"mine\"]\n[mine]\nbone = \"mine\"\n", "mine.bone: is none of the 22"},
           {head + "landmarks = [\"one\", \"two\"]\n[one]\nbone = \"two\"\n[two]\nbone = \"one\"\n",
            "lab.toml:4: one.bone: is none of the 22"},
           {head + "landmarks = [\"Mine\"]\n[Mine]\nbone = \"palm\"\n", "'Mine' cannot name a landmark"},
           {"convention = \"icvl16\"\nlandmarks = [\"palm\"]\n", "'icvl16' is one that every data set knows"},
           {"convention = \"a b\"\nlandmarks = [\"palm\"]\n", "'a b' cannot name a convention"},
           {"convention = \"lab.toml\"\n", "unknown convention 'lab.toml'"}}) {
    EXPECT_THAT(fault_of(text), HasSubstr(fault)) << text;
  }
  const std::string once = fault_of(head + "landmarks = [\"mine\"]\n[mine]\nbone = \"elbow\"\n");
  EXPECT_EQ(once.find("lab.toml"), once.rfind("lab.toml")) << once;
  EXPECT_THAT(error_of([&] { convention_from_option("/nowhere/lab.toml"); }), HasSubstr("/nowhere/lab.toml"));
}

TEST_F(OwnConvention, ADocumentNamesItOrItsFile) {
  const Convention& lab = convention_from_file(file("convention = \"own_keyed\"\nlandmarks = [\"palm\"]\n"));
  std::ofstream(folder_ / "good.toml") << "convention = \"lab.toml\"\n";
  std::ofstream(folder_ / "bad.toml") << "\nconvention = \"own_nobodys\"\n";
  const OptionTable good = OptionTable::load(folder_ / "good.toml");
  EXPECT_EQ(&convention_from_key(good, "convention", "icg20"), &lab);
  EXPECT_EQ(convention_from_key(good, "other", "icg20").name, "icg20");
  EXPECT_THAT(
      error_of([&] { convention_from_key(OptionTable::load(folder_ / "bad.toml"), "convention", "icg20"); }),
      ::testing::AllOf(HasSubstr("bad.toml:2"), HasSubstr("unknown convention 'own_nobodys'")));
}

TEST_F(OwnConvention, DataNameAFileInTheirFolderAlone) {
  const Convention& lab = convention_from_file(file("convention = \"own_beside\"\nlandmarks = [\"palm\"]\n"));
  EXPECT_EQ(&convention_in_folder("lab.toml", folder_.path()), &lab);
  EXPECT_EQ(convention_in_folder("nyu14", folder_.path()).size(), 14);
  for (const char* const elsewhere : {"../lab.toml", "sub/lab.toml", "/lab.toml"}) {
    EXPECT_THAT(error_of([&] { convention_in_folder(elsewhere, folder_.path()); }),
                HasSubstr("expected the name of a file in the same folder"));
  }
}

TEST_F(OwnConvention, OneThatNobodyToldIsUnknown) {
  EXPECT_THAT(error_of([] { (void)registered_convention("nobodys"); }),
              HasSubstr("unknown convention 'nobodys'"));
}

TEST_F(OwnConvention, ANameKeepsItsMeaning) {
  register_convention("own_kept", {Landmark::palm});
  EXPECT_THAT(error_of([] { register_convention("own_kept", {Landmark::wrist}); }),
              HasSubstr("'own_kept' was told before with other landmarks"));
  std::string names = "landmarks = [";
  for (int i = 0; i < 1025; ++i) names += "\"many_" + std::to_string(i) + "\", ";
  names += "]\n";
  for (int i = 0; i < 1025; ++i) names += "[many_" + std::to_string(i) + "]\nbone = \"palm\"\n";
  EXPECT_THAT(fault_of("convention = \"own_many\"\n" + names), HasSubstr("expected at most 1024"));
}

TEST_F(OwnConvention, OneThatNobodyHasToldIsUnknown) {
  EXPECT_THAT(error_of([] { registered_convention("own_untold"); }),
              HasSubstr("unknown convention 'own_untold'"));
}

TEST_F(OwnConvention, ManyThreadsMayNameLandmarks) {
  std::vector<std::vector<Landmark>> found(4);
  {
    std::vector<std::jthread> threads;
    for (std::vector<Landmark>& of_thread : found) {
      threads.emplace_back([&of_thread] {
        for (int i = 0; i < 50; ++i) {
          of_thread.push_back(own_landmark("own_thread_" + std::to_string(i), Landmark::palm));
          EXPECT_EQ(name_of(of_thread.back()), "own_thread_" + std::to_string(i));
        }
      });
    }
  }
  for (const std::vector<Landmark>& of_thread : found) EXPECT_EQ(of_thread, found.front());
}

}  // namespace
}  // namespace knuckle
