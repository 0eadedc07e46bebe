// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/body_file.h"

#include <fstream>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/hand/testing_body.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/model_testing.h"

namespace knuckle {
namespace {

using ::knuckle::testing::box_hand_body;
using ::knuckle::testing::error_of;
using ::knuckle::testing::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;

bool equal(const VertexGroup& a, const VertexGroup& b) {
  return a.vertices == b.vertices && a.weights == b.weights;
}

/// V x B weights: the order of a vertex's bones has no meaning.
std::vector<float> dense_weights(const Body& body) {
  std::vector<float> dense(body.weights.size() * body.names.size(), 0.0f);
  for (std::size_t i = 0; i < body.weights.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k)
      dense[i * body.names.size() + body.weight_bones[i][k]] += body.weights[i][k];
  }
  return dense;
}

TEST(BodyFileTest, SavedBodyComesBack) {
  const TemporaryFolder folder;
  const Body saved = box_hand_body();
  save_body(saved, folder / "a.model");
  const Body loaded = load_body(folder / "a.model");
  EXPECT_EQ(loaded.v_template, saved.v_template);
  EXPECT_EQ(loaded.faces, saved.faces);
  EXPECT_EQ(loaded.is_hand, saved.is_hand);
  EXPECT_EQ(loaded.names, saved.names);
  EXPECT_EQ(loaded.parents, saved.parents);
  EXPECT_EQ(loaded.sections, saved.sections);
  EXPECT_EQ(loaded.landmark_bones, saved.landmark_bones);
  EXPECT_EQ(dense_weights(loaded), dense_weights(saved));
  ASSERT_EQ(loaded.shapedirs.size(), saved.shapedirs.size());
  for (std::size_t i = 0; i < saved.shapedirs.size(); ++i) {
    EXPECT_EQ(loaded.shapedirs[i].name, saved.shapedirs[i].name);
    EXPECT_EQ(loaded.shapedirs[i].vertices, saved.shapedirs[i].vertices);
    EXPECT_EQ(loaded.shapedirs[i].offsets_mm, saved.shapedirs[i].offsets_mm);
  }
  EXPECT_TRUE(std::ranges::equal(loaded.joint_regressor, saved.joint_regressor, equal));
  EXPECT_TRUE(std::ranges::equal(loaded.landmark_regressor, saved.landmark_regressor, equal));
}

TEST(BodyFileTest, BodyWithoutShapesAndSectionsComesBack) {
  const TemporaryFolder folder;
  Body saved = box_hand_body();
  saved.shapedirs.clear();
  saved.sections.clear();
  save_body(saved, folder / "a.model");
  const Body loaded = load_body(folder / "a.model");
  EXPECT_TRUE(loaded.shapedirs.empty());
  EXPECT_TRUE(loaded.sections.empty());
  EXPECT_EQ(loaded.v_template, saved.v_template);
}

TEST(BodyFileTest, BadBodyIsNotSaved) {
  const TemporaryFolder folder;
  Body body = box_hand_body();
  body.weights[0] = {0.5f, 0.0f, 0.0f, 0.0f};
  EXPECT_THAT(error_of([&] { save_body(body, folder / "bad.model"); }),
              AllOf(HasSubstr("bad.model"), HasSubstr("sum to")));
  EXPECT_FALSE(std::filesystem::exists(folder / "bad.model"));
}

/// Loads a file that is a good body but for one change; the message.
class SpoiledFile {
 public:
  SpoiledFile() { save_body(box_hand_body(), folder_ / "good.model"); }

  std::string error_with(const std::function<void(ModelWriter&)>& spoil) const {
    const std::filesystem::path path = folder_ / "spoiled.model";
    ModelWriter body = ModelFile::open(folder_ / "good.model").writer();
    spoil(body);
    body.save(path);
    std::string message = error_of([&] { load_body(path); });
    EXPECT_THAT(message, HasSubstr("spoiled.model"));
    return message;
  }

  /// The same where one value of an array of T is another.
  template <class T>
  std::string error_with_value(const std::string& array, std::size_t place, double value) const {
    ModelArray<T> changed = ModelFile::open(folder_ / "good.model").read<T>(array);
    changed.values[place] = static_cast<T>(value);
    return error_with([&](ModelWriter& body) { body.add(array, changed.shape, changed.values); });
  }

  std::string error_with_shape(const std::string& array, const std::vector<std::uint64_t>& shape) const {
    std::uint64_t size = 1;
    for (const std::uint64_t length : shape) size *= length;
    return error_with([&](ModelWriter& body) { body.add(array, shape, std::vector<float>(size, 0.0F)); });
  }

 private:
  TemporaryFolder folder_;
};

TEST(BodyFileTest, SpoiledArraysAreNamed) {
  const SpoiledFile file;
  EXPECT_THAT(file.error_with([](ModelWriter& body) { body.remove("faces"); }), HasSubstr("faces"));
  EXPECT_THAT(file.error_with_shape("v_template", {5, 2}), HasSubstr("v_template is 5 x 2, expected N x 3"));
  EXPECT_THAT(file.error_with_shape("parents", {3}), HasSubstr("parents is 3"));
  EXPECT_THAT(file.error_with_shape("weights", {7, 7}), HasSubstr("weights is 7 x 7"));
  EXPECT_THAT(file.error_with_shape("is_hand", {1}), HasSubstr("is_hand is 1"));
  EXPECT_THAT(file.error_with_shape("landmark_bones", {21}), HasSubstr("expected 22"));
  EXPECT_THAT(file.error_with(
                  [](ModelWriter& body) { body.set("landmark_names", std::vector<std::string>{"wrist"}); }),
              HasSubstr("landmark_names"));
}

TEST(BodyFileTest, SpoiledValuesAreNamed) {
  const SpoiledFile file;
  EXPECT_THAT(file.error_with_value<float>("v_template", 4, kNaN),
              HasSubstr("v_template of vertex 1 is not finite"));
  EXPECT_THAT(file.error_with_value<float>("weights", 0, kNaN), HasSubstr("weights of vertex 0"));
  EXPECT_THAT(file.error_with_value<float>("weights", 0, 0.4), HasSubstr("weights of vertex 0 sum to 0.4"));
  EXPECT_THAT(file.error_with_value<std::int32_t>("parents", 1, 1), HasSubstr("cycle"));
  EXPECT_THAT(file.error_with_value<std::int32_t>("parents", 1, 2), HasSubstr("cycle"));
  EXPECT_THAT(file.error_with_value<std::int32_t>("faces", 3, 1e6), HasSubstr("face 1 names vertex 1000000"));
  EXPECT_THAT(file.error_with_value<std::int64_t>("shapedirs_starts", 1, 1e12),
              HasSubstr("shapedirs_starts do not grow from 0"));
  EXPECT_THAT(file.error_with_value<std::int64_t>("shapedirs_starts", 2, 1e12),
              HasSubstr("shapedirs_vertices"));
  EXPECT_THAT(file.error_with_value<std::int64_t>("joint_regressor_starts", 0, -1),
              HasSubstr("joint_regressor_starts do not grow from 0"));
  EXPECT_THAT(file.error_with_value<std::int32_t>("joint_regressor_vertices", 0, -4),
              HasSubstr("lowerarm02.R"));
  EXPECT_THAT(file.error_with_value<float>("landmark_regressor_weights", 0, 2), HasSubstr("wrist sum to 2"));
  EXPECT_THAT(file.error_with_value<std::int32_t>("landmark_bones", 0, 99),
              HasSubstr("landmark_bones of wrist is 99"));
}

TEST(BodyFileTest, MoreThanFourBonesAVertexAreRefused) {
  const SpoiledFile file;
  const Body body = box_hand_body();
  const std::size_t bones = body.names.size();
  const auto message = file.error_with([&](ModelWriter& spoiled) {
    std::vector<float> weights(body.v_template.size() * bones, 0.0f);
    for (std::size_t i = 0; i < weights.size(); i += bones) weights[i] = 1.0f;
    for (std::size_t b = 0; b < 5; ++b) weights[3 * bones + b] = 0.2f;
    spoiled.add("weights", {body.v_template.size(), bones}, weights);
  });
  EXPECT_THAT(message, HasSubstr("weights of vertex 3 name 5 bones"));
}

TEST(BodyFileTest, ForeignAndDamagedFilesAreRefused) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { load_body(folder / "none.model"); }), HasSubstr("none.model"));
  write_text_file(folder / "text.model", "no body");
  EXPECT_THAT(error_of([&] { load_body(folder / "text.model"); }), HasSubstr("text.model"));
  for (const auto& [format, version] : {std::pair{"knuckle-forest", 2}, {"knuckle-body", 3}}) {
    ModelWriter(format, version).save(folder / "other.model");
    EXPECT_THAT(error_of([&] { load_body(folder / "other.model"); }), HasSubstr("other.model"));
  }
}

TEST(BodyFileTest, TruncatedFilesAreRefusedAtEveryLength) {
  const TemporaryFolder folder;
  save_body(box_hand_body(), folder / "whole.model");
  const std::string bytes = read_text_file(folder / "whole.model");
  for (int percent = 0; percent < 100; percent += 7) {
    write_text_file(folder / "cut.model", std::string_view(bytes).substr(0, bytes.size() * percent / 100));
    EXPECT_THAT(error_of([&] { load_body(folder / "cut.model"); }), HasSubstr("cut.model"))
        << percent << " percent";
  }
}

}  // namespace
}  // namespace knuckle
