// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/core/hand_over.h"
#include "knuckle/data/writers/recording_state.h"

namespace knuckle {

class H5Writer;

/// Records raw frames as they come: depth, infrared, time, camera, sequence; no truth. Into a Knuckle dataset
/// where the name ends in .h5, else into a folder set.
///
/// A thread of its own writes. Frames wait for it, 120 at most; what comes while there is no room is dropped,
/// and counted, and so is a frame whose size, camera or kind of images differs from the first one's. Where
/// time goes back a new sequence begins. The depth is kept in the coarsest unit of `kDepthUnitsMm` in which
/// the first frame that shows something is exact. What is not exact in it is rounded, what exceeds its 16
/// bits is left out, and both are told.
///
/// Until all is whole, frames lie in a log beside the name (H5Writer), `F.h5.partial`: whatever happens, what
/// was written is not lost, and `finish_recording` makes a set of it.
class FrameRecorder {
 public:
  /// Throws an Error where there is something of that name already, a log of a recording that was not
  /// finished, or nothing can be written there.
  explicit FrameRecorder(std::filesystem::path path);
  /// Without `finish` the log stays.
  ~FrameRecorder();
  FrameRecorder(const FrameRecorder&) = delete;
  FrameRecorder& operator=(const FrameRecorder&) = delete;

  /// Never waits. Safe to call from any thread, also after `close` or a fault: then it does nothing.
  void put(std::shared_ptr<const Frame> frame);
  /// Safe to call from any thread.
  RecordingState state() const;
  /// Whether it could not go on; `finish` says why. Safe to call from any thread.
  bool has_failed() const { return has_failed_; }
  /// Takes no more frames; the thread makes the set whole. Does not wait. Safe to call from any thread.
  void close();
  /// Whether the thread has ended.
  bool has_ended() const { return has_ended_; }

  /// Closes, and waits until the set is there. Returns what is to be known of it, a sentence each: frames
  /// that were dropped or changed. Throws an Error that names the file where it could not be written whole;
  /// then it also says what is left and what to do. Throws Interrupted where the program is asked to end.
  std::vector<std::string> finish();

 private:
  void run();
  void take(std::shared_ptr<const Frame> frame);
  void choose_unit(const Image<float>& depth_mm);
  void write_waiting();
  void write(const Frame& frame);
  bool fits(const Frame& frame);
  int next_sequence(const Frame& frame);
  void make_whole();
  std::vector<std::string> remarks() const;

  std::filesystem::path path_;
  HandOver<std::shared_ptr<const Frame>> way_;
  std::atomic<std::int64_t> came_ = 0;
  std::atomic<std::int64_t> unfit_ = 0;
  std::atomic<std::int64_t> written_ = 0;
  std::atomic<bool> is_closed_ = false;
  std::atomic<bool> has_failed_ = false;
  std::atomic<bool> has_ended_ = false;
  mutable std::mutex fault_mutex_;
  std::string fault_;
  // Of the writing thread, and of `finish` after it.
  std::deque<std::shared_ptr<const Frame>> blank_;  ///< frames from before the unit was known
  std::optional<double> unit_mm_;
  std::unique_ptr<H5Writer> writer_;
  std::shared_ptr<const Frame> first_;
  std::optional<double> last_time_s_;
  int last_sequence_ = 0;
  int sequence_shift_ = 0;
  std::int64_t rounded_ = 0;
  std::int64_t cut_ = 0;
  bool is_whole_ = false;
  std::thread thread_;  // the last: it uses the others
};

/// Makes the set `path` of what a recording left that was cut short (killed, or the disk was full). Returns
/// the number of its frames. Throws an Error that names the file where there is none, or the set cannot be
/// written.
std::int64_t finish_recording(const std::filesystem::path& path);

}  // namespace knuckle
