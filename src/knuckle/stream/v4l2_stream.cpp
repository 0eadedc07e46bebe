// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/v4l2_stream.h"

#include <cerrno>
#include <thread>
#include <utility>

#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"

namespace knuckle {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr std::chrono::milliseconds kLongestWait{50};  // until Ctrl-C is looked at
constexpr std::chrono::milliseconds kBetweenTries{200};

double now_s() {
  return Seconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

V4l2Stream::V4l2Stream(std::string path, const V4l2Options& options, UnknownIntrinsics unknown)
    : path_(std::move(path)), options_(options), unknown_(unknown) {
  open();
  Intrinsics intrinsics =
      find_intrinsics(options_.intrinsics, std::nullopt, capture_->mode().layout.width,
                      capture_->mode().layout.height, unknown_, capture_->device().name());
  camera_ = intrinsics.camera;
  facts_ = {capture_->device().card(), capture_->mode().text(), std::move(intrinsics.origin)};
}

void V4l2Stream::open() {
  const auto begin = Clock::now();
  while (!capture_) {
    try {
      capture_.emplace(path_, options_);
    } catch (const Error&) {
      // A camera that is plugged in may be forbidden, or busy, until the system has looked at it.
      if (Seconds(Clock::now() - begin).count() >= options_.wait_s) throw;
      end_if_interrupted();
      std::this_thread::sleep_for(kBetweenTries);
    }
  }
}

void V4l2Stream::reopen() {
  capture_.reset();
  last_number_.reset();
  clock_.restart_device();
  open();
  const V4l2Layout& layout = capture_->mode().layout;
  if (layout.width != camera_.width || layout.height != camera_.height) {
    fail("v4l2:{}: came back with images of {}x{}, had {}x{}", path_, layout.width, layout.height,
         camera_.width, camera_.height);
  }
  ++sequence_;
}

V4l2Frame V4l2Stream::wait_for_frame() {
  const auto begin = Clock::now();
  while (true) {
    end_if_interrupted();
    if (auto frame = capture_->next(kLongestWait)) return *std::move(frame);
    if (Seconds(Clock::now() - begin).count() >= options_.timeout_s) {
      throw DeviceLost(fmt::format(
          "{}: has sent no whole frame for {:g} s; plug it in again, at a port of USB 3, without a hub",
          capture_->device().name(), options_.timeout_s));
    }
  }
}

std::optional<Frame> V4l2Stream::next() {
  while (capture_) {
    try {
      return frame_of(wait_for_frame());
    } catch (const DeviceLost&) {
      capture_.reset();
      if (options_.wait_s == 0.0) throw;
    }
    try {
      reopen();
    } catch (const Error& error) {
      capture_.reset();
      throw DeviceLost(fmt::format("{} (it was lost, and did not come back within {:g} s)", error.what(),
                                   options_.wait_s));
    }
  }
  return std::nullopt;
}

void V4l2Stream::count_lost(std::uint32_t number) {
  constexpr std::uint32_t kMostLost = 100000;  // more: the device began to count anew
  if (last_number_) {
    const std::uint32_t between = number - *last_number_ - 1;
    if (between < kMostLost) lost_ += between;
  }
  last_number_ = number;
}

Frame V4l2Stream::frame_of(V4l2Frame taken) {
  count_lost(taken.number);
  Frame frame;
  frame.name = fmt::format("{:06}", frames_++);
  frame.camera = camera_;
  frame.depth_mm = std::move(taken.images.depth_mm);
  frame.infrared = std::move(taken.images.infrared);
  frame.time_s = clock_.time_s(taken.time_s, now_s());
  frame.sequence = sequence_;
  return frame;
}

std::vector<V4l2Listing> list_v4l2() {
  constexpr int kMostDevices = 256;  // the kernel's
  std::vector<V4l2Listing> all;
  for (int number = 0; number < kMostDevices; ++number) {
    V4l2Listing listing;
    listing.path = fmt::format("/dev/video{}", number);
    if (::access(listing.path.c_str(), F_OK) != 0) continue;
    try {
      const V4l2Device device(listing.path);
      listing.card = device.card();
      for (const V4l2DepthFormat& format : offered_depth_formats(device))
        listing.formats.push_back(four_letters(format.code));
    } catch (const Error& error) {
      listing.fault = error.what();
    }
    all.push_back(std::move(listing));
  }
  return all;
}

}  // namespace knuckle
