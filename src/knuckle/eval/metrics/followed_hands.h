// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/data/frame_record.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/eval/metrics/occlusion_score.h"
#include "knuckle/eval/metrics/reliability.h"
#include "knuckle/eval/metrics/true_hands.h"

namespace knuckle {

/// How well a method finds and follows all hands, after the CLEAR MOT measures (Bernardin and Stiefelhagen
/// 2008). A hand of which less than kLeastVisible is seen need not be found, and finding it is no fault; the
/// same holds for one whose middle lies outside the image.
struct FollowedScore {
  std::string name;
  std::int64_t frames = 0;
  std::int64_t hands = 0;         ///< true ones that were to be found, over all frames
  std::int64_t found = 0;         ///< of them: an estimate of its own lies within kFoundMm
  std::int64_t right_side = 0;    ///< of the found ones: the side is right
  std::int64_t invented = 0;      ///< estimates that are no hand's, or a hand's second
  std::int64_t switches = 0;      ///< a hand is found with another id than when it was found last
  std::int64_t losses = 0;        ///< times that a hand was not found for some frames, and then was
  std::int64_t longest_loss = 0;  ///< of those [frames]
  double mean_3d_mm = kNaN;       ///< over the found ones and their landmarks; NaN where there is none
  OcclusionScores occlusion;      ///< the same landmarks by what lies before them, where the truth knows it
  Reliability reliability;        ///< of the joints' confidences
};

inline constexpr double kLeastVisible = 0.3;  ///< part of a hand's pixels, [0, 1]
inline constexpr double kFoundMm = 60.0;      ///< between the means of the landmarks that both know

/// What a method found in all frames of a source.
struct NamedRecords {
  std::string name;
  std::vector<FrameRecord> frames;  ///< one per frame of the source
};

/// Scores records, one per frame of `truth`. Hands and estimates are matched nearest first. A hand is
/// followed through its sequence by its side and place in the list. Landmarks are compared by their names.
FollowedScore followed_score(const std::string& name, const Convention& convention,
                             std::span<const TrueHands> truth, std::span<const FrameRecord> records);

/// The true hands of all frames of a source, on all threads; reads images where only they tell of all hands.
/// Throws an Error where the source has no truth.
std::vector<TrueHands> true_hands(const FrameSource& source);

/// The records of a file for each frame of a source of `frames` frames; empty ones of frames that it passes
/// over, as `live` does where there is no time for them. Throws an Error that names file and line where
/// a line is no record, or where frames are doubled, out of order or not the source's.
std::vector<FrameRecord> records_from_file(const std::filesystem::path& path, std::int64_t frames);

}  // namespace knuckle
