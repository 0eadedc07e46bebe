// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/data/frame_source.h"
#include "knuckle/pipeline/hand_finder.h"
#include "knuckle/pipeline/start.h"

namespace knuckle {

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

/// Takes what was found in a frame; called in the order of the frames, one at a time.
using TakeSegmentation = std::function<void(const FrameSegmentation&)>;

/// Segments all frames of a source on all threads in bounded memory. Throws an Error that names the source
/// where it has no truth to start from, and the fault of the first frame that cannot be read; Interrupted
/// where the program is asked to end.
void segment_each(const FrameSource& source, const HandFinder& finder, Start start,
                  std::string_view source_name, const TakeSegmentation& take);

/// The same, with progress; keeps what was found.
std::vector<FrameSegmentation> segment_all(const FrameSource& source, const HandFinder& finder, Start start,
                                           std::string_view source_name);

/// CSV with the columns frame,found,x,y,width,height,milliseconds; frames count from 0.
std::string boxes_csv(std::span<const FrameSegmentation> frames);
/// Source, counts, median time and, where there are true masks, their pixel IoU: the mean and median of the
/// frames, and that of all pixels together.
std::string summary_json(std::span<const FrameSegmentation> frames, std::string_view source_name);

}  // namespace knuckle
