// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "knuckle/data/frame_stream.h"
#include "knuckle/pipeline/estimate_each.h"

namespace knuckle {

/// What is found in a frame of a live stream.
struct LiveFrame {
  std::shared_ptr<const Frame> frame;  ///< never null; may be kept
  FrameResult result;            ///< its index counts all frames that came, also those that were passed over
  double latency_ms = 0.0;       ///< from the frame's arrival until now
  std::int64_t arrived = 0;      ///< frames that came until now
  std::int64_t passed_over = 0;  ///< those of them for which there was no time
};

/// How a live stream is gone through.
struct LiveOptions {
  std::int64_t most_frames = 0;  ///< results until it ends, >= 0; 0: any number
  double most_seconds = 0.0;     ///< after the first frame, >= 0; 0: any time
  /// Sees every frame as it comes, in the thread that waits for frames: it has to be quick. May be empty.
  std::function<void(std::int64_t index, const std::shared_ptr<const Frame>& frame)> at_arrival = {};
};

/// What became of the frames of a live stream.
struct LiveCounts {
  std::int64_t arrived = 0;
  std::int64_t found = 0;        ///< frames with a hand
  std::int64_t results = 0;      ///< frames that were looked at
  std::int64_t passed_over = 0;  ///< frames for which there was no time: a newer one was there
  std::int64_t unreadable = 0;
  std::string fault;               ///< of the first that could not be read
  std::int64_t lost = 0;           ///< frames that the camera took but that never came
  std::string why_camera_is_lost;  ///< empty where it is not
};

/// Runs the pipeline on what a camera gives, frame by frame, with its tracker where it has one. A thread
/// waits for frames; the newest one wins, nothing is queued. `take` gets the results in order, in the calling
/// thread. Frames that cannot be read are counted, and passed over. Ends with the stream, at the limits of
/// `options`, and where the program is asked to end, at the latest when the next frame has come. Throws what
/// `take`, the pipeline or `at_arrival` throws.
LiveCounts run_live(FrameStream& stream, const Pipeline& pipeline, const LiveOptions& options,
                    const std::function<void(const LiveFrame&)>& take);

}  // namespace knuckle
