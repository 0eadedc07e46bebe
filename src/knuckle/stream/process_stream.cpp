// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/process_stream.h"

#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/kinect_depth.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 2> kFreenectDepths{"raw", "mm"};
constexpr std::chrono::seconds kLongestOpening{20};  // a Kinect for Windows is sent its program first

double arrival_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

void FreenectOptions::visit(OptionVisitor& visitor) {
  visitor.choice("depth", depth, kFreenectDepths);
  visitor.real("timeout_s", timeout_s, closed(0.1, 3600));
  intrinsics.visit(visitor);
}

void Openni2Options::visit(OptionVisitor& visitor) {
  visitor.integer("width", width, closed(0, limits::kImageSide));
  visitor.integer("height", height, closed(0, limits::kImageSide));
  visitor.integer("rate", rate_hz, closed(0, 1000));
  visitor.real("timeout_s", timeout_s, closed(0.1, 3600));
  intrinsics.visit(visitor);
}

std::optional<Intrinsics> intrinsics_of(const PipedDescription& description) {
  if (description.depth == PipedDepth::kinect_raw) {
    return Intrinsics{kinect_camera(), "measured by N. Burrus for another Kinect"};
  }
  if (description.horizontal_fov_rad == 0.0 || description.vertical_fov_rad == 0.0) return std::nullopt;
  const double width = description.width;
  const double height = description.height;
  const Camera camera{.model = CameraModel::projective,
                      .width = static_cast<int>(description.width),
                      .height = static_cast<int>(description.height),
                      .fx = width / (2.0 * std::tan(description.horizontal_fov_rad / 2.0)),
                      .fy = height / (2.0 * std::tan(description.vertical_fov_rad / 2.0)),
                      .cx = (width - 1.0) / 2.0,
                      .cy = (height - 1.0) / 2.0,
                      .distortion = {}};
  return Intrinsics{camera, "the fields of view that the device reports"};
}

Image<float> depth_of(const ReceivedMessage& message, const PipedDescription& description,
                      std::string_view where) {
  Image<std::uint16_t> counts(static_cast<int>(description.width), static_cast<int>(description.height));
  std::memcpy(counts.data(), message.bytes.data() + sizeof(PipedFrame), 2 * counts.size());
  const Image<float> depth_mm = description.depth == PipedDepth::kinect_raw
                                    ? kinect_depth_mm(counts, {KinectDepthUnit::raw, false}, where)
                                    : depth_from_counts(counts, description.unit_mm);
  return description.is_mirrored == 1 ? mirrored(depth_mm) : depth_mm;
}

ProcessStream::ProcessStream(std::unique_ptr<CameraProcess> process, std::string where,
                             const IntrinsicsOptions& intrinsics, double timeout_s, UnknownIntrinsics unknown)
    : process_(std::move(process)), where_(std::move(where)), timeout_s_(timeout_s) {
  const ReceivedMessage message = process_->wait_for_message(kLongestOpening);
  if (message.kind == CameraMessage::fault) fail("{}: {}", where_, parse_text(message.bytes));
  if (message.kind != CameraMessage::description)
    fail("{}: the process that reads it did not say what it is", where_);
  description_ = parse_description(message.bytes, where_);
  const auto width = static_cast<int>(description_.width);
  const auto height = static_cast<int>(description_.height);
  Intrinsics found = find_intrinsics(intrinsics, intrinsics_of(description_), width, height, unknown, where_);
  camera_ = found.camera;
  facts_.device = description_.device;
  facts_.format =
      fmt::format("{} {}x{}", description_.depth == PipedDepth::kinect_raw ? "raw" : "depth", width, height);
  if (description_.rate_hz > 0.0) facts_.format += fmt::format(", {:.4g} per second", description_.rate_hz);
  facts_.intrinsics = std::move(found.origin);
}

Frame ProcessStream::wait_for_frame() {
  const ReceivedMessage message = process_->wait_for_message(std::chrono::duration<double>(timeout_s_));
  if (message.kind == CameraMessage::fault)
    throw DeviceLost(fmt::format("{}: {}", where_, parse_text(message.bytes)));
  if (message.kind != CameraMessage::frame) fail("{}: the process that reads it sent no frame", where_);
  const PipedFrame piped = parse_piped_frame(message.bytes, description_, where_);
  constexpr std::int64_t kMostLost = 100000;  // more: the device began to count anew
  if (last_number_ && piped.number > *last_number_ && piped.number - *last_number_ <= kMostLost) {
    lost_ += piped.number - *last_number_ - 1;
  }
  last_number_ = piped.number;
  Frame frame;
  frame.name = fmt::format("{:06}", frames_++);
  frame.camera = camera_;
  frame.depth_mm = depth_of(message, description_, where_);
  frame.time_s = clock_.time_s(piped.time_s, arrival_s());
  return frame;
}

std::optional<Frame> ProcessStream::next() {
  if (!process_) return std::nullopt;
  try {
    return wait_for_frame();
  } catch (const Error& error) {  // with such a process nothing can be done any more
    process_.reset();
    throw DeviceLost(error.what());
  }
}

std::vector<ProcessListing> list_by_process(const std::string& kind) {
  constexpr std::size_t kMostListings = 256;
  CameraProcess process(camera_program(), {"list", kind}, kind);
  std::vector<ProcessListing> all;
  while (all.size() < kMostListings) {
    const ReceivedMessage message = process.wait_for_message(kLongestOpening);
    if (message.kind == CameraMessage::fault) fail("{}: {}", kind, parse_text(message.bytes));
    if (message.kind != CameraMessage::listing) break;
    const std::string text = parse_text(message.bytes);
    const std::size_t end = std::min(text.find('\n'), text.size());
    all.push_back({text.substr(0, end), text.substr(std::min(end + 1, text.size()))});
  }
  return all;
}

}  // namespace knuckle
