// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "knuckle/data/frame_source.h"
#include "knuckle/data/frame_stream.h"
#include "knuckle/pipeline/pipeline.h"
#include "knuckle/pipeline/start.h"

namespace knuckle {

class RunWarnings;

/// What a pipeline made of one frame of a source or stream. The frame's images are not kept, nor are the
/// masks of its hands (`HandRegion::mask` is empty).
struct FrameResult {
  std::int64_t index = 0;        ///< in the source, or counted in the stream; from `RunOptions::first` on
  std::string name;              ///< `Frame::name`; empty where a stream could not read the frame
  std::optional<double> time_s;  ///< `Frame::time_s` [s]
  Camera camera;                 ///< `Frame::camera`
  FrameEstimate estimate;        ///< no hand where the frame could not be read
  std::string fault;             ///< why the frame could not be read, in one line; empty where it could
};

/// How a source or a stream is gone through.
struct RunOptions {
  Start start = Start::nearest;
  /// Of a source: the first frame that is read, [0, size]; a stream's first frame gets this number.
  std::int64_t first = 0;
  /// Frames that may be in the works at a time, at most: each may hold its images. [0, 65536]; 0: four per
  /// thread.
  int frames_in_flight = 0;
  RunWarnings* warnings = nullptr;  ///< takes note of each frame that can be read; null: nobody does

  /// `frames_in_flight`, or what stands for 0.
  int most_in_flight() const;
  /// Throws an Error that names the field that is out of range.
  void check() const;
};

/// Takes the result of a frame.
using TakeResult = std::function<void(FrameResult)>;

/// Runs the pipeline on the frames of a stream on all threads, and hands over what it finds in the order of
/// the frames, one at a time (not always in the same thread). Memory is bounded, however long the stream.
///
/// A frame that cannot be read is a result with a fault, and the run goes on. Throws what `take` or the
/// pipeline throws; Interrupted where the program is asked to end, after the frames in the works were handed
/// over. What was handed over until then is a beginning without gaps. Returns when the stream has ended.
void estimate_each(FrameStream& stream, const Pipeline& pipeline, const RunOptions& options,
                   const TakeResult& take);

/// The same for the frames of a source from `options.first` on, which are also read on all threads. A source
/// whose labels are wrong is refused as a whole: an Error of `FrameSource::read_label` is thrown on.
void estimate_each(const FrameSource& source, const Pipeline& pipeline, const RunOptions& options,
                   const TakeResult& take);

/// The result of a frame that cannot be read, with the reason.
FrameResult unreadable_frame(const FrameSource& source, std::int64_t index, std::string fault);

}  // namespace knuckle
