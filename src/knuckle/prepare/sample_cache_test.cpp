// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/sample_cache.h"

#include <algorithm>
#include <array>
#include <vector>

#include "knuckle/core/resources.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/hand/body_file.h"
#include "knuckle/prepare/sample_file.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"
#include "knuckle/synth/manifest.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Not;

/// Six rendered hands.
class SampleCacheTest : public ::testing::Test {
 protected:
  SampleCacheTest() {
    write_text_file(folder_ / "finder.toml", "[segmentation]\nmethod = \"mean_shift\"\n");
    copy_manifest("demo.toml");
    options_.patch = {32, 250.0};
    options_.crop_px = 48;
  }

  void copy_manifest(const std::string& name) const {
    write_text_file(folder_ / name, read_text_file(resource_path("manifests/demo.toml")));
  }

  NetworkSamples samples(const std::string& manifest = "demo.toml",
                         const std::string& settings = "?count=6") {
    const HandFinder finder = HandFinder::load(folder_ / "finder.toml");
    return cache_.samples("synthetic:" + (folder_ / manifest).string() + settings, finder, segmentation_,
                          options_);
  }

  std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> result;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "cache")) result.push_back(entry);
    return result;
  }

  testing::TemporaryFolder folder_;
  SampleCache cache_{folder_ / "cache"};
  Inputs segmentation_;
  SampleOptions options_;
};

void expect_same(const NetworkSamples& a, const NetworkSamples& b) {
  ASSERT_EQ(a.samples.size(), b.samples.size());
  EXPECT_EQ(a.samples.joint_count(), b.samples.joint_count());
  EXPECT_EQ(a.samples.crop().size_px, b.samples.crop().size_px);
  EXPECT_EQ(a.samples.crop().side_mm, b.samples.crop().side_mm);
  EXPECT_EQ((std::array{a.frames.total, a.frames.without_hand, a.frames.off_centre}),
            (std::array{b.frames.total, b.frames.without_hand, b.frames.off_centre}));
  for (std::int64_t i = 0; i < a.samples.size(); ++i) {
    const CubeSample first = a.samples.sample(i);
    const CubeSample second = b.samples.sample(i);
    EXPECT_TRUE(std::ranges::equal(first.codes, second.codes)) << i;
    EXPECT_TRUE(std::ranges::equal(first.joints, second.joints)) << i;
    EXPECT_EQ(first.centre_mm, second.centre_mm) << i;
  }
}

TEST_F(SampleCacheTest, GivesTheSameSamplesAgainWithoutLookingAtTheFrames) {
  const NetworkSamples made = samples();
  ASSERT_GT(made.samples.size(), 3);
  ASSERT_EQ(files().size(), 1u);
  const auto written = std::filesystem::last_write_time(files()[0]);
  expect_same(samples(), made);
  EXPECT_EQ(std::filesystem::last_write_time(files()[0]), written);
  EXPECT_LT(std::filesystem::file_size(files()[0]), made.samples.size() * 48 * 48 + 16384);
}

TEST_F(SampleCacheTest, MakesOthersWhereAnythingDiffersButTheManifestsPlace) {
  const NetworkSamples made = samples();
  copy_manifest("elsewhere.toml");
  expect_same(samples("elsewhere.toml"), made);
  EXPECT_EQ(files().size(), 1u);
  EXPECT_EQ(samples("demo.toml", "?count=5").frames.total, 5);
  EXPECT_EQ(files().size(), 2u);
  options_.crop_px = 40;
  EXPECT_EQ(samples().samples.crop_px(), 40);
  EXPECT_EQ(files().size(), 3u);
  options_.start = Start::truth;
  samples();
  EXPECT_EQ(files().size(), 4u);
  segmentation_.add("bandwidth", "20 mm");
  samples();
  EXPECT_EQ(files().size(), 5u);
  write_text_file(folder_ / "demo.toml", read_text_file(folder_ / "demo.toml") + "# changed\n");
  samples();
  EXPECT_EQ(files().size(), 6u);
  options_.most = 3;
  EXPECT_EQ(samples().frames.total, 3);
  EXPECT_EQ(files().size(), 7u);
  options_.patch.side_mm = 200.0;
  EXPECT_DOUBLE_EQ(samples().samples.patch().side_mm, 200.0);
  EXPECT_EQ(files().size(), 8u);
  options_.patch.size_px = 24;
  EXPECT_EQ(samples().samples.patch().size_px, 24);
  EXPECT_EQ(files().size(), 9u);
  options_.convention = convention_from_name("nyu14");
  EXPECT_EQ(samples().samples.joint_count(), 14);
  EXPECT_EQ(files().size(), 10u);
  options_.side = HandSide::left;
  samples();
  EXPECT_EQ(files().size(), 11u);
  std::string manifest = read_text_file(folder_ / "demo.toml");
  manifest.replace(manifest.find("sequence_frames = 0"), 19, "sequence_frames = 2");
  write_text_file(folder_ / "demo.toml", manifest);
  options_.holdout = {0.5, Holdout::Part::validation};
  samples();
  EXPECT_EQ(files().size(), 12u);
  options_.holdout.part = Holdout::Part::training;
  samples();
  EXPECT_EQ(files().size(), 13u);
}

TEST_F(SampleCacheTest, NamesFilesAsItAlwaysDid) {
  samples();
  Inputs inputs = segmentation_;
  inputs.add_source("source", "synthetic:" + (folder_ / "demo.toml").string() + "?count=6")
      .add("convention", "knuckle22")
      .add("patch", "32 px, 250 mm")
      .add("crop", "48 px")
      .add("start", "nearest")
      .add("centre", "segmentation")
      .add("most", "0");
  EXPECT_TRUE(std::filesystem::exists(folder_ / "cache" / ("samples_" + text_hash(inputs.text()) + ".h5")));
}

TEST_F(SampleCacheTest, ADamagedOrForeignFileIsNamed) {
  samples();
  const std::filesystem::path file = files()[0];
  const auto size = std::filesystem::file_size(file);
  const std::string whole = read_text_file(file);
  const auto fault = [&] { return error_of([&] { samples(); }); };
  const auto names_it = AllOf(HasSubstr(file.filename().string()), Not(HasSubstr("\n")));
  for (const std::uintmax_t length : {std::uintmax_t{0}, size / 3, size - 1000}) {
    std::filesystem::resize_file(file, length);
    EXPECT_THAT(fault(), names_it) << length;
    write_text_file(file, whole);
  }
  {
    Hdf5Writer changed = Hdf5Writer::open(file);
    const std::vector<double> nothing(3 * 6, NAN);
    changed.write_rows("centres_mm", 0, 1, nothing.data());
  }
  EXPECT_THAT(fault(), AllOf(names_it, HasSubstr("centre"), HasSubstr("remove the file")));
  const auto fault_with = [&](const std::string& attribute, const std::vector<double>& numbers) {
    write_text_file(file, whole);
    Hdf5Writer changed = Hdf5Writer::open(file);
    changed.set_attribute(attribute, numbers);
    changed.close();
    return fault();
  };
  EXPECT_THAT(fault_with("patch", {64.0}), AllOf(names_it, HasSubstr("shapes of its arrays do not fit")));
  EXPECT_THAT(fault_with("patch", {0.0, 150.0}),
              AllOf(names_it, HasSubstr("its patch or its joints are out of range")));
  EXPECT_THAT(fault_with("patch", {64.0, -1.0}),
              AllOf(names_it, HasSubstr("its patch or its joints are out of range")));
  EXPECT_THAT(fault_with("frames", {6.0, 0.0}), AllOf(names_it, HasSubstr("2 numbers, expected 3")));
  EXPECT_THAT(fault_with("frames", {6.0, -1.0, 0.0}),
              AllOf(names_it, HasSubstr("expected 3 numbers of frames")));
  write_text_file(file, whole);
  {
    Hdf5Writer changed = Hdf5Writer::open(file);
    changed.set_attribute("inputs", "others");
  }
  EXPECT_THAT(fault(), AllOf(names_it, HasSubstr("other sources or options")));
}

TEST_F(SampleCacheTest, NamesAFolderThatCannotBeMadeOrWrittenTo) {
  write_text_file(folder_ / "file", "");
  EXPECT_THAT(error_of([&] { SampleCache(folder_ / "file" / "cache"); }), HasSubstr("file/cache"));
  std::filesystem::remove_all(folder_ / "cache");
  EXPECT_THAT(error_of([&] { samples(); }), AllOf(HasSubstr("/cache/"), HasSubstr("samples_")));
}

TEST_F(SampleCacheTest, NoticesAnotherBody) {
  Body body = body_of(load_manifest(folder_ / "demo.toml"));
  const auto samples_of = [&] {
    save_body(body, folder_ / "body.model");
    return samples("own.toml", "?count=1");
  };
  std::string manifest = read_text_file(folder_ / "demo.toml");
  manifest.replace(manifest.find("[body]"), 6, "[body]\nfile = \"body.model\"");
  write_text_file(folder_ / "own.toml", manifest);
  samples_of();
  samples_of();
  EXPECT_EQ(files().size(), 1u);
  body.v_template[0].x() += 1.0F;
  samples_of();
  EXPECT_EQ(files().size(), 2u);
}

}  // namespace
}  // namespace knuckle
