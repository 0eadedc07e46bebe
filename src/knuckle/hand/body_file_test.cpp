// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/body_file.h"

#include <fstream>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/hand/testing_body.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/hdf5_file.h"

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
  save_body(saved, folder / "a.h5");
  const Body loaded = load_body(folder / "a.h5");
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
  save_body(saved, folder / "a.h5");
  const Body loaded = load_body(folder / "a.h5");
  EXPECT_TRUE(loaded.shapedirs.empty());
  EXPECT_TRUE(loaded.sections.empty());
  EXPECT_EQ(loaded.v_template, saved.v_template);
}

TEST(BodyFileTest, BadBodyIsNotSaved) {
  const TemporaryFolder folder;
  Body body = box_hand_body();
  body.weights[0] = {0.5f, 0.0f, 0.0f, 0.0f};
  EXPECT_THAT(error_of([&] { save_body(body, folder / "bad.h5"); }),
              AllOf(HasSubstr("bad.h5"), HasSubstr("sum to")));
  EXPECT_FALSE(std::filesystem::exists(folder / "bad.h5"));
}

/// Loads a file that is a good body but for `replace`, which writes some arrays first; the message.
class SpoiledFile {
 public:
  std::string error_with(const std::string& array, const std::function<void(Hdf5File&)>& replace) const {
    const std::filesystem::path path = folder_ / "spoiled.h5";
    save_body(box_hand_body(), folder_ / "good.h5");
    {
      const Hdf5File good = Hdf5File::open(folder_ / "good.h5");
      Hdf5File spoiled = Hdf5File::create(path);
      spoiled.set_attribute("format", "knuckle-body");
      spoiled.set_attribute("version", 1.0);
      for (const char* name : {"names", "shapedirs_names", "landmark_names"}) {
        if (name != array) spoiled.write_texts(name, good.read_texts(name));
      }
      for (const char* name :
           {"v_template", "faces", "is_hand", "sections", "weights", "parents", "shapedirs_starts",
            "shapedirs_vertices", "shapedirs_offsets", "joint_regressor_starts", "joint_regressor_vertices",
            "joint_regressor_weights", "landmark_regressor_starts", "landmark_regressor_vertices",
            "landmark_regressor_weights", "landmark_bones"}) {
        if (name == array) continue;
        const auto values = good.read<double>(name);
        spoiled.write<double>(name, values.shape, values.values.data());
      }
      replace(spoiled);
      spoiled.close();
    }
    std::string message = error_of([&] { load_body(path); });
    EXPECT_THAT(message, HasSubstr("spoiled.h5"));
    return message;
  }

  /// The same where one value of an array is another.
  std::string error_with_value(const std::string& array, std::size_t place, double value) const {
    return error_with(array, [&](Hdf5File& file) {
      auto values = Hdf5File::open(folder_ / "good.h5").read<double>(array);
      values.values[place] = value;
      file.write<double>(array, values.shape, values.values.data());
    });
  }

  std::string error_with_shape(const std::string& array, const std::vector<std::uint64_t>& shape) const {
    return error_with(array, [&](Hdf5File& file) {
      std::uint64_t size = 1;
      for (const std::uint64_t length : shape) size *= length;
      const std::vector<double> zeros(size, 0.0);
      file.write<double>(array, shape, zeros.data());
    });
  }

 private:
  TemporaryFolder folder_;
};

TEST(BodyFileTest, SpoiledArraysAreNamed) {
  const SpoiledFile file;
  EXPECT_THAT(file.error_with("faces", [](Hdf5File&) {}), HasSubstr("faces"));
  EXPECT_THAT(file.error_with_shape("v_template", {5, 2}), HasSubstr("v_template is 5 x 2, expected N x 3"));
  EXPECT_THAT(file.error_with_shape("parents", {3}), HasSubstr("parents is 3"));
  EXPECT_THAT(file.error_with_shape("weights", {7, 7}), HasSubstr("weights is 7 x 7"));
  EXPECT_THAT(file.error_with_shape("is_hand", {1}), HasSubstr("is_hand is 1"));
  EXPECT_THAT(file.error_with_shape("landmark_bones", {21}), HasSubstr("expected 22"));
  EXPECT_THAT(
      file.error_with("landmark_names", [](Hdf5File& f) { f.write_texts("landmark_names", {"wrist"}); }),
      HasSubstr("landmark_names"));
}

TEST(BodyFileTest, SpoiledValuesAreNamed) {
  const SpoiledFile file;
  EXPECT_THAT(file.error_with_value("v_template", 4, kNaN),
              HasSubstr("v_template of vertex 1 is not finite"));
  EXPECT_THAT(file.error_with_value("weights", 0, kNaN), HasSubstr("weights of vertex 0"));
  EXPECT_THAT(file.error_with_value("weights", 0, 0.4), HasSubstr("weights of vertex 0 sum to 0.4"));
  EXPECT_THAT(file.error_with_value("parents", 1, 1), HasSubstr("cycle"));
  EXPECT_THAT(file.error_with_value("parents", 1, 2), HasSubstr("cycle"));
  EXPECT_THAT(file.error_with_value("faces", 3, 1e6), HasSubstr("face 1 names vertex 1000000"));
  EXPECT_THAT(file.error_with_value("shapedirs_starts", 1, 1e12), HasSubstr("shapedirs_starts"));
  EXPECT_THAT(file.error_with_value("shapedirs_starts", 2, 1e12), HasSubstr("shapedirs_vertices"));
  EXPECT_THAT(file.error_with_value("joint_regressor_starts", 0, -1), HasSubstr("joint_regressor_starts"));
  EXPECT_THAT(file.error_with_value("joint_regressor_vertices", 0, -4), HasSubstr("lowerarm02.R"));
  EXPECT_THAT(file.error_with_value("landmark_regressor_weights", 0, 2), HasSubstr("wrist sum to 2"));
  EXPECT_THAT(file.error_with_value("landmark_bones", 0, 99), HasSubstr("landmark_bones of wrist is 99"));
}

TEST(BodyFileTest, MoreThanFourBonesAVertexAreRefused) {
  const SpoiledFile file;
  const Body body = box_hand_body();
  const std::size_t bones = body.names.size();
  const auto message = file.error_with("weights", [&](Hdf5File& spoiled) {
    std::vector<float> weights(body.v_template.size() * bones, 0.0f);
    for (std::size_t i = 0; i < weights.size(); i += bones) weights[i] = 1.0f;
    for (std::size_t b = 0; b < 5; ++b) weights[3 * bones + b] = 0.2f;
    spoiled.write<float>("weights", {body.v_template.size(), bones}, weights.data());
  });
  EXPECT_THAT(message, HasSubstr("weights of vertex 3 name 5 bones"));
}

TEST(BodyFileTest, ForeignAndDamagedFilesAreRefused) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { load_body(folder / "none.h5"); }), HasSubstr("none.h5"));
  write_text_file(folder / "text.h5", "no body");
  EXPECT_THAT(error_of([&] { load_body(folder / "text.h5"); }), HasSubstr("text.h5"));
  for (const auto& [format, version] : {std::pair{"knuckle-forest", 1.0}, {"knuckle-body", 2.0}}) {
    Hdf5File other = Hdf5File::create(folder / "other.h5");
    other.set_attribute("format", format);
    other.set_attribute("version", version);
    other.close();
    EXPECT_THAT(error_of([&] { load_body(folder / "other.h5"); }), HasSubstr("other.h5"));
  }
}

TEST(BodyFileTest, TruncatedFilesAreRefusedAtEveryLength) {
  const TemporaryFolder folder;
  save_body(box_hand_body(), folder / "whole.h5");
  const std::string bytes = read_text_file(folder / "whole.h5");
  for (int percent = 0; percent < 100; percent += 7) {
    write_text_file(folder / "cut.h5", std::string_view(bytes).substr(0, bytes.size() * percent / 100));
    EXPECT_THAT(error_of([&] { load_body(folder / "cut.h5"); }), HasSubstr("cut.h5"))
        << percent << " percent";
  }
}

}  // namespace
}  // namespace knuckle
