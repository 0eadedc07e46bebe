// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "knuckle/estimate/estimator.h"
#include "knuckle/patch/patch_extractor.h"
#include "knuckle/pipeline/hand_finder.h"
#include "knuckle/refine/refiner.h"

namespace knuckle {

/// Wall time of each stage [ms].
struct StageTimes {
  double segment_ms = 0.0;
  double patch_ms = 0.0;
  double estimate_ms = 0.0;
  double refine_ms = 0.0;

  double total_ms() const { return segment_ms + patch_ms + estimate_ms + refine_ms; }
};

/// One hand of a frame: where it is, and its pose in the frame's image coordinates.
struct HandEstimate {
  HandRegion region;
  HandPose pose;
};

/// What a pipeline sees in a frame. No hand is an answer, not an error.
struct FrameEstimate {
  std::vector<HandEstimate> hands;  ///< best first
  std::string reason;               ///< why there is no hand; empty where there is one
  StageTimes times;
};

/// What a pipeline is put together from: stages that come with Knuckle, or your own (docs/extending.md).
struct PipelineParts {
  HandFinder finder;
  std::unique_ptr<Estimator> estimator;
  std::vector<std::unique_ptr<Refiner>> refiners = {};  ///< in the order in which they work; none is fine
};

/// The paper's framework (its Figure 1): segment, crop, estimate, refine.
class Pipeline {
 public:
  /// The pipeline that a file describes. Throws an Error that names file, line and key where the file, or a
  /// model that it names, is wrong.
  static Pipeline load(const std::filesystem::path& path);

  /// A pipeline of these parts; patches are made as the estimator asks for. Throws an Error where a part is
  /// missing (null).
  explicit Pipeline(PipelineParts parts);

  /// The convention of all poses: the model's.
  Convention convention() const { return estimator_->convention(); }

  const HandOptions& hand() const { return finder_.hand(); }

  /// The pipeline file with all defaults filled in; empty where there was no file.
  const std::string& resolved_options() const { return resolved_options_; }

  /// Finds the hands of a frame and their poses. `start`, where given, is where to look for the hand, in
  /// camera coordinates [mm]. Where a pose is not sure (`HandOptions::candidates`), other places are tried,
  /// and the surest poses are kept: the nearest thing may be an elbow. Safe to call from many threads.
  FrameEstimate estimate(const Frame& frame, const std::optional<Point3>& start = std::nullopt) const;

 private:
  FrameEstimate estimate_right(const Frame& frame, const std::optional<Point3>& start) const;
  void add_hands(const Frame& frame, std::vector<HandRegion> regions, FrameEstimate& result) const;
  void try_candidates(const Frame& frame, FrameEstimate& result) const;
  std::optional<HandPose> pose_of(const Frame& frame, const HandRegion& region, StageTimes& times) const;
  HandPose pose_in_patch(const HandPatch& patch, StageTimes& times) const;

  std::string resolved_options_;
  HandFinder finder_;
  std::unique_ptr<Estimator> estimator_;
  std::unique_ptr<PatchExtractor> extractor_;
  std::vector<std::unique_ptr<Refiner>> refiners_;
};

}  // namespace knuckle
