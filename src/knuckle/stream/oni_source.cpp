// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/oni_source.h"

#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/stream/process_stream.h"

namespace knuckle {
namespace {

constexpr std::chrono::seconds kLongestOniAnswer{15};

}  // namespace

OniSource::OniSource(const std::filesystem::path& path, const OniOptions& options)
    : OniSource(path, options, camera_program()) {}

OniSource::OniSource(std::filesystem::path path, const OniOptions& options, std::filesystem::path program)
    : path_(std::move(path)), where_(path_.string()), program_(std::move(program)) {
  require_regular_file(path_);
  description_ = begin();
  if (description_.frames < 1) fail("{}: holds no depth image", where_);
  camera_ = find_intrinsics(options.intrinsics, intrinsics_of(description_), static_cast<int>(description_.width),
                            static_cast<int>(description_.height), UnknownIntrinsics::refuse, where_)
                .camera;
}

/// Starts a process, and returns what it says of the file.
PipedDescription OniSource::begin() const {
  // OpenNI2 tells files from devices by a dot in their names; a whole path is never taken for a device.
  process_ = std::make_unique<CameraProcess>(
      program_, std::vector<std::string>{"oni", std::filesystem::absolute(path_).string()}, where_);
  const ReceivedMessage message = process_->wait_for_message(kLongestOniAnswer);
  if (message.kind == CameraMessage::fault) fail("{}: {}", where_, parse_text(message.bytes));
  if (message.kind != CameraMessage::description) fail("{}: the process that reads it did not say what it is", where_);
  return parse_description(message.bytes, where_);
}

Frame OniSource::read_anew(std::int64_t index) const {
  if (!process_) begin();
  process_->ask(index);
  const ReceivedMessage message = process_->wait_for_message(kLongestOniAnswer);
  const std::string where = fmt::format("{}: frame {}", where_, index);
  if (message.kind == CameraMessage::fault) fail("{}: {}", where, parse_text(message.bytes));
  if (message.kind != CameraMessage::frame) fail("{}: did not come", where);
  const PipedFrame piped = parse_piped_frame(message.bytes, description_, where);
  if (piped.number != index) fail("{}: frame {} came in its place", where, piped.number);
  Frame frame;
  frame.name = fmt::format("{:06}", index);
  frame.camera = camera_;
  frame.depth_mm = depth_of(message, description_, where);
  frame.time_s = piped.time_s;
  return frame;
}

Frame OniSource::read(std::int64_t index) const {
  const std::lock_guard lock(mutex_);
  if (last_ && last_->first == index) return last_->second;
  try {
    Frame frame = read_anew(index);
    last_ = {index, frame};
    return frame;
  } catch (const Error&) {
    process_.reset();
    throw;
  } catch (const Interrupted&) {  // its answer would be taken for that to the next question
    process_.reset();
    throw;
  }
}

}  // namespace knuckle
