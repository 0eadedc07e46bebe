// SPDX-License-Identifier: Apache-2.0
// A world that says where its hands are, and a pipeline that sees it, for tests of the tracker only.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "knuckle/camera/projection.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/segment/testing.h"
#include "knuckle/track/tracker.h"

namespace knuckle::testing {

inline constexpr double kDepthMm = 600.0;

/// The same in a mirror.
inline Camera symmetric_camera() {
  Camera camera = quarter_vga_camera();
  camera.cx = 159.5;
  return camera;
}

/// A hand that is really there, as a right or left one.
struct TrueHand {
  Point3 middle{0, 0, kDepthMm};
  HandSide side = HandSide::right;
  float confidence = 0.9f;
};

/// What stubs of segmentation and estimation see: not the images.
struct World {
  std::vector<TrueHand> hands;
  double noise_mm = 0.0;
  double turned_rad = 0.0;  // how the estimator sees all hands, around the line of sight
  double size = 1.0;
  int searches = 0;  // of all of a frame
  int looks = 0;     // of the estimator
  std::function<void()> while_searching = [] {};
  std::function<bool(const Frame&, const std::optional<Point3>&, const TrueHand&)> is_found =
      [](const Frame&, const std::optional<Point3>&, const TrueHand&) { return true; };
  Random random{5};
};

/// Finds the true hands: those within 120 mm of a start, the nearest first, or all of them.
class TrueSegmenter final : public Segmenter {
 public:
  explicit TrueSegmenter(World& world) : world_(world) {}
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override {
    Segmentation found;
    world_.searches += start ? 0 : 1;
    world_.while_searching();
    std::vector<TrueHand> hands = world_.hands;
    const auto distance = [&](const TrueHand& hand) { return (hand.middle - *start).norm(); };
    if (start) std::ranges::stable_sort(hands, {}, distance);
    for (const TrueHand& hand : hands) {
      if (start && (hand.middle - *start).norm() > 120.0) continue;
      if (!world_.is_found(frame, start, hand)) continue;
      if (std::ssize(found.hands) == max_hands) break;
      HandRegion region;
      region.box = {0, 0, 1, 1};
      region.mask = Image<std::uint8_t>(1, 1, 1);
      region.centre = hand.middle;
      region.score = 1.0;
      region.side = hand.side;
      found.hands.push_back(region);
    }
    if (found.hands.empty()) found.reason = "nothing there";
    return found;
  }

 private:
  World& world_;
};

/// Sees an adult's straight hand around the patch's centre, with noise.
class StraightEstimator final : public Estimator {
 public:
  explicit StraightEstimator(World& world) : world_(world) {}
  Convention convention() const override { return superset_convention(); }
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch& patch) const override {
    ++world_.looks;
    const Projection projection(symmetric_camera());
    const Point3 centre = projection.to_camera(patch.geometry.to_image({0, 0, 0}));
    const auto points =
        landmarks(scaled(adult_skeleton(), world_.size), HandAngles{}, RigidTransform::Identity());
    Point3 mean = Point3::Zero();
    for (const Point3& point : points) mean += point / static_cast<double>(points.size());
    PatchPose pose;
    const Eigen::AngleAxisd turn(world_.turned_rad, Eigen::Vector3d::UnitZ());
    for (const Point3& point : points) {
      const Point3 noise(world_.random.normal(), world_.random.normal(), world_.random.normal());
      pose.joints.push_back(patch.geometry.to_patch(
          projection.to_image(centre + turn * (point - mean) + world_.noise_mm * noise)));
      pose.confidence.push_back(confidence_at(centre));
    }
    return pose;
  }

 private:
  float confidence_at(const Point3& centre) const {
    for (const TrueHand& hand : world_.hands) {
      const Point3 mirrored(-hand.middle.x(), hand.middle.y(), kDepthMm);
      if ((hand.middle - centre).norm() < 10.0 || (mirrored - centre).norm() < 10.0) return hand.confidence;
    }
    return 0.1f;
  }

  World& world_;
  PatchExtractor patches_{{.size_px = 32, .mode = "cube", .cube_mm = 250.0}};
};

class TrackerTest : public ::testing::Test {
 protected:
  Pipeline pipeline(int max_hands, double confidence_offset = 0.0) {
    return Pipeline(
        {HandFinder(std::make_unique<TrueSegmenter>(world_), {.side = "auto",
                                                              .max_hands = max_hands,
                                                              .sure_confidence = 0.45,
                                                              .confidence_offset = confidence_offset}),
         std::make_unique<StraightEstimator>(world_)});
  }
  Frame frame_at(double time_s) const {
    Frame frame = blank_frame(symmetric_camera());
    std::ranges::fill(frame.depth_mm.pixels(), static_cast<float>(kDepthMm));
    frame.time_s = time_s;
    return frame;
  }
  /// Whether the frame still shows what is at a hand's middle: it does not, once the hand is taken away.
  static bool shows(const Frame& frame, const TrueHand& hand) {
    const ImagePoint at = Projection(frame.camera).to_image(hand.middle);
    return is_measured(
        frame.depth_mm(static_cast<int>(std::round(at.u)), static_cast<int>(std::round(at.v))));
  }
  static Point3 middle_of(const TrackedHand& hand) {
    return Projection(symmetric_camera()).to_camera(mean_joint(hand.pose));
  }

  World world_;
};

}  // namespace knuckle::testing
