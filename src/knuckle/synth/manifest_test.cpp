// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/manifest.h"

#include <algorithm>
#include <set>

#include "knuckle/core/resources.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/testing_variable.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle {
namespace {

using ::testing::HasSubstr;

class ManifestTest : public ::testing::Test {
 protected:
  std::filesystem::path written(const std::string& text) const {
    write_text_file(folder_ / "m.toml", text);
    return folder_ / "m.toml";
  }
  std::string error_of_manifest(const std::string& text) const {
    return testing::error_of([&] { load_manifest(written(text)); });
  }
  testing::TemporaryFolder folder_;
};

TEST_F(ManifestTest, AnEmptyOneIsTheDefaults) {
  const Manifest manifest = load_manifest(written(""));
  EXPECT_EQ(manifest.frames, 1000);
  EXPECT_EQ(manifest.camera.camera.width, 320);
  EXPECT_EQ(manifest.camera.camera.fx, 224.0);
  EXPECT_EQ(manifest.sensor.noise.sigma_mm, 3.0);
}

TEST_F(ManifestTest, EveryTableIsRead) {
  const Manifest manifest = load_manifest(written(
      "seed = 12\nframes = 34\n[body]\npeople = 5\n[camera]\nmodel = 'orthographic'\nwidth = 64\nfx = 0.5\n"
      "distortion = []\n[pose]\npair_share = 2.0\nmotion = 'smooth'\n[placement]\nnearest_mm = 300.0\n"
      "[sensor]\nsigma_mm = 1.5\n"));
  EXPECT_EQ(manifest.seed, 12u);
  EXPECT_EQ(manifest.frames, 34);
  EXPECT_EQ(manifest.body.people, 5);
  EXPECT_EQ(manifest.camera.camera.model, CameraModel::orthographic);
  EXPECT_EQ(manifest.camera.camera.width, 64);
  EXPECT_EQ(manifest.pose.pair_share, 2.0);
  EXPECT_TRUE(manifest.motion.is_smooth());
  EXPECT_EQ(manifest.placement.nearest_mm, 300.0);
  EXPECT_EQ(manifest.sensor.noise.sigma_mm, 1.5);
}

TEST_F(ManifestTest, APresetSetsCameraAndSensorAndKeysChangeSingleValues) {
  const Manifest preset = load_manifest(written("[sensor]\npreset = 'kinect_v2'\n"));
  EXPECT_EQ(preset.camera.camera.width, 512);
  EXPECT_EQ(preset.camera.camera.height, 424);
  EXPECT_EQ(preset.sensor.drop_outs.range_mm, 4500.0);
  EXPECT_GT(preset.sensor.infrared.infrared, 0.0);
  const Manifest changed = load_manifest(written(
      "[camera]\nfx = 366.0\nfocal_spread = 0.1\n[sensor]\npreset = 'kinect_v2'\nrange_mm = 2000.0\n"));
  EXPECT_EQ(changed.camera.camera.fx, 366.0);
  EXPECT_EQ(changed.camera.camera.fy, preset.camera.camera.fy);
  EXPECT_EQ(changed.camera.focal_spread, 0.1);
  EXPECT_EQ(changed.sensor.drop_outs.range_mm, 2000.0);
  EXPECT_EQ(changed.sensor.noise.sigma_mm, preset.sensor.noise.sigma_mm);
}

TEST_F(ManifestTest, ErrorsNameFileAndFault) {
  const std::pair<std::string, std::string> faults[] = {
      {"frame = 10", "frame"},
      {"[lens]\nf = 1", "lens"},
      {"[camera]\nfocal = 3.0", "focal"},
      {"frames = 0", "frames"},
      {"frames = 'ten'", "frames"},
      {"[camera]\nwidth = -3", "width"},
      {"[camera]\nfx = 0.0", "fx"},
      {"[camera]\nmodel = 'fisheye'", "projective"},
      {"[pose]\njitter_deg = 400.0", "jitter_deg"},
      {"[pose]\nmotion = 'jump'", "smooth"},
      {"[pose]\ngesture_share = 0.0\npair_share = 0.0\nmixed_share = 0.0\nclosing_share = 0.0\ngrasp_share = "
       "0.0\nuniform_share "
       "= 0.0",
       "gesture_share"},
      {"[placement]\nnearest_mm = 800.0\nfarthest_mm = 400.0", "nearest_mm"},
      {"[sensor]\nsigma_mm = nan", "m.toml:2: sensor.sigma_mm"},
      {"[sensor]\npreset = 'kinect_v3'", "m.toml:2: sensor.preset"},
      {"[sensor]\npreset = 'kinect_v3'", "kinect_v2"},
      {"[sensor]\nflying = 1.0", "m.toml:2: sensor.flying: unknown key"},
      {"[sensor]\nflying_px = -1.0", "m.toml:2: sensor.flying_px"},
      {"[sensor]\nhole_share = 2.0", "m.toml:2: sensor.hole_share"},
      {"[sensor]\nnear_mm = 900.0\nrange_mm = 400.0", "m.toml:2: sensor.near_mm: is 900"},
      {"[sensor]\npreset = 'creative'\nnear_mm = 1200.0", "m.toml:3: sensor.near_mm: is 1200"},
      {"[sensor]\ndisparity_px = 0.5", "m.toml:2: sensor.disparity_px"},
      {"[camera]\nmodel = 'orthographic'\n[sensor]\npreset = 'sr300'", "baseline_mm"},
      {"[scene]\ntable = 1.0", "m.toml:2: scene.table: unknown key"},
      {"[scene]\ntable_share = 1.5", "m.toml:2: scene.table_share"},
      {"[scene]\nthings = ['teapot']", "teapot"},
      {"[scene]\nmost_things = 3\nthings = ['mug']\nwithout_things = ['mug']", "most_things is 3"},
      {"[scene]\nbefore_share = 0.5\nleast_visible = 1.0", "least_visible is 1"},
      {"[scene]\nheld_share = 0.5\ngrasps = ['teeth']", "teeth"},
      {"[scene]\ngrasps = ['pinch']", "held_share is 0"},
      {"[scene]\nsecond_share = 0.5\ncrossed_share = 0.7\ntouching_share = 0.7", "crossed_share"},
      {"[pose]\nmotion = 'smooth'\n[scene]\nsecond_share = 0.5", "touching_share"},
      {"[scene]\nsecond_share = 0.5\nsecond_pass_frames = 60", "scene.second_pass_frames"},
      {"[pose]\nmotion = 'smooth'\n[scene]\nsecond_pass_frames = -1", "second_pass_frames"},
      {"[pose]\nsequence_frames = 10", "m.toml:2: pose.sequence_frames"},
      {"[scene]\nempty_share = 0.6\ncut_share = 0.5", "cut_share"},
      {"[scene]\nstump_share = 0.5", "empty_share is 0"},
      {"[pose]\nmotion = 'smooth'\n[scene]\nempty_share = 0.5", "m.toml:4: scene.empty_share"},
      {"[camera]\nmodel = 'orthographic'\n[scene]\ntable_share = 0.5", "m.toml:2: camera.model"},
      {"[body]\npeople = 0", "people"},
      {"[body]\nbone_spread = 0.5", "bone_spread"},
      {"[body]\nside = 'top'", "both"},
      {"seed = = 3", "m.toml"}};
  for (const auto& [text, fault] : faults) {
    const std::string message = error_of_manifest(text);
    EXPECT_THAT(message, HasSubstr("m.toml")) << text;
    EXPECT_THAT(message, HasSubstr(fault)) << text;
    EXPECT_THAT(message, ::testing::Not(HasSubstr("\n"))) << text;
  }
}

TEST_F(ManifestTest, AMissingFileOrBodyIsNamed) {
  EXPECT_THAT(testing::error_of([&] { load_manifest(folder_ / "none.toml"); }), HasSubstr("none.toml"));
  const auto path = written("[body]\nfile = 'nobody.model'");
  EXPECT_THAT(testing::error_of([&] { open_synthetic(path); }), HasSubstr("nobody.model"));
}

TEST_F(ManifestTest, WhereMakeHumanIsMissingTheErrorSaysWhatFetchesIt) {
  const std::string nowhere = (folder_ / "nowhere").string();
  const testing::ChangedVariable package("KNUCKLE_MAKEHUMAN", nowhere);
  const std::string message = testing::error_of([&] { open_synthetic(written("")); });
  EXPECT_THAT(message, HasSubstr("scripts/fetch_makehuman.sh"));
  EXPECT_THAT(message, HasSubstr(nowhere));
}

constexpr const char* kTestManifests[] = {"manifests/test_creative.toml", "manifests/test_pico.toml",
                                          "manifests/test_kinect_v2.toml"};

TEST(ShippedManifests, AreRead) {
  for (const char* name :
       {"manifests/demo.toml", "manifests/train_small.toml", "manifests/train.toml",
        "manifests/train_scenes.toml", "manifests/validate_scenes.toml", "manifests/test_scenes.toml"}) {
    EXPECT_NO_THROW(load_manifest(resource_path(name))) << name;
  }
}

TEST(ShippedManifests, TrainingIsAsLargeAsThePapers) {
  EXPECT_GE(load_manifest(resource_path("manifests/train.toml")).frames, 400000);
}

TEST(ShippedManifests, TestsShowOnePersonMovingSmoothly) {
  for (const char* name : kTestManifests) {
    const Manifest manifest = load_manifest(resource_path(name));
    EXPECT_EQ(manifest.frames, 400) << name;
    EXPECT_EQ(manifest.body.people, 1) << name;
    EXPECT_TRUE(manifest.motion.is_smooth()) << name;
  }
}

TEST(ShippedManifests, TrainingNeverDrawsAGestureOfTheTests) {
  const Manifest training = load_manifest(resource_path("manifests/train.toml"));
  const auto trained = allowed_gestures(training.pose);
  for (const char* name : kTestManifests) {
    const HandPoseOptions pose = load_manifest(resource_path(name)).pose;
    const auto tested = allowed_gestures(pose);
    EXPECT_GE(tested.size(), 5u) << name;
    for (const std::string_view gesture : tested) {
      EXPECT_EQ(std::ranges::find(trained, gesture), trained.end()) << name << ": " << gesture;
    }
    // The other kinds of hand are not made of named gestures of this list alone.
    EXPECT_EQ(pose.closing_share + pose.grasp_share + pose.uniform_share, 0.0) << name;
  }
}

TEST(ShippedManifests, PeopleOfTestsAreOthersThanThoseOfTraining) {
  std::set<std::uint64_t> seeds = {load_manifest(resource_path("manifests/train.toml")).seed};
  for (const char* name : kTestManifests) {
    EXPECT_TRUE(seeds.insert(load_manifest(resource_path(name)).seed).second) << name;
  }
}

}  // namespace
}  // namespace knuckle
