// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/segmentation_forest_training.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/core/box.h"
#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/random.h"
#include "knuckle/forest/shared_places.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle {
namespace {

// Families of random streams that belong to one seed.
constexpr std::uint64_t kFrameStreams = 0;
constexpr std::uint64_t kPixelStreams = 1;

/// `count` of the elements, or all where there are fewer, drawn without replacement: the start of a random
/// permutation (Fisher and Yates).
template <class T>
void keep_random(std::vector<T>& elements, std::size_t count, Random& random) {
  count = std::min(count, elements.size());
  for (std::size_t i = 0; i < count; ++i) {
    std::swap(elements[i], elements[i + random.below(static_cast<std::uint32_t>(elements.size() - i))]);
  }
  elements.resize(count);
}

std::vector<std::int64_t> drawn_frames(std::int64_t total, const PixelSamplingOptions& options) {
  std::vector<std::int64_t> frames(static_cast<std::size_t>(total));
  std::iota(frames.begin(), frames.end(), std::int64_t{0});
  const auto count = static_cast<std::size_t>(std::lround(options.share * static_cast<double>(total)));
  Random random(derived_seed(options.seed, kFrameStreams));
  if (count < frames.size()) keep_random(frames, std::max<std::size_t>(count, 1), random);
  std::ranges::sort(frames);  // sources read neighbours faster
  return frames;
}

/// Adds what lies within `radius_mm` of the true wrist to the mask.
void add_wrist(Frame& frame, double radius_mm, const std::string& source) {
  const int index = frame.truth ? frame.truth->convention.index_of(Landmark::wrist) : -1;
  if (index < 0 || frame.truth->joints[static_cast<std::size_t>(index)].is_missing()) {
    fail("{}: frame {} has no true wrist, which wrist_mm asks for", source, frame.name);
  }
  const Projection projection(frame.camera);
  const ImagePoint& wrist = frame.truth->joints[static_cast<std::size_t>(index)];
  const Point3 centre = projection.to_camera(wrist);
  const double reach = radius_mm * projection.pixels_per_mm(std::max(1.0, centre.z() - radius_mm));
  const Box image{0, 0, frame.camera.width, frame.camera.height};
  const int side = static_cast<int>(2.0 * reach) + 3;
  const Box around = intersection(image, {static_cast<int>(std::floor(wrist.u - reach)) - 1,
                                          static_cast<int>(std::floor(wrist.v - reach)) - 1, side, side});
  for (int row = around.y; row < around.bottom(); ++row) {
    for (int column = around.x; column < around.right(); ++column) {
      const float depth = frame.depth_mm(column, row);
      if (!is_measured(depth)) continue;
      const Point3 point = projection.to_camera({double(column), double(row), depth});
      if ((point - centre).norm() < radius_mm) frame.mask(column, row) = 1;
    }
  }
}

std::vector<LabelledPixel> drawn_pixels(const Frame& frame, const PixelSamplingOptions& options,
                                        Random random) {
  std::vector<LabelledPixel> hand;
  std::vector<LabelledPixel> background;
  for (int row = 0; row < frame.depth_mm.height(); ++row) {
    for (int column = 0; column < frame.depth_mm.width(); ++column) {
      if (stored_depth(frame.depth_mm(column, row)) == kFarDepth) continue;
      const bool is_hand = frame.mask(column, row) != 0;
      (is_hand ? hand : background)
          .push_back({static_cast<std::int16_t>(column), static_cast<std::int16_t>(row),
                      static_cast<std::uint8_t>(is_hand ? 1 : 0)});
    }
  }
  keep_random(hand, static_cast<std::size_t>(options.hand_pixels), random);
  keep_random(background, static_cast<std::size_t>(options.background_pixels), random);
  hand.insert(hand.end(), background.begin(), background.end());
  return hand;
}

/// Reads the frames, on all threads.
PixelSamples collect(const FrameSource& source, std::span<const std::int64_t> frames,
                     const SegmentationForestTrainingConfig& config) {
  PixelSamples samples(std::ssize(frames));
  std::atomic<std::int64_t> bytes = 0;
  std::atomic<std::int64_t> pixels = 0;
  std::atomic<std::int64_t> images = 0;
  Progress progress("pixels", "frames", std::ssize(frames));
  parallel_for(std::ssize(frames), [&](std::int64_t i) {
    const std::int64_t number = frames[static_cast<std::size_t>(i)];
    Frame frame = source.read(number);
    if (frame.mask.empty()) fail("{}: frame {} has no mask to train on", config.source, frame.name);
    if (config.pixels.wrist_mm > 0.0) add_wrist(frame, config.pixels.wrist_mm, config.source);
    frame = as_right_hand(std::move(frame), config.hand);
    const Random random(derived_seed(config.pixels.seed, kPixelStreams), static_cast<std::uint64_t>(number));
    const std::vector<LabelledPixel> drawn = drawn_pixels(frame, config.pixels, random);
    bytes += static_cast<std::int64_t>(samples.set(i, frame.depth_mm, frame.camera, drawn));
    pixels += std::ssize(drawn);
    check_training_memory(static_cast<double>(bytes), ++images, pixels, config.forest);
    progress.advance();
  });
  return samples;
}

}  // namespace

void PixelSamplingOptions::visit(OptionVisitor& visitor) {
  visitor.real("share", share, open_closed(0, 1));
  visitor.integer("hand_pixels", hand_pixels, closed(1, 1e5));
  visitor.integer("background_pixels", background_pixels, closed(1, 1e5));
  visitor.real("wrist_mm", wrist_mm, closed(0, 200));
  visitor.seed("seed", seed);
}

SegmentationForestTrainingConfig SegmentationForestTrainingConfig::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  SegmentationForestTrainingConfig config;
  config.source = source_in(document, "source");
  document.table("hand").read(config.hand);
  document.table("pixels").read(config.pixels);
  document.table("forest").read(config.forest);
  document.finish();
  config.resolved_options = document.resolved_toml();
  return config;
}

SegmentationForestTraining run_training(const SegmentationForestTrainingConfig& config,
                                        const TrainingRun& run) {
  const auto source = open_source(config.source);
  const std::vector<std::int64_t> frames = drawn_frames(source->size(), config.pixels);
  const Stopwatch watch;
  const PixelSamples samples = collect(*source, frames, config);
  const double seconds = watch.milliseconds() / 1000.0;
  try {
    return {train_pixel_forest(samples, config.forest, run), std::ssize(frames), samples.sample_count(),
            samples.bytes(), seconds};
  } catch (const Error& error) {
    fail("{}: {}", config.source, error.what());
  }
}

std::optional<SegmentationForestTraining> run_training(const SegmentationForestTrainingConfig& config,
                                                       const TrainingRun& run, WorkerGroup& workers) {
  const auto source = open_source(config.source);
  const std::vector<std::int64_t> frames = drawn_frames(source->size(), config.pixels);
  const PartOfWork part = part_of_worker(std::ssize(frames), workers.rank(), workers.size());
  const Stopwatch watch;
  PixelSamples samples = collect(
      *source,
      std::span(frames).subspan(static_cast<std::size_t>(part.begin), static_cast<std::size_t>(part.size())),
      config);
  const double seconds = watch.milliseconds() / 1000.0;
  const std::int64_t pixels = sum_of_workers(workers, samples.sample_count()).total;
  try {
    auto forest = train_pixel_forest(workers, samples, part.begin, config.forest, run);
    if (!forest) return std::nullopt;
    return SegmentationForestTraining{std::move(*forest), std::ssize(frames), pixels, samples.bytes(),
                                      seconds};
  } catch (const Error& error) {
    fail("{}: {}", config.source, error.what());
  }
}

}  // namespace knuckle
