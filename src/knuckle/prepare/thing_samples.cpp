// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/thing_samples.h"

#include <algorithm>
#include <atomic>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
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
      : frame_(frame), detector_(detector), random_(random), hands_(labelled_hands(frame)) {}

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
        hands_, [&](const LabelledHand& hand) { return (hand.centre - place).norm() > kFarFromHandsMm; });
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
  std::vector<LabelledHand> hands_;
};

}  // namespace

NetworkSamples thing_samples(const std::string& source_name, const HandDetector& detector,
                             const SampleOptions& options) {
  const auto source = open_source(source_name);
  if (!source->convention()) fail("{}: the source has no truth to train on", source_name);
  const std::vector<std::int64_t> frames = frames_for_samples(*source, options, source_name);
  const std::int64_t count = std::ssize(frames);
  CubeSamples samples(count, options.convention.size(), options.patch, options.crop_px);
  const std::vector<PatchPoint> unknown(static_cast<std::size_t>(options.convention.size()),
                                        PatchPoint{kNaN, kNaN, kNaN});
  std::atomic<std::int64_t> without = 0;
  Progress progress("things", "frames", count);
  parallel_for(count, [&](std::int64_t i) {
    const Frame frame = source->read(frames[static_cast<std::size_t>(i)]);
    Random random(1, static_cast<std::uint64_t>(i));
    const std::optional<Point3> place = ThingFinder(frame, detector, random).find();
    const auto crop =
        place ? extract_cube(frame, Projection(frame.camera).to_image(*place), samples.crop()) : std::nullopt;
    if (crop) {
      samples.set(i, *crop, unknown, *place);
    } else {
      ++without;
    }
    progress.advance();
  });
  samples.finish();
  if (samples.size() == 0) fail("{}: no frame shows anything but hands", source_name);
  return {std::move(samples), {count, without, 0}};
}

}  // namespace knuckle
