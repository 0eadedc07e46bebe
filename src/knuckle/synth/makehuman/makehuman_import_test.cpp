// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/makehuman/makehuman_import.h"

#include <map>
#include <set>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/body_file.h"
#include "knuckle/hand/skinning.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/synth/makehuman/makehuman_package.h"
#include "knuckle/synth/people/body_shape.h"

namespace knuckle {
namespace {

using ::knuckle::testing::error_of;
using ::knuckle::testing::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// Imports once for all tests; skips where the package is missing.
class MakeHumanImportTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(makehuman_folder() / "public")) {
      GTEST_SKIP() << "MakeHuman's data is not on this machine (scripts/fetch_makehuman.sh)";
    }
    static const Body imported = import_makehuman(makehuman_folder());
    body_ = &imported;
  }

  const Body& body() const { return *body_; }
  ShapedBody person(const PersonShape& shape) const {
    return shaped_body(body(), shape_coefficients(body(), shape));
  }

 private:
  const Body* body_ = nullptr;
};

double length(const ShapedBody& person, Landmark a, Landmark b) {
  return (person.landmarks[static_cast<std::size_t>(a)] - person.landmarks[static_cast<std::size_t>(b)])
      .norm();
}

TEST_F(MakeHumanImportTest, SkinIsClosedAndLooksOutwards) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
  for (const auto& face : body().faces) {
    for (std::size_t k = 0; k < 3; ++k) ++edges[{face[k], face[(k + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    ASSERT_TRUE(edges.contains({edge.second, edge.first})) << "an open edge at vertex " << edge.first;
  }
  const ShapedBody adult = person({});
  double volume_mm3 = 0.0;
  for (const auto& [a, b, c] : body().faces) {
    volume_mm3 += adult.vertices[a].cast<double>().dot(
                      adult.vertices[b].cast<double>().cross(adult.vertices[c].cast<double>())) /
                  6.0;
  }
  EXPECT_GT(volume_mm3, 20e6);  // litres of an adult without legs
  EXPECT_LT(volume_mm3, 60e6);
}

TEST_F(MakeHumanImportTest, SectionsGrowFromTheHand) {
  const Body& whole = body();
  ASSERT_EQ(whole.sections.size(), 3u);
  for (std::size_t i = 0; i < whole.faces.size(); ++i) {
    EXPECT_EQ(whole.is_hand[i], i < static_cast<std::size_t>(whole.sections[0].faces) ? 1 : 0);
  }
  EXPECT_LT(whole.sections[0].vertices, whole.sections[1].vertices);
  EXPECT_EQ(whole.sections[2].faces, std::ssize(whole.faces));
}

TEST_F(MakeHumanImportTest, HandIsWhatLiesBeyondTheWrist) {
  const ShapedBody adult = person({});
  const Eigen::Vector3f wrist = adult.landmarks[static_cast<std::size_t>(Landmark::wrist)];
  const Eigen::Vector3f elbow = adult.joints[body().bone("lowerarm01.R")];
  const Eigen::Vector3f along = (wrist - elbow).normalized();
  double nearest_to_elbow = 1e9;
  for (std::int32_t i = 0; i < body().sections[0].vertices; ++i) {
    nearest_to_elbow = std::min<double>(nearest_to_elbow, (adult.vertices[i] - wrist).dot(along));
  }
  EXPECT_GT(nearest_to_elbow, -20.0);
  EXPECT_LT(nearest_to_elbow, 15.0);
}

TEST_F(MakeHumanImportTest, LandmarksAreBoneHeadsAfterEveryMorph) {
  PersonShape shape;
  shape.gender = 0.9;
  shape.weight = 0.8;
  shape.hand_scale = -0.5;
  shape.finger_length = 0.4;
  const ShapedBody someone = person(shape);
  for (const auto& [landmark, bone] : {std::pair{Landmark::wrist, "wrist.R"},
                                       {Landmark::index_mcp, "finger2-1.R"},
                                       {Landmark::little_pip, "finger5-2.R"},
                                       {Landmark::thumb_cmc, "finger1-1.R"},
                                       {Landmark::ring_dip, "finger4-3.R"}}) {
    const Eigen::Vector3f joint = someone.joints[body().bone(bone)];
    EXPECT_LT((someone.landmarks[static_cast<std::size_t>(landmark)] - joint).norm(), 1e-3f) << bone;
  }
}

TEST_F(MakeHumanImportTest, BoneLengthsAgreeWithAnatomy) {
  // Buchholz et al. 1992, as fractions of hand length; tips lie a tenth of the last bone inside its end.
  const ShapedBody adult = person({});
  const double hand_length = hand_length_mm(adult);
  const auto expect = [&](Landmark a, Landmark b, double fraction) {
    EXPECT_NEAR(length(adult, a, b), fraction * hand_length, 0.025 * hand_length) << name_of(a);
  };
  expect(Landmark::index_mcp, Landmark::index_pip, 0.245);
  expect(Landmark::index_pip, Landmark::index_dip, 0.143);
  expect(Landmark::index_dip, Landmark::index_tip, 0.9 * 0.097);
  expect(Landmark::middle_mcp, Landmark::middle_pip, 0.266);
  expect(Landmark::middle_pip, Landmark::middle_dip, 0.170);
  expect(Landmark::ring_mcp, Landmark::ring_pip, 0.244);
  expect(Landmark::little_mcp, Landmark::little_pip, 0.204);
  expect(Landmark::little_pip, Landmark::little_dip, 0.117);
  expect(Landmark::thumb_cmc, Landmark::thumb_mcp, 0.251);
  expect(Landmark::thumb_mcp, Landmark::thumb_ip, 0.196);
}

TEST_F(MakeHumanImportTest, AdultHandsAreAsLongAsPeoples) {
  PersonShape woman;
  woman.gender = 0.0;
  PersonShape man;
  man.gender = 1.0;
  EXPECT_GT(hand_length_mm(person(woman)), 160.0);
  EXPECT_LT(hand_length_mm(person(woman)), hand_length_mm(person(man)));
  EXPECT_LT(hand_length_mm(person(man)), 210.0);
  for (const double wanted : {165.0, 181.0, 193.3, 205.0}) {
    EXPECT_NEAR(hand_length_mm(person(with_hand_length(body(), woman, wanted))), wanted, 0.01);
  }
}

/// The shortest way from a point to a vertex of the hand.
double distance_to_skin(const ShapedBody& person, Landmark landmark) {
  double nearest = 1e9;
  for (std::int32_t i = 0; i < person.body->sections[0].vertices; ++i) {
    nearest = std::min<double>(
        nearest, (person.vertices[i] - person.landmarks[static_cast<std::size_t>(landmark)]).norm());
  }
  return nearest;
}

TEST_F(MakeHumanImportTest, TipsLieJustUnderTheSkin) {
  const ShapedBody adult = person({});
  for (const Landmark tip : {Landmark::thumb_tip, Landmark::index_tip, Landmark::middle_tip,
                             Landmark::ring_tip, Landmark::little_tip}) {
    EXPECT_LT(distance_to_skin(adult, tip), 6.0) << name_of(tip);
  }
  EXPECT_GT(distance_to_skin(adult, Landmark::palm), 10.0);
}

TEST_F(MakeHumanImportTest, DistancesWithinABoneStayInEveryPose) {
  const ShapedBody adult = person({});
  Random random(5);
  BodyPose pose{std::vector<Eigen::Quaternionf>(body().names.size(), Eigen::Quaternionf::Identity()), {}};
  pose.camera_from_body.setIdentity();
  for (Eigen::Quaternionf& rotation : pose.rotations) {
    Eigen::Vector4f values;
    for (float& value : values) value = static_cast<float>(random.normal());
    rotation = Eigen::Quaternionf(values.normalized());
  }
  const PosedBody posed = posed_body(adult, pose);
  std::map<std::int32_t, std::vector<std::size_t>> rigid;  // vertices that one bone holds alone
  for (std::size_t i = 0; i < body().weights.size(); ++i) {
    if (body().weights[i][0] > 0.9999f) rigid[body().weight_bones[i][0]].push_back(i);
  }
  EXPECT_GT(rigid.size(), 20u);
  for (const auto& [bone, vertices] : rigid) {
    for (std::size_t i = 1; i < vertices.size(); ++i) {
      const float rest = (adult.vertices[vertices[i]] - adult.vertices[vertices[0]]).norm();
      EXPECT_NEAR((posed.vertices[vertices[i]] - posed.vertices[vertices[0]]).norm(), rest,
                  0.05f + 2e-4f * rest);
    }
  }
  EXPECT_NEAR((posed.landmarks[7] - posed.landmarks[6]).norm(),
              length(adult, Landmark::index_mcp, Landmark::index_pip), 1e-2);
}

TEST_F(MakeHumanImportTest, SavedBodyPosesTheSame) {
  const TemporaryFolder folder;
  save_body(body(), folder / "body.model");
  const Body loaded = load_body(folder / "body.model");
  const ShapedBody before = person({});
  const ShapedBody after = shaped_body(loaded, shape_coefficients(loaded, {}));
  EXPECT_EQ(before.vertices, after.vertices);
  EXPECT_EQ(before.landmarks, after.landmarks);
}

TEST_F(MakeHumanImportTest, ImportIsKeptForTheNextTime) {
  const TemporaryFolder folder;
  const std::filesystem::path package = std::filesystem::absolute(makehuman_folder());
  std::filesystem::create_directory_symlink(package / "public", folder / "public");
  std::filesystem::create_directory_symlink(package / "src", folder / "src");
  const Body first = makehuman_body(folder.path());
  std::filesystem::remove(folder / "public");  // from now on only the kept file is there
  const Body second = makehuman_body(folder.path());
  EXPECT_EQ(first.v_template, second.v_template);
  EXPECT_EQ(first.v_template, body().v_template);
  EXPECT_EQ(second.shapedirs.size(), body().shapedirs.size());
}

TEST_F(MakeHumanImportTest, TargetsAreWhereTheirNamesSay) {
  const MakeHumanMesh mesh = read_makehuman_mesh(makehuman_folder());
  const MakeHumanTargets targets(makehuman_folder(), mesh.vertices_mm.size());
  const auto offsets = targets.offsets_mm("armslegs/r-hand-scale-incr");
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (offsets[i].isZero(0.0f)) continue;
    EXPECT_LT(mesh.vertices_mm[i].x(), -300.0f);  // the right hand
  }
  EXPECT_THAT(error_of([&] { targets.offsets_mm("no/such"); }), HasSubstr("no/such"));
}

TEST(MakeHumanPackageTest, MissingAndDamagedPackagesAreNamed) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { import_makehuman(folder.path()); }),
              AllOf(HasSubstr("human_full_size.json"), HasSubstr("fetch_makehuman.sh")));
  const std::filesystem::path models = folder / "public/data/models";
  make_folder(models);
  for (const auto& [text, fault] :
       {std::pair{"{\"vertices\": [1, 2", "no JSON"},
        {"{}", "not MakeHuman's mesh"},
        {"[]", "not MakeHuman's mesh"},
        {"{\"vertices\": [1, 2]}", "'vertices' has 2 numbers"},
        {"{\"vertices\": [1, 2, 3], \"materials\": [], \"faces\": [11, 0, 0, 0, 7, 0, 0, 0, 0, 0]}",
         "a face names vertex 7"},
        {"{\"vertices\": [1, 2, 3], \"materials\": [], \"faces\": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0]}",
         "flags 0"},
        {"{\"vertices\": [], \"materials\": [], \"faces\": []}", "'vertices' has 0 numbers"},
        {"{\"vertices\": [1, 2, 3], \"materials\": [], \"faces\": [11, 0, 0]}", "'faces' has 3 numbers"},
        {"{\"vertices\": [1, 2, 3], \"materials\": [], \"faces\": [11, 0, -1, 0, 0, 0, 0, 0, 0, 0]}",
         "a face names vertex -1"},
        {"{\"vertices\": [1, 2, 3], \"materials\": [], \"faces\": [11, 0, 0, 0, 0, 0, 0, 0, 0, 0]}",
         "a face names material 0"},
        {"{\"vertices\": [1, 2, 3], \"materials\": [], \"faces\": [11, 0, 0, 0, 0, -1, 0, 0, 0, 0]}",
         "a face names material -1"}}) {
    write_text_file(models / "human_full_size.json", text);
    EXPECT_THAT(error_of([&] { import_makehuman(folder.path()); }),
                AllOf(HasSubstr("human_full_size.json"), HasSubstr(fault)));
  }
}

TEST(MakeHumanPackageTest, BonesWeightsAndJointsThatDoNotFitAreNamed) {
  const TemporaryFolder folder;
  const std::filesystem::path models = folder / "public/data/models";
  make_folder(models);
  const auto write = [&](const std::string& bones, const std::string& weights, const std::string& cubes) {
    write_text_file(models / "human_full_size.json",
                    R"({"vertices": [1, 2, 3], "materials": [], "faces": [], "bones": )" + bones + ", " +
                        weights + R"(, "metadata": {"joint_pos_idxs": )" + cubes + "}}");
  };
  const auto fault_with = [&](const std::string& bones, const std::string& weights,
                              const std::string& cubes) {
    write(bones, weights, cubes);
    return error_of([&] { read_makehuman_mesh(folder.path()); });
  };
  const std::string one_bone = R"([{"name": "a____head", "parent": -1}])";
  const std::string weights =
      R"("influencesPerVertex": 4, "skinWeights": [1, 0, 0, 0], "skinIndices": [0, 0, 0, 0])";
  const std::string cubes = R"({"a": [0]})";
  write(one_bone, weights, cubes);
  EXPECT_NO_THROW(read_makehuman_mesh(folder.path()));
  EXPECT_THAT(fault_with(R"([{"name": "a", "parent": 0}])", weights, cubes),
              HasSubstr("'a' comes before its parent"));
  for (const std::string wrong :
       {R"("influencesPerVertex": 2, "skinWeights": [1, 0, 0, 0], "skinIndices": [0, 0, 0, 0])",
        R"("influencesPerVertex": 4, "skinWeights": [1, 0, 0], "skinIndices": [0, 0, 0, 0])",
        R"("influencesPerVertex": 4, "skinWeights": [1, 0, 0, 0], "skinIndices": [0, 0, 0])"}) {
    EXPECT_THAT(fault_with(one_bone, wrong, cubes), HasSubstr("expected 4 skin weights a vertex"));
  }
  EXPECT_THAT(
      fault_with(one_bone,
                 R"("influencesPerVertex": 4, "skinWeights": [1, 0, 0, 0], "skinIndices": [0, 0, 0, 1])",
                 cubes),
      HasSubstr("a weight names bone 1"));
  EXPECT_THAT(
      fault_with(one_bone,
                 R"("influencesPerVertex": 4, "skinWeights": [1, 0, 0, 0], "skinIndices": [0, -1, 0, 0])",
                 cubes),
      HasSubstr("a weight names bone -1"));
  for (const std::string number : {"1.8e+54", "4294967296", "18446744073709551615", "0.5", "\"0\""}) {
    EXPECT_THAT(fault_with(R"([{"name": "a", "parent": )" + number + "}]", weights, cubes),
                HasSubstr(number + " stands where"))
        << "none is rounded or cut";
  }
  EXPECT_THAT(fault_with(one_bone, weights, R"({"a": 0})"), HasSubstr("are no list"));
  EXPECT_THAT(fault_with(one_bone, weights, R"({"a": []})"), HasSubstr("joint 'a' has no vertices"));
  EXPECT_THAT(fault_with(one_bone, weights, R"({"a": [0, 1]})"), HasSubstr("joint 'a' names vertex 1"));
  EXPECT_THAT(fault_with(one_bone, weights, R"({"a": [-1]})"), HasSubstr("joint 'a' names vertex -1"));
}

/// A package whose mesh is one quad over a hip; it has no targets.
class QuadPackageTest : public ::testing::Test {
 protected:
  QuadPackageTest() {
    make_folder(folder_ / "public/data/models");
    make_folder(folder_ / "public/data/targets");
    make_folder(folder_ / "src/json/targets");
    write_text_file(folder_ / "src/json/targets/target-list.json", R"({"targets": {}})");
    write_text_file(folder_ / "public/data/targets/targets.bin", "");
  }
  std::string fault() const {
    std::string weights;
    std::string bones;
    for (int vertex = 0; vertex < 5; ++vertex) {
      weights += fmt::format("{}{}, 0, 0, 0", vertex == 0 ? "" : ", ", weight_);
      bones += fmt::format("{}0, 0, 0, 0", vertex == 0 ? "" : ", ");
    }
    write_text_file(
        folder_ / "public/data/models/human_full_size.json",
        fmt::format(
            R"({{"vertices": [0, 1, 0, 1, 1, 0, 1, 2, 0, 0, 2, 0, 0, 0, 0], "materials": [{{"DbgName": "body"}}],)"
            R"( "faces": [11, {}, 0, 0, 0, 0, 0], "influencesPerVertex": 4, "skinWeights": [{}],)"
            R"( "skinIndices": [{}], "bones": [{}], "metadata": {{"joint_pos_idxs": {}}}}})",
            quad_, weights, bones, bones_, cubes_));
    return error_of([&] { import_makehuman(folder_.path()); });
  }

  TemporaryFolder folder_;
  std::string quad_ = "0, 1, 2, 3";
  std::string bones_ =
      R"({"name": "upperarm01.R", "parent": -1}, {"name": "wrist.R", "parent": 0}, {"name": "head", "parent": 0})";
  std::string cubes_ = R"({"upperleg01.R____head": [4]})";
  int weight_ = 1;
};

TEST_F(QuadPackageTest, ABoneOrJointThatIsMissingIsNamed) {
  cubes_ = "{}";
  EXPECT_THAT(fault(), HasSubstr("human_full_size.json: has no joint 'upperleg01.R____head'"));
  bones_ = R"({"name": "a", "parent": -1})";
  EXPECT_THAT(fault(), HasSubstr("human_full_size.json: has no bone 'head'"));
}

TEST_F(QuadPackageTest, ARimThatDoesNotCloseIsRefused) {
  quad_ = "0, 1, 2, 2";
  EXPECT_THAT(fault(), HasSubstr("human_full_size.json: the skin has a rim that does not close"));
}

TEST_F(QuadPackageTest, AVertexWithoutWeightsIsNamed) {
  weight_ = 0;
  EXPECT_THAT(fault(), HasSubstr("human_full_size.json: vertex 0 has no weights"));
}

TEST(MakeHumanPackageTest, TargetsOfAnotherSizeAreRefused) {
  const TemporaryFolder folder;
  make_folder(folder / "src/json/targets");
  make_folder(folder / "public/data/targets");
  write_text_file(folder / "src/json/targets/target-list.json",
                  "{\"targets\": {\"data/targets/a.target\": []}}");
  EXPECT_THAT(error_of([&] { MakeHumanTargets(folder.path(), 2); }),
              HasSubstr("targets.bin: the file is missing"));
  write_text_file(folder / "public/data/targets/targets.bin", std::string(11, '\0'));
  EXPECT_THAT(error_of([&] { MakeHumanTargets(folder.path(), 2); }), HasSubstr("has 11 bytes, expected 12"));
  write_text_file(folder / "public/data/targets/targets.bin",
                  std::string("\x0a\0\0\0\0\0\0\0\xff\xff\0\0", 12));
  const auto offsets = MakeHumanTargets(folder.path(), 2).offsets_mm("a");
  EXPECT_EQ(offsets[0], Eigen::Vector3f(1.0f, 0.0f, 0.0f));  // 10 thousandths of a decimetre
  EXPECT_FLOAT_EQ(offsets[1].y(), -0.1f);
}

TEST(MakeHumanPackageTest, ALeftOutTargetOrListIsNamed) {
  const TemporaryFolder folder;
  make_folder(folder / "src/json/targets");
  make_folder(folder / "public/data/targets");
  for (const std::string list : {"[]", "{}", R"({"targets": [1]})"}) {
    write_text_file(folder / "src/json/targets/target-list.json", list);
    EXPECT_THAT(error_of([&] { MakeHumanTargets(folder.path(), 2); }),
                HasSubstr("target-list.json: expected an object 'targets'"))
        << list;
  }
  write_text_file(folder / "src/json/targets/target-list.json", R"({"targets": {"a": []}})");
  write_text_file(folder / "public/data/targets/targets.bin", std::string(12, '\0'));
  const MakeHumanTargets targets(folder.path(), 2);
  EXPECT_THAT(error_of([&] { targets.offsets_mm("b"); }), HasSubstr("there is no target 'b'"));
  // The size was right when the list was read.
  write_text_file(folder / "public/data/targets/targets.bin", std::string(11, '\0'));
  EXPECT_THAT(error_of([&] { targets.offsets_mm("a"); }), HasSubstr("targets.bin: cannot be read"));
}

}  // namespace
}  // namespace knuckle
