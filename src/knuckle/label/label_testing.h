// SPDX-License-Identifier: Apache-2.0
// A hand that is computed, as a source of frames; for tests only.
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/hand/hand_flesh.h"
#include "knuckle/hand/skeleton_fit.h"
#include "knuckle/label/label_change.h"
#include "knuckle/label/label_estimate.h"

namespace knuckle::testing {

inline constexpr Camera kLabelCamera{.width = 160, .height = 120, .fx = 135, .fy = 137, .cx = 75, .cy = 60};

using LandmarkPoints = std::array<Point3, kSupersetSize>;

/// A right hand with bent fingers, its palm towards the camera [mm].
inline LandmarkPoints bent_hand_points(double bend, double size = 1.0) {
  SkeletonPose pose;
  for (int finger = 0; finger < 4; ++finger) {
    pose.angles[angles_of_finger(finger).mcp] = bend;
    pose.angles[angles_of_finger(finger).pip] = bend - 0.1 * finger;
    pose.angles[angles_of_finger(finger).dip] = coupled_dip(bend - 0.1 * finger);
  }
  pose.angles[HandAngle::thumb_radial] = 0.5;
  pose.angles[HandAngle::thumb_palmar] = 0.4;
  pose.size = size;
  pose.camera_from_hand.linear() = Eigen::DiagonalMatrix<double, 3>(-1.0, 1.0, -1.0);
  pose.camera_from_hand.translation() = Point3(10, -60, 500);
  return landmarks(adult_skeleton(), pose);
}

/// Its flesh, made of balls, before a wall.
inline Frame flesh_frame(const LandmarkPoints& points) {
  Frame frame;
  frame.camera = kLabelCamera;
  frame.depth_mm = Image<float>(kLabelCamera.width, kLabelCamera.height, 900.0f);
  const Projection projection(frame.camera);
  const double palm = (points[static_cast<std::size_t>(Landmark::middle_mcp)] - points[0]).norm();
  for (const HandFlesh& flesh : hand_flesh()) {
    for (double share = 0.0; share <= 1.0; share += 0.125) {
      const Point3 centre = (1.0 - share) * points[static_cast<std::size_t>(flesh.from)] +
                            share * points[static_cast<std::size_t>(flesh.to)];
      const double radius = ((1.0 - share) * flesh.radius_from + share * flesh.radius_to) * palm;
      for (int row = 0; row < frame.depth_mm.height(); ++row) {
        for (int column = 0; column < frame.depth_mm.width(); ++column) {
          const Point3 ray =
              projection.to_camera({static_cast<double>(column), static_cast<double>(row), 1.0}).normalized();
          const double along = ray.dot(centre);
          const double half = radius * radius - (centre.squaredNorm() - along * along);
          if (half <= 0.0) continue;
          const auto depth = static_cast<float>((along - std::sqrt(half)) * ray.z());
          float& pixel = frame.depth_mm(column, row);
          if (depth < pixel) pixel = depth;
        }
      }
    }
  }
  return frame;
}

inline HandPose pose_of_points(const LandmarkPoints& points) {
  HandPose pose = HandPose::missing(superset_convention());
  for (std::size_t i = 0; i < points.size(); ++i)
    pose.joints[i] = Projection(kLabelCamera).to_image(points[i]);
  return pose;
}

/// Mean distance of image points from landmarks [mm]; what is missing counts as 100 mm.
inline double mean_error_mm(const std::vector<ImagePoint>& points, const LandmarkPoints& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    sum += points[i].is_missing() ? 100.0 : (Projection(kLabelCamera).to_camera(points[i]) - truth[i]).norm();
  }
  return sum / kSupersetSize;
}

/// A hand that closes from frame to frame.
class ClosingHand final : public FrameSource {
 public:
  explicit ClosingHand(int frames) : frames_(frames) {}
  std::int64_t size() const override { return frames_; }
  LandmarkPoints truth(std::int64_t index) const {
    return bent_hand_points(0.2 + 0.06 * static_cast<double>(index));
  }
  Frame read(std::int64_t index) const override {
    Frame frame = flesh_frame(truth(index));
    frame.name = fmt::format("{:06}", index);
    return frame;
  }
  FrameLabel read_label(std::int64_t) const override { return {.camera = kLabelCamera, .truth = {}}; }
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  int frames_;
};

/// Estimates of its hand that are wrong by as much in every frame.
inline EstimateHands wrong_by_as_much(const ClosingHand& source) {
  return [&source](const Frame& frame) {
    HandPose pose = pose_of_points(source.truth(std::stoi(frame.name)));
    for (std::size_t i = 0; i < pose.joints.size(); ++i) {
      pose.joints[i].u += i % 2 == 0 ? 2.0 : -1.5;
      pose.joints[i].depth_mm += i % 3 == 0 ? 6.0 : -4.0;
    }
    return std::vector<EstimatedHand>{{HandSide::right, pose}};
  };
}

inline LabelHead closing_hand_head(int frames) {
  return {.source = "closing:hand",
          .fingerprint = "0123",
          .frames = frames,
          .convention = superset_convention(),
          .camera = kLabelCamera};
}

}  // namespace knuckle::testing
