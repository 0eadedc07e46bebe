// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/thing_samples.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/random.h"
#include "knuckle/patch/cube_patch.h"
#include "knuckle/prepare/detector_samples.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle {
namespace {

constexpr double kFarFromHandsMm = 160.0;
constexpr DetectionOptions kAnythingLikeAHand{.min_score = 0.01};

class ThingFinder {
 public:
  ThingFinder(const Frame& frame, const HandDetector& detector, Random& random)
      : frame_(frame), detector_(detector), random_(random), hands_(hands_to_detect(frame)) {}

  std::optional<Point3> find() {
    const bool is_sought = random_.below(2) == 0;
    if (is_sought) {
      for (const DetectedHand& seen : detector_.detect(frame_, kAnythingLikeAHand)) {
        if (is_far_from_hands(seen.centre)) return seen.centre;
      }
    }
    return random_place();
  }

 private:
  bool is_far_from_hands(const Point3& place) const {
    return std::ranges::all_of(
        hands_, [&](const HandToDetect& hand) { return (hand.centre - place).norm() > kFarFromHandsMm; });
  }

  std::optional<Point3> random_place() {
    constexpr int kTries = 400;
    const Projection projection(frame_.camera);
    for (int i = 0; i < kTries; ++i) {
      const auto column = static_cast<int>(random_.below(static_cast<std::uint32_t>(frame_.camera.width)));
      const auto row = static_cast<int>(random_.below(static_cast<std::uint32_t>(frame_.camera.height)));
      const float depth = frame_.depth_mm(column, row);
      if (!is_measured(depth)) continue;
      const Point3 place = projection.to_camera({double(column), double(row), depth});
      if (is_far_from_hands(place)) return place;
    }
    return std::nullopt;
  }

  const Frame& frame_;
  const HandDetector& detector_;
  Random& random_;
  std::vector<HandToDetect> hands_;
};

class ThingCutter final : public SampleCutter {
 public:
  ThingCutter(const std::string& source, std::shared_ptr<const HandDetector> detector,
              const SampleOptions& options)
      : source_(open_source(source)),
        detector_(std::move(detector)),
        unknown_(static_cast<std::size_t>(options.convention.size()), PatchPoint{kNaN, kNaN, kNaN}) {
    if (!source_->convention()) fail("{}: the source has no truth to train on", source);
    frames_ = frames_for_samples(*source_, options, source);
  }

  std::int64_t frames() const override { return std::ssize(frames_); }

  Outcome cut(std::int64_t index, CubeSamples& to, std::int64_t place) const override {
    const Frame frame = source_->read(frames_[static_cast<std::size_t>(index)]);
    Random random(1, static_cast<std::uint64_t>(index));
    const std::optional<Point3> thing = ThingFinder(frame, *detector_, random).find();
    const auto crop =
        thing ? extract_cube(frame, Projection(frame.camera).to_image(*thing), to.crop()) : std::nullopt;
    if (!crop) return Outcome::without_hand;
    to.set(place, *crop, unknown_, *thing);
    return Outcome::used;
  }

 private:
  std::unique_ptr<FrameSource> source_;
  std::vector<std::int64_t> frames_;
  std::shared_ptr<const HandDetector> detector_;
  std::vector<PatchPoint> unknown_;
};

}  // namespace

std::unique_ptr<SampleCutter> thing_cutter(const std::string& source,
                                           std::shared_ptr<const HandDetector> detector,
                                           const SampleOptions& options) {
  return std::make_unique<ThingCutter>(source, std::move(detector), options);
}

void require_things(const SampleFrames& frames, std::string_view source) {
  if (frames.used() == 0) fail("{}: no frame shows anything but hands", source);
}

NetworkSamples thing_samples(const std::string& source, const HandDetector& detector,
                             const SampleOptions& options) {
  const std::shared_ptr<const HandDetector> borrowed(std::shared_ptr<void>(), &detector);
  const ThingCutter cutter(source, borrowed, options);
  Progress progress("things", "frames", cutter.frames());
  NetworkSamples result = cut_samples(cutter, 0, cutter.frames(), options, progress);
  require_things(result.frames, source);
  return result;
}

}  // namespace knuckle
