// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/oni_source.h"

#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/stream/process_stream.h"

namespace knuckle {
namespace {

constexpr std::chrono::seconds kLongestOniAnswer{15};
constexpr std::size_t kMostKeptBytes = std::size_t{64} << 20;

}  // namespace

OniSource::OniSource(const std::filesystem::path& path, const OniOptions& options)
    : OniSource(path, options, camera_program()) {}

OniSource::OniSource(std::filesystem::path path, const OniOptions& options, std::filesystem::path program)
    : path_(std::move(path)), where_(path_.string()), program_(std::move(program)) {
  require_regular_file(path_);
  description_ = begin();
  if (description_.frames < 1) fail("{}: holds no depth image", where_);
  camera_ =
      find_intrinsics(options.intrinsics, intrinsics_of(description_), static_cast<int>(description_.width),
                      static_cast<int>(description_.height), UnknownIntrinsics::refuse, where_)
          .camera;
}

/// Starts a process, and returns what it says of the file.
PipedDescription OniSource::begin() const {
  // What is no file OpenNI2 takes for a device: a whole path never is.
  auto process = std::make_unique<CameraProcess>(
      program_, std::vector<std::string>{"oni", std::filesystem::absolute(path_).string()}, where_);
  const ReceivedMessage message = process->wait_for_message(kLongestOniAnswer);
  if (message.kind == CameraMessage::fault) fail("{}: {}", where_, parse_text(message.bytes));
  if (message.kind != CameraMessage::description) {
    fail("{}: the process that reads it did not say what it is", where_);
  }
  process_ = std::move(process);
  next_ = 0;
  return parse_description(message.bytes, where_);
}

void OniSource::keep(std::int64_t number, ReceivedMessage message) const {
  kept_bytes_ += message.bytes.size();
  kept_[number] = std::move(message);
  while (kept_bytes_ > kMostKeptBytes && kept_.size() > 1) {
    kept_bytes_ -= kept_.begin()->second.bytes.size();
    kept_.erase(kept_.begin());
  }
}

/// Takes the next frame. Where there is none, there is none after it either.
void OniSource::read_on() const {
  try {
    ReceivedMessage message = process_->wait_for_message(kLongestOniAnswer);
    if (message.kind == CameraMessage::fault) fail("{}: {}", where_, parse_text(message.bytes));
    if (message.kind != CameraMessage::frame) fail("{}: ends before its frame {}", where_, next_);
    const PipedFrame frame = parse_piped_frame(message.bytes, description_, where_);
    if (frame.number < next_ || frame.number >= size()) {
      fail("{}: frame {} comes after frame {}", where_, frame.number, next_ - 1);
    }
    keep(frame.number, std::move(message));
    next_ = frame.number + 1;
  } catch (const Error& error) {
    fault_ = error.what();
    faulty_ = next_;
    process_.reset();
    throw;
  }
}

const ReceivedMessage& OniSource::message_of(std::int64_t index) const {
  if (const auto kept = kept_.find(index); kept != kept_.end()) return kept->second;
  if (!fault_.empty() && index >= faulty_) throw Error(fault_);
  if (!process_ || index < next_) {
    process_.reset();
    begin();
    kept_.clear();
    kept_bytes_ = 0;
  }
  while (next_ <= index) read_on();
  const auto found = kept_.find(index);
  if (found == kept_.end()) fail("{}: frame {} is missing or damaged: OpenNI2 passes over it", where_, index);
  return found->second;
}

Frame OniSource::read(std::int64_t index) const {
  const std::lock_guard lock(mutex_);
  const ReceivedMessage& message = message_of(index);
  const std::string where = fmt::format("{}: frame {}", where_, index);
  Frame frame;
  frame.name = fmt::format("{:06}", index);
  frame.camera = camera_;
  frame.depth_mm = depth_of(message, description_, where);
  frame.time_s = parse_piped_frame(message.bytes, description_, where).time_s;
  return frame;
}

}  // namespace knuckle
