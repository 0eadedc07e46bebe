// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/frame_stream.h"

namespace knuckle {

/// How a source is played: settings of a stream, as in `h5:set.h5?rate=60&loop=1`.
struct PlayOptions {
  double rate_hz =
      0.0;       ///< frames per second, [0, 10000]; 0: at the source's own times, 30 where it has none
  int loop = 0;  ///< 1: from the beginning again, until no frame of a round could be read

  void visit(OptionVisitor& visitor);
};

/// When the frames of a source are due, from the first on: with a rate, at that; else at their own times, a
/// thirtieth of a second from one sequence to the next, and where a time is not known.
class PlayClock {
 public:
  explicit PlayClock(double rate_hz) : rate_hz_(rate_hz) {}
  /// When the next frame is due [s].
  double due_s(const FrameLabel& frame);

 private:
  double rate_hz_;
  std::int64_t count_ = 0;
  double due_s_ = 0.0;
  std::optional<double> last_time_s_;
  int last_sequence_ = 0;
  bool is_any_readable_ = false;  ///< in this round
};

/// A source played as a camera would give its frames: each comes when it is due, and late where reading takes
/// longer than that; one that cannot be read is an error when it is due. `Frame::time_s` is when it was due,
/// from the first on; each round of a loop has sequences of its own.
class PlayedStream final : public FrameStream {
 public:
  /// Throws an Error where an option is out of range.
  PlayedStream(std::unique_ptr<const FrameSource> source, const PlayOptions& options);

  /// Waits for the frame. Throws as FrameStream says, and Interrupted where the program is asked to end.
  std::optional<Frame> next() override;

 private:
  using Clock = std::chrono::steady_clock;
  void wait_until_due(double due_s);

  std::unique_ptr<const FrameSource> source_;
  PlayOptions options_;
  PlayClock clock_;
  std::optional<Clock::time_point> began_;
  std::int64_t position_ = 0;
  int first_sequence_ = 0;  ///< of this round
  int last_sequence_ = 0;
  bool is_any_readable_ = false;  ///< in this round
};

}  // namespace knuckle
