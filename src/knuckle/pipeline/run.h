// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/data/frame_source.h"
#include "knuckle/pipeline/pipeline.h"

namespace knuckle {

/// Where segmentation starts in each frame.
enum class Start {
  nearest,  ///< where the method chooses: at the nearest point
  truth,    ///< at the true palm (`true_start`); an error in a source without truth
};

/// The names of the two, for the command line.
inline constexpr std::string_view kStartNames[] = {"nearest", "truth"};
/// Throws an Error where the name is none of the two.
Start start_from_name(std::string_view name);

/// The start in one frame; nothing for `nearest`, and for a frame whose truth knows no joint.
std::optional<Point3> start_in(const Frame& frame, Start start);

/// The best hand of one frame.
struct FrameSegmentation {
  bool found = false;
  Box box;  ///< empty where nothing was found
  double milliseconds = 0.0;
  /// Pixels in common with the true mask, and in either; nothing where the source has no masks.
  struct MaskOverlap {
    std::int64_t in_both = 0;
    std::int64_t in_either = 0;
    /// Intersection over union, [0, 1]; 1 where both are empty.
    double iou() const;
  };
  std::optional<MaskOverlap> mask;
};

/// Segments all frames of a source on all threads. Throws an Error that names the source where it has no
/// truth to start from.
std::vector<FrameSegmentation> segment_all(const FrameSource& source, const HandFinder& finder, Start start,
                                           std::string_view source_name);

/// CSV with the columns frame,found,x,y,width,height,milliseconds; frames count from 0.
std::string boxes_csv(std::span<const FrameSegmentation> frames);
/// Source, counts, median time and, where there are true masks, their pixel IoU: the mean and median of the
/// frames, and that of all pixels together.
std::string summary_json(std::span<const FrameSegmentation> frames, std::string_view source_name);

/// Runs the pipeline on all frames of a source on all threads.
std::vector<FrameEstimate> estimate_all(const FrameSource& source, const Pipeline& pipeline, Start start,
                                        std::string_view source_name);

/// The poses of the `rank`-th best hand of each frame (0 is the best); missing where a frame has fewer.
std::vector<HandPose> poses_of(std::span<const FrameEstimate> frames, const Convention& convention,
                               int rank = 0);

/// The median time that the pipeline took for a frame [ms].
double median_ms(std::span<const FrameEstimate> frames);

/// Source, convention, counts, median times of each stage, the frames without a hand with the reason why, and
/// for each frame the confidences of the best hand's joints (null where there are none); those of other hands
/// under `confidence.hand2` and so on.
std::string summary_json(std::span<const FrameEstimate> frames, std::string_view source_name,
                         const Convention& convention);

}  // namespace knuckle
