// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/network_samples.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/patch/cube_patch.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle {
namespace {

constexpr double kFarthestCentreMm = 80.0;

class SampleCollector {
 public:
  SampleCollector(const FrameSource& source, std::vector<std::int64_t> frames, const HandFinder& finder,
                  const SampleOptions& options)
      : source_(source),
        frames_(std::move(frames)),
        finder_(finder),
        hand_(finder.hand()),
        options_(options),
        count_(std::ssize(frames_)),
        samples_(count_, options.convention.size(), options.patch, options.crop_px) {
    if (options.side) hand_.side = *options.side == HandSide::left ? "left" : "right";
  }

  NetworkSamples collect() && {
    Progress progress("samples", "frames", count_);
    parallel_for(count_, [&](std::int64_t i) {
      add(i, source_.read(frames_[static_cast<std::size_t>(i)]));
      progress.advance();
    });
    samples_.finish();
    return {std::move(samples_), {count_, without_hand_, off_centre_}};
  }

 private:
  void add(std::int64_t index, Frame frame) {
    frame = as_right_hand(std::move(frame), hand_);
    const HandPose truth =
        frame.truth ? converted(*frame.truth, options_.convention) : HandPose::missing(options_.convention);
    const Projection projection(frame.camera);
    const Point3 middle = projection.to_camera(mean_joint(truth));
    const std::optional<Point3> centre = truth.is_missing() ? std::nullopt : centre_of(frame, middle);
    if (!centre) {
      ++without_hand_;
      return;
    }
    if ((*centre - middle).norm() > kFarthestCentreMm) {
      ++off_centre_;
      return;
    }
    const auto crop = extract_cube(frame, projection.to_image(*centre), samples_.crop());
    if (!crop) {
      ++without_hand_;
      return;
    }
    std::vector<PatchPoint> joints;
    for (const ImagePoint& joint : truth.joints) joints.push_back(crop->geometry.to_patch(joint));
    samples_.set(index, *crop, joints, *centre);
  }

  /// Where segmentation finds the hand.
  std::optional<Point3> centre_of(const Frame& frame, const Point3& middle) const {
    if (options_.around_joints) return middle;
    if (options_.start == Start::nearest) {
      const Segmentation found = finder_.find_right(frame, std::nullopt);
      const bool is_found =
          !found.hands.empty() && (found.hands.front().centre - middle).norm() <= kFarthestCentreMm;
      if (is_found) return found.hands.front().centre;
    }
    const Segmentation found = finder_.find_right(frame, true_start(frame));
    if (found.hands.empty()) return std::nullopt;
    return found.hands.front().centre;
  }

  const FrameSource& source_;
  std::vector<std::int64_t> frames_;
  const HandFinder& finder_;
  HandOptions hand_;
  const SampleOptions& options_;
  std::int64_t count_;
  CubeSamples samples_;
  std::atomic<std::int64_t> without_hand_ = 0;
  std::atomic<std::int64_t> off_centre_ = 0;
};

}  // namespace

void require_shared_landmarks(const FrameSource& source, const Convention& convention,
                              std::string_view name) {
  if (!source.convention()) fail("{}: the source has no truth to train on", name);
  if (map_convention(*source.convention(), convention).shared.empty()) {
    fail("{}: its landmarks are those of {}, and none of them is one of {}, which the network learns", name,
         source.convention()->name, convention.name);
  }
}

std::vector<std::int64_t> frames_for_samples(const FrameSource& source, const SampleOptions& options,
                                             std::string_view name) {
  const std::vector<std::int64_t> part = frames_of_part(source, options.holdout, name);
  const std::int64_t all = std::ssize(part);
  const std::int64_t count = options.most > 0 ? std::min(options.most, all) : all;
  std::vector<std::int64_t> frames;
  frames.reserve(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) frames.push_back(part[static_cast<std::size_t>(i * all / count)]);
  return frames;
}

NetworkSamples network_samples(const std::string& source_name, const HandFinder& finder,
                               const SampleOptions& options) {
  const auto source = open_source(source_name);
  require_shared_landmarks(*source, options.convention, source_name);
  std::vector<std::int64_t> frames = frames_for_samples(*source, options, source_name);
  NetworkSamples result = SampleCollector(*source, std::move(frames), finder, options).collect();
  if (result.frames.used() == 0) {
    fail(
        "{}: no frame can be used: of {} frames {} have no labels or no hand that segmentation finds, and in "
        "{} "
        "it finds something else",
        source_name, result.frames.total, result.frames.without_hand, result.frames.off_centre);
  }
  return result;
}

}  // namespace knuckle
