// SPDX-License-Identifier: Apache-2.0
#include "knuckle/cli/live_recording.h"

#include <ctime>
#include <utility>

#include <fmt/chrono.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/text.h"
#include "knuckle/storage/file_io.h"

namespace fs = std::filesystem;

namespace knuckle::cli {

void finish_recording_of(FrameRecorder& recorder, const fs::path& path) {
  recorder.close();
  try {
    for (const std::string& remark : recorder.finish())
      fmt::print(stderr, "warning: {}\n", printable(remark));
  } catch (const Interrupted&) {
    fail("{}: was not made whole; `knuckle record --finish {}` does so", path.string(), path.string());
  }
}

LiveRecording::LiveRecording(const fs::path& file, fs::path folder) : folder_(std::move(folder)) {
  if (!folder_.empty()) make_folder(folder_);
  if (!file.empty()) begin(file);
}

std::shared_ptr<LiveRecording::Recording> LiveRecording::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

void LiveRecording::begin(const fs::path& path) {
  auto recording = std::shared_ptr<Recording>(new Recording{path, FrameRecorder(path)});
  const std::lock_guard lock(mutex_);
  latest_ = std::move(recording);
  is_running_ = true;
}

void LiveRecording::end() {
  const std::lock_guard lock(mutex_);
  if (latest_) latest_->recorder.close();
  is_running_ = false;
}

void LiveRecording::put(const std::shared_ptr<const Frame>& frame) {
  if (const auto recording = latest()) recording->recorder.put(frame);
}

RecordingState LiveRecording::state() const {
  const std::lock_guard lock(mutex_);
  if (!latest_) return {};
  RecordingState state = latest_->recorder.state();
  if (!is_running_ || !state.fault.empty()) state.file.clear();
  return state;
}

bool LiveRecording::has_failed() const {
  const auto recording = latest();
  return folder_.empty() && recording && recording->recorder.has_failed();
}

void LiveRecording::set(bool on) {
  const std::lock_guard lock(set_mutex_);
  if (folder_.empty()) fail("This recording was begun with --record, and ends with the program.");
  const auto recording = latest();
  const bool is_on = recording && is_running_ && !recording->recorder.has_failed();
  if (on == is_on) return;
  end();
  if (!on) return;
  if (recording && !recording->recorder.has_ended())
    fail("The recording before is still being put together; try again in a moment.");
  finish_latest();
  begin(new_path());
}

/// Its file is there, or never will be.
void LiveRecording::finish_latest() {
  const auto recording = latest();
  if (!recording) return;
  try {
    finish_recording_of(recording->recorder, recording->path);
  } catch (const Error& error) {
    if (fault_.empty()) fault_ = error.what();
  }
}

/// A name that tells when: "hand-20260314-150926.h5".
fs::path LiveRecording::new_path() const {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  ::localtime_r(&now, &local);
  const std::string name = fmt::format("hand-{:%Y%m%d-%H%M%S}", local);
  fs::path path = folder_ / (name + ".h5");
  for (int number = 2; fs::exists(path); ++number) path = folder_ / fmt::format("{}-{}.h5", name, number);
  return path;
}

void LiveRecording::finish() {
  const std::lock_guard lock(set_mutex_);
  end();
  finish_latest();
  if (!fault_.empty()) throw Error(fault_);
}

}  // namespace knuckle::cli
