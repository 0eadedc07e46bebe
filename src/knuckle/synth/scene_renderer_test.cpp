// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene_renderer.h"

#include <set>

#include "knuckle/camera/projection.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/hand_collision.h"
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

TEST(Scenes, AnArmMayEndWithoutAHand) {
  Manifest manifest = scene_manifest();
  manifest.scene = {.sleeve_share = 0.5};
  const auto body = std::make_shared<const Body>(testing::box_arm_body());
  const auto with_hands = create_synthetic(manifest, body);
  manifest.scene.empty_share = 1;
  manifest.scene.stump_share = 1;
  const auto without_hands = create_synthetic(manifest, body);
  int arms = 0;
  for (int i = 0; i < manifest.frames; ++i) {
    const Frame frame = without_hands->read(i);
    EXPECT_TRUE(frame.hands.empty());
    EXPECT_TRUE(frame.truth->is_missing());
    EXPECT_EQ(std::ranges::count(frame.mask.pixels(), 1), 0);
    const Projection projection(frame.camera);
    const HandPose hand = *with_hands->read(i).truth;
    int seen = 0;
    for (int row = 0; row < frame.camera.height; ++row) {
      for (int column = 0; column < frame.camera.width; ++column) {
        const float depth = frame.depth_mm(column, row);
        if (depth <= 0.0f) continue;
        ++seen;
        const Point3 point = projection.to_camera({double(column), double(row), depth});
        for (const Landmark tip : {Landmark::index_tip, Landmark::middle_tip, Landmark::little_tip}) {
          const Point3 was = projection.to_camera(hand.joints[static_cast<std::size_t>(tip)]);
          EXPECT_GT((point - was).norm(), 20.0) << i << ": there is no finger any more";
        }
      }
    }
    arms += seen > 0 ? 1 : 0;
  }
  EXPECT_GT(arms, manifest.frames / 2);
}

TEST(Scenes, ArmsThatHaveAHandStayAsTheyAre) {
  Manifest manifest = scene_manifest();
  manifest.scene = {.empty_share = 0.5};
  const auto body = std::make_shared<const Body>(testing::box_arm_body());
  const auto before = create_synthetic(manifest, body);
  manifest.scene.stump_share = 0.5;
  const auto with_stumps = create_synthetic(manifest, body);
  int arms = 0;
  for (int i = 0; i < manifest.frames; ++i) {
    const Frame frame = with_stumps->read(i);
    const Image<float> was = before->read(i).depth_mm;
    const bool is_same = frame.depth_mm == was;
    EXPECT_TRUE(is_same || frame.hands.empty()) << i;
    arms += is_same ? 0 : 1;
  }
  EXPECT_GT(arms, 5) << "half of some 30 empty frames";
  EXPECT_LT(arms, 25);
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

TEST(Scenes, ASecondHandIsOfTheOtherSideAndApart) {
  Manifest manifest = scene_manifest();
  manifest.frames = 40;
  manifest.scene = {.second_share = 1.0, .crossed_share = 0.3, .touching_share = 0.4};
  int seconds = 0;
  int touching = 0;
  for (const Frame& frame : frames_of(manifest, 0)) {
    if (frame.hands.size() < 2) continue;
    ++seconds;
    EXPECT_NE(frame.hands[0].side, frame.hands[1].side);
    EXPECT_EQ(frame.side, frame.hands[0].side);
    std::array<std::array<Point3, kSupersetSize>, 2> landmarks;
    const Projection projection(frame.camera);
    for (int h = 0; h < 2; ++h) {
      for (int k = 0; k < kSupersetSize; ++k)
        landmarks[h][k] = projection.to_camera(frame.hands[h].pose.joints[k]);
    }
    const double gap = gap_of_hands_mm(hand_capsules(landmarks[0]), hand_capsules(landmarks[1]));
    EXPECT_GT(gap, -2.5);
    touching += gap < 3.0 ? 1 : 0;
    const auto second =
        std::ranges::count(frame.labels.pixels(), static_cast<std::uint8_t>(PixelLabel::other_hand));
    EXPECT_EQ(second > 0, frame.hands[1].visible_share > 0.0);
  }
  EXPECT_GT(seconds, 12) << "of 40; some lie outside the picture or hide the first";
  EXPECT_GT(touching, 2);
}

TEST(Scenes, TheSecondHandIsDrawnWhereItsLandmarksAre) {
  Manifest manifest = scene_manifest();
  manifest.frames = 40;
  manifest.scene = {.second_share = 1.0, .crossed_share = 0.0, .touching_share = 0.0};
  int checked = 0;
  int beside = 0;
  for (const Frame& frame : frames_of(manifest, 0)) {
    if (frame.hands.size() < 2) continue;
    const HandTruth& hand = frame.hands[1];
    for (int k = 0; k < kSupersetSize; ++k) {
      if (hand.occluders[k] != Occluder::none) continue;
      const auto column = static_cast<int>(std::floor(hand.pose.joints[k].u + 0.5));
      const auto row = static_cast<int>(std::floor(hand.pose.joints[k].v + 0.5));
      if (frame.labels(column, row) != static_cast<std::uint8_t>(PixelLabel::other_hand)) continue;
      ++checked;
      const double below = hand.pose.joints[k].depth_mm - frame.depth_mm(column, row);
      beside += below > -3.0 && below < 60.0 ? 0 : 1;  // a coarse pixel may show what is beside a thin finger
    }
  }
  EXPECT_GT(checked, 60);
  EXPECT_LT(10 * beside, checked) << "landmarks lie below the skin";
}

TEST(Scenes, ThingsStandStillInASequence) {
  Manifest manifest = scene_manifest();
  manifest.frames = 24;
  manifest.motion.motion = "smooth";
  manifest.motion.sequence_frames = 12;
  manifest.placement.above_share = 3;
  manifest.scene = {.room_share = 1, .table_share = 1, .most_things = 4};
  const std::vector<Frame> frames = frames_of(manifest, 0);
  EXPECT_EQ(frames[11].sequence, 0);
  EXPECT_EQ(frames[12].sequence, 1);
  const auto is_object = [](const Frame& frame, std::size_t i) {
    return frame.labels.data()[i] == static_cast<std::uint8_t>(PixelLabel::object);
  };
  for (int sequence = 0; sequence < 2; ++sequence) {
    const Frame& first = frames[12 * sequence];
    for (int i = 1; i < 12; ++i) {
      const Frame& frame = frames[12 * sequence + i];
      for (std::size_t p = 0; p < frame.labels.size(); ++p) {
        if (!is_object(first, p) || !is_object(frame, p)) continue;
        EXPECT_EQ(first.depth_mm.data()[p], frame.depth_mm.data()[p]);
      }
    }
  }
  EXPECT_NE(frames[0].depth_mm, frames[12].depth_mm);
}

Point3 palm_in_camera(const HandTruth& hand, const Camera& camera) {
  return Projection(camera).to_camera(hand.pose.joints[static_cast<std::size_t>(Landmark::palm)]);
}

TEST(Scenes, ASecondHandGoesPastTheFirstAndBack) {
  Manifest manifest = scene_manifest();
  constexpr int kFrames = 24;
  manifest.frames = 8 * kFrames;
  manifest.motion.motion = "smooth";
  manifest.motion.sequence_frames = kFrames;
  manifest.motion.sway_deg = 0.0;
  manifest.scene = {.room_share = 1,
                    .most_things = 4,
                    .second_share = 1,
                    .crossed_share = 1,
                    .touching_share = 0,
                    .second_pass_frames = kFrames};
  const std::vector<Frame> frames = frames_of(manifest, 0);
  int checked = 0;
  for (int sequence = 0; sequence < 8; ++sequence) {
    std::array<std::optional<Point3>, kFrames> palms;
    for (int i = 0; i < kFrames; ++i) {
      const Frame& frame = frames[static_cast<std::size_t>(kFrames * sequence + i)];
      if (frame.hands.size() > 1)
        palms[static_cast<std::size_t>(i)] = palm_in_camera(frame.hands[1], frame.camera);
    }
    if (!palms[0] || !palms[6] || !palms[12]) continue;
    ++checked;
    const Eigen::Vector3d way = *palms[12] - *palms[0];
    EXPECT_GT(way.norm(), 290.0);
    EXPECT_LT(way.norm(), 510.0);
    EXPECT_LT((0.5 * (*palms[0] + *palms[12]) - *palms[6]).norm(), 0.5) << "a quarter is the middle";
    if (palms[18]) {
      EXPECT_LT((*palms[18] - *palms[6]).norm(), 0.5) << "it comes back the same way";
    }
  }
  EXPECT_GT(checked, 0);
}

TEST(Scenes, ASecondHandThatTouchesComesAndGoesBack) {
  Manifest manifest = scene_manifest();
  constexpr int kFrames = 12;
  manifest.frames = 10 * kFrames;
  manifest.motion.motion = "smooth";
  manifest.motion.sequence_frames = kFrames;
  manifest.motion.sway_deg = 0.0;
  manifest.pose = {};
  manifest.scene = {
      .second_share = 1, .crossed_share = 0, .touching_share = 1, .second_pass_frames = kFrames};
  int touching = 0;
  for (const Frame& frame : frames_of(manifest, 0)) {
    if (frame.hands.size() < 2) continue;
    std::array<std::array<Point3, kSupersetSize>, 2> landmarks;
    const Projection projection(frame.camera);
    for (int h = 0; h < 2; ++h) {
      for (int k = 0; k < kSupersetSize; ++k)
        landmarks[h][k] = projection.to_camera(frame.hands[h].pose.joints[k]);
    }
    const double gap = gap_of_hands_mm(hand_capsules(landmarks[0]), hand_capsules(landmarks[1]));
    EXPECT_GT(gap, -12.0);
    touching += gap < 5.0 ? 1 : 0;
  }
  EXPECT_GT(touching, 1);
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
