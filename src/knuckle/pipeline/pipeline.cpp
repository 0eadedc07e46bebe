// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/pipeline.h"

#include <algorithm>
#include <functional>

#include "knuckle/core/error.h"
#include "knuckle/estimate/create_estimator.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/refine/refiner_factory.h"
#include "knuckle/segment/hand_region.h"

namespace knuckle {
namespace {

HandPose pose_in_image(const PatchPose& pose, const Convention& convention, const PatchGeometry& geometry) {
  HandPose result{convention, {}, pose.confidence};
  for (const PatchPoint& joint : pose.joints) result.joints.push_back(geometry.to_image(joint));
  return result;
}

/// Calls `work`, adds the time it took to `total_ms`, and returns what it returned.
template <class Work>
auto timed(double& total_ms, const Work& work) {
  const Stopwatch watch;
  auto result = work();
  total_ms += watch.milliseconds();
  return result;
}

/// What the file says of patches must be what the model was trained on.
void check_patch_options(const OptionTable& document, const Estimator& estimator) {
  const PatchOptions trained = estimator.patch_options();
  PatchOptions options = trained;
  const OptionTable table = document.table("patch");
  table.read(options);
  if (options.size_px != trained.size_px) {
    table.fail_at("size_px", fmt::format("is {}, but the model was trained on patches of {} px",
                                         options.size_px, trained.size_px));
  }
  if (options.mode != trained.mode) {
    table.fail_at("mode", fmt::format("is \"{}\", but the model was trained on patches of the mode \"{}\"",
                                      options.mode, trained.mode));
  }
  if (options.cube_mm != trained.cube_mm) {
    table.fail_at("cube_mm", fmt::format("is {}, but the model was trained on cubes of {} mm",
                                         options.cube_mm, trained.cube_mm));
  }
}

PipelineParts parts_from(const OptionTable& document) {
  PipelineParts parts{HandFinder(document), create_estimator(document.table("estimator"))};
  check_patch_options(document, *parts.estimator);
  for (const OptionTable& table : document.tables("refine")) parts.refiners.push_back(create_refiner(table));
  return parts;
}

/// The mean of the joints that are known; missing where none is.
ImagePoint mean_joint(const HandPose& pose) {
  ImagePoint sum{0.0, 0.0, 0.0};
  int count = 0;
  for (const ImagePoint& joint : pose.joints) {
    if (joint.is_missing()) continue;
    sum = {sum.u + joint.u, sum.v + joint.v, sum.depth_mm + joint.depth_mm};
    ++count;
  }
  return {sum.u / count, sum.v / count, sum.depth_mm / count};
}

/// The mean of a pose's confidences; 1 where the method gives none, and so no reason to doubt.
double mean_confidence(const HandPose& pose) {
  if (pose.confidence.empty()) return 1.0;
  double sum = 0.0;
  for (const float confidence : pose.confidence) sum += confidence;
  return sum / static_cast<double>(pose.confidence.size());
}

/// Two regions whose centres are nearer than that are the same thing: no two palms can be.
constexpr double kSamePlaceMm = 50.0;

}  // namespace

Pipeline::Pipeline(PipelineParts parts)
    : finder_(std::move(parts.finder)),
      estimator_(std::move(parts.estimator)),
      refiners_(std::move(parts.refiners)) {
  if (!estimator_) fail("a pipeline was to be made without an estimator");
  if (!std::ranges::all_of(refiners_, [](const auto& refiner) { return refiner != nullptr; })) {
    fail("one of the pipeline's refiners is missing");
  }
  extractor_ = std::make_unique<PatchExtractor>(estimator_->patch_options(), estimator_->patch_statistics());
}

Pipeline Pipeline::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  Pipeline pipeline(parts_from(document));
  document.finish();
  pipeline.resolved_options_ = document.resolved_toml();
  return pipeline;
}

FrameEstimate Pipeline::estimate(const Frame& frame) const {
  return estimate(frame, {.max_hands = finder_.hand().max_hands});
}

FrameEstimate Pipeline::estimate(const Frame& frame, const Search& search) const {
  if (!finder_.hand().is_left()) return estimate_right(frame, search);
  FrameEstimate result =
      estimate_right(mirrored(frame), {mirrored(search.start), search.elsewhere, search.max_hands});
  for (HandEstimate& hand : result.hands) {
    hand = {mirrored(std::move(hand.region), frame.camera.width), mirrored(hand.pose, frame.camera.width),
            hand.score, HandSide::left};
  }
  return result;
}

FrameEstimate Pipeline::estimate_right(const Frame& frame, const Search& search) const {
  const bool looks_elsewhere = search.elsewhere.value_or(!search.start);
  const int max_hands = looks_elsewhere ? search.max_hands : 1;
  FrameEstimate result;
  Segmentation segmentation =
      timed(result.times.segment_ms, [&] { return finder_.find_right(frame, search.start, max_hands); });
  add_hands(frame, std::move(segmentation.hands), result);
  const auto is_sure = [&](const HandEstimate& hand) { return this->is_sure(hand); };
  if (looks_elsewhere && !std::ranges::all_of(result.hands, is_sure)) {
    try_candidates(frame, max_hands, result);
  }
  std::ranges::stable_sort(result.hands, std::ranges::greater{}, &HandEstimate::score);
  result.status = segmentation.reason;
  if (result.hands.empty() && result.status.empty()) result.status = "the hand has no measured pixel";
  if (search.start && std::ranges::none_of(result.hands, is_sure) && !result.hands.empty()) {
    result.status = kUnsure;
  }
  return result;
}

bool Pipeline::is_sure(const HandEstimate& hand) const {
  return hand.score >= finder_.hand().sure_confidence;
}

void Pipeline::add_hands(const Frame& frame, std::vector<HandRegion> regions, FrameEstimate& result) const {
  for (HandRegion& region : regions) {
    if (auto pose = pose_of(frame, region, result.times)) {
      const double score = mean_confidence(*pose);
      result.hands.push_back({std::move(region), std::move(*pose), score, HandSide::right});
    }
  }
}

void Pipeline::try_candidates(const Frame& frame, int max_hands, FrameEstimate& result) const {
  const int candidates = finder_.hand().candidates;
  if (candidates <= max_hands) return;
  Segmentation others =
      timed(result.times.segment_ms, [&] { return finder_.find_right(frame, std::nullopt, candidates); });
  std::erase_if(others.hands, [&](const HandRegion& other) {
    return std::ranges::any_of(result.hands, [&](const HandEstimate& tried) {
      return (tried.region.centre - other.centre).norm() < kSamePlaceMm;
    });
  });
  const std::size_t wanted = result.hands.size();
  add_hands(frame, std::move(others.hands), result);
  std::ranges::stable_sort(result.hands, std::ranges::greater{}, &HandEstimate::score);
  result.hands.resize(std::min(result.hands.size(), wanted));
}

std::optional<HandPose> Pipeline::pose_of(const Frame& frame, const HandRegion& region,
                                          StageTimes& times) const {
  auto patch = timed(times.patch_ms, [&] { return extractor_->extract(frame, region); });
  if (!patch) return std::nullopt;
  HandPose pose = pose_in_patch(*patch, times);
  for (int pass = 1; pass < estimator_->passes(); ++pass) {
    patch = timed(times.patch_ms, [&] { return extractor_->extract_around(frame, mean_joint(pose)); });
    if (!patch) break;
    pose = pose_in_patch(*patch, times);
  }
  return timed(times.refine_ms, [&] {
    for (const auto& refiner : refiners_) pose = refiner->refine(frame, region, std::move(pose));
    return std::move(pose);
  });
}

HandPose Pipeline::pose_in_patch(const HandPatch& patch, StageTimes& times) const {
  return timed(times.estimate_ms, [&] {
    return pose_in_image(estimator_->estimate(patch), estimator_->convention(), patch.geometry);
  });
}

}  // namespace knuckle
