// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene_renderer.h"

#include <set>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/testing_body.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle {
namespace {

Manifest scene_manifest() {
  Manifest manifest;
  manifest.path = "scene.toml";
  manifest.seed = 21;
  manifest.frames = 60;
  manifest.body.people = 2;
  manifest.body.side = "both";
  manifest.camera.camera = {.width = 80, .height = 60, .fx = 56, .fy = 56, .cx = 39.5, .cy = 29.5};
  manifest.placement.above_share = 0.5;
  manifest.sensor.noise.sigma_mm = 0;
  manifest.sensor.quantisation_mm = 0;
  manifest.scene = {.empty_share = 0.1,
                    .room_share = 0.5,
                    .table_share = 0.7,
                    .most_things = 6,
                    .before_share = 0.4,
                    .sleeve_share = 0.5,
                    .band_share = 0.3,
                    .cut_share = 0.1};
  return manifest;
}

std::vector<Frame> frames_of(const Manifest& manifest, int threads) {
  set_thread_count(threads);
  const auto source = create_synthetic(manifest, std::make_shared<const Body>(testing::box_hand_body()));
  std::vector<Frame> frames(manifest.frames);
  parallel_for(manifest.frames, [&](std::int64_t i) { frames[i] = source->read(i); });
  set_thread_count(0);
  return frames;
}

TEST(Scenes, OneAndTwoThreadsGiveTheSameBits) {
  Manifest manifest = scene_manifest();
  manifest.sensor.noise.sigma_mm = 2;
  const auto one = frames_of(manifest, 1);
  const auto two = frames_of(manifest, 2);
  for (int i = 0; i < manifest.frames; ++i) {
    EXPECT_EQ(one[i].depth_mm, two[i].depth_mm) << i;
    EXPECT_EQ(one[i].labels, two[i].labels) << i;
    ASSERT_EQ(one[i].hands.size(), two[i].hands.size());
    for (std::size_t h = 0; h < one[i].hands.size(); ++h) {
      EXPECT_EQ(one[i].hands[h].occluders, two[i].hands[h].occluders);
      EXPECT_EQ(one[i].hands[h].visible_share, two[i].hands[h].visible_share);
    }
  }
}

TEST(Scenes, LabelsPartitionThePicture) {
  std::set<int> seen;
  for (const Frame& frame : frames_of(scene_manifest(), 0)) {
    ASSERT_EQ(frame.labels.size(), frame.depth_mm.size());
    for (std::size_t i = 0; i < frame.labels.size(); ++i) {
      const auto label = static_cast<PixelLabel>(frame.labels.data()[i]);
      seen.insert(static_cast<int>(label));
      EXPECT_EQ(frame.depth_mm.data()[i] > 0.0f, label != PixelLabel::nothing);
      EXPECT_EQ(frame.mask.data()[i], label == PixelLabel::hand ? 1 : 0);
    }
  }
  EXPECT_TRUE(seen.contains(static_cast<int>(PixelLabel::person)));
  EXPECT_TRUE(seen.contains(static_cast<int>(PixelLabel::object)));
}

TEST(Scenes, TruthTellsOfTheHandsThatAreThere) {
  int empty = 0;
  for (const Frame& frame : frames_of(scene_manifest(), 0)) {
    if (frame.hands.empty()) {
      ++empty;
      EXPECT_FALSE(frame.side.has_value());
      EXPECT_TRUE(frame.truth->is_missing());
      EXPECT_EQ(std::ranges::count(frame.mask.pixels(), 1), 0);
      continue;
    }
    const HandTruth& hand = frame.hands.front();
    EXPECT_EQ(hand.side, *frame.side);
    EXPECT_EQ(hand.occluders.size(), std::size_t{kSupersetSize});
    for (int k = 0; k < kSupersetSize; ++k) EXPECT_EQ(hand.pose.joints[k].u, frame.truth->joints[k].u);
    EXPECT_GE(hand.visible_share, 0.0);
    EXPECT_LE(hand.visible_share, 1.0);
    for (int k = 0; k < kSupersetSize; ++k) {
      if (hand.occluders[k] != Occluder::none && hand.occluders[k] != Occluder::own_hand) continue;
      const auto column = static_cast<int>(std::floor(hand.pose.joints[k].u + 0.5));
      const auto row = static_cast<int>(std::floor(hand.pose.joints[k].v + 0.5));
      const float depth = frame.depth_mm(column, row);
      const bool is_behind =
          depth > 0.0f && depth < hand.pose.joints[k].depth_mm - 60.0 && hand.occluders[k] == Occluder::none;
      EXPECT_FALSE(is_behind) << "a visible landmark has nothing far before it";
    }
  }
  EXPECT_GT(empty, 0);
  EXPECT_LT(empty, 20);
}

TEST(Scenes, LittleOfTheHandIsHiddenByThings) {
  Manifest manifest = scene_manifest();
  manifest.scene.empty_share = 0;
  manifest.scene.before_share = 1;
  manifest.scene.least_visible = 0.7;
  int hidden = 0;
  for (const Frame& frame : frames_of(manifest, 0)) {
    const HandTruth& hand = frame.hands.front();
    hidden += std::ranges::count(hand.occluders, Occluder::object) > 0 ? 1 : 0;
    EXPECT_GE(hand.visible_share, 0.3) << "only the arm itself may hide more";
  }
  EXPECT_GT(hidden, 5);
}

TEST(Scenes, WithoutASceneNothingIsLabelled) {
  Manifest manifest = scene_manifest();
  manifest.scene = {};
  for (const Frame& frame : frames_of(manifest, 0)) {
    EXPECT_TRUE(frame.labels.empty());
    EXPECT_TRUE(frame.hands.empty());
  }
}

}  // namespace
}  // namespace knuckle
