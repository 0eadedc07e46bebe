// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/network_samples.h"

#include <algorithm>
#include <memory>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/progress.h"
#include "knuckle/data/defined_pose.h"
#include "knuckle/patch/cube_patch.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/prepare/sample_cutter.h"

namespace knuckle {
namespace {

constexpr double kFarthestCentreMm = 80.0;

/// Whether the definition has to say where landmarks lie: those of one's own are none that the truth has.
bool is_told_by_definition(const Convention& truth, const SampleOptions& options) {
  const auto is_of_22 = [](Landmark landmark) { return static_cast<int>(landmark) < kSupersetSize; };
  const auto is_unknown = [&](Landmark landmark) {
    return !is_of_22(landmark) && truth.index_of(landmark) < 0;
  };
  return options.definition && map_convention(truth, superset_convention()).missing.empty() &&
         std::ranges::any_of(options.convention.landmarks, is_unknown);
}

class HandCutter final : public SampleCutter {
 public:
  HandCutter(const std::string& source, const HandFinder& finder, const SampleOptions& options)
      : source_(open_source(source)), finder_(finder), hand_(finder.hand()), options_(options) {
    require_landmarks(*source_, options, source);
    frames_ = frames_for_samples(*source_, options, source);
    if (options.side) hand_.side = *options.side == HandSide::left ? "left" : "right";
  }

  std::int64_t frames() const override { return std::ssize(frames_); }

  Outcome cut(std::int64_t index, CubeSamples& to, std::int64_t place) const override {
    const Frame frame = as_right_hand(source_->read(frames_[static_cast<std::size_t>(index)]), hand_);
    const Projection projection(frame.camera);
    const HandPose truth = truth_of(frame, projection);
    const Point3 middle = projection.to_camera(mean_joint(truth));
    const std::optional<Point3> centre = truth.is_missing() ? std::nullopt : centre_of(frame, middle);
    if (!centre) return Outcome::without_hand;
    if ((*centre - middle).norm() > kFarthestCentreMm) return Outcome::off_centre;
    const auto crop = extract_cube(frame, projection.to_image(*centre), to.crop());
    if (!crop) return Outcome::without_hand;
    std::vector<PatchPoint> joints;
    for (const ImagePoint& joint : truth.joints) joints.push_back(crop->geometry.to_patch(joint));
    to.set(place, *crop, joints, *centre);
    return Outcome::used;
  }

 private:
  /// In the convention that is to be learned.
  HandPose truth_of(const Frame& frame, const Projection& projection) const {
    if (!frame.truth) return HandPose::missing(options_.convention);
    if (is_told_by_definition(frame.truth->convention, options_))
      return defined_pose(*options_.definition, *frame.truth, projection, HandSide::right);
    return converted(*frame.truth, options_.convention);
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

  std::unique_ptr<FrameSource> source_;
  std::vector<std::int64_t> frames_;
  const HandFinder& finder_;
  HandOptions hand_;
  SampleOptions options_;
};

}  // namespace

void require_landmarks(const FrameSource& source, const SampleOptions& options, std::string_view name) {
  if (!source.convention()) fail("{}: the source has no truth to train on", name);
  const Convention truth = *source.convention();
  if (is_told_by_definition(truth, options)) return;
  if (map_convention(truth, options.convention).shared.empty()) {
    fail("{}: its landmarks are those of {}, and none of them is one of {}, which the network learns", name,
         truth.name, options.convention.name);
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

std::unique_ptr<SampleCutter> hand_cutter(const std::string& source, const HandFinder& finder,
                                          const SampleOptions& options) {
  return std::make_unique<HandCutter>(source, finder, options);
}

void require_used(const SampleFrames& frames, std::string_view source) {
  if (frames.used() > 0) return;
  fail(
      "{}: no frame can be used: of {} frames {} have no labels or no hand that segmentation finds, and in "
      "{} "
      "it finds something else",
      source, frames.total, frames.without_hand, frames.off_centre);
}

NetworkSamples network_samples(const std::string& source, const HandFinder& finder,
                               const SampleOptions& options) {
  const HandCutter cutter(source, finder, options);
  Progress progress("samples", "frames", cutter.frames());
  NetworkSamples result = cut_samples(cutter, 0, cutter.frames(), options, progress);
  require_used(result.frames, source);
  return result;
}

}  // namespace knuckle
