// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "knuckle/data/writers/frame_recorder.h"

namespace knuckle::cli {

/// Ends a recording after its last frame; Ctrl-C, which may have brought it here, does not count any more,
/// but a second one leaves the frames in their log. Prints what is to be known of it as warnings. Throws an
/// Error where there is no set in the end.
void finish_recording_of(FrameRecorder& recorder, const std::filesystem::path& path);

/// The recordings of `live`: one from its start to its end (`--record`), or as many as the page begins and
/// ends
/// (`--record-folder`). Safe to use from several threads.
class LiveRecording {
 public:
  /// `file`: what is recorded from now on; `folder`: where recordings may be begun. Empty: none. Throws an
  /// Error where nothing can be written there.
  LiveRecording(const std::filesystem::path& file, std::filesystem::path folder);

  bool can_be_set() const { return !folder_.empty(); }
  /// A frame came. Never waits for a disk.
  void put(const std::shared_ptr<const Frame>& frame);
  RecordingState state() const;
  /// Begins a recording, or ends the one that is running. Throws an Error where that cannot be.
  void set(bool on);
  /// Whether what was to be recorded from start to end could not be.
  bool has_failed() const;
  /// Ends all. Throws the first fault.
  void finish();

 private:
  struct Recording {
    std::filesystem::path path;
    FrameRecorder recorder;
  };

  /// The one that is running, or ended last; null before the first.
  std::shared_ptr<Recording> latest() const;
  void begin(const std::filesystem::path& path);
  void end();
  void finish_latest();
  std::filesystem::path new_path() const;

  std::filesystem::path folder_;
  std::mutex set_mutex_;  ///< one at a time begins and ends recordings; frames do not wait for that
  std::string fault_;     ///< of the first that failed
  mutable std::mutex mutex_;
  std::shared_ptr<Recording> latest_;
  bool is_running_ = false;
};

}  // namespace knuckle::cli
