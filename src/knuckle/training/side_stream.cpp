// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/side_stream.h"

#include <c10/core/impl/VirtualGuardImpl.h>

namespace knuckle {
namespace {

c10::Stream stream_of_calling_thread(const torch::Device& device) {
  return c10::impl::VirtualGuardImpl(device.type()).getStream(device);
}

}  // namespace

DeviceMark::DeviceMark(const torch::Device& device) : device_(device) {
  if (!device.is_cpu()) event_.emplace(device.type());
}

void DeviceMark::set() {
  if (event_) event_->record(stream_of_calling_thread(device_));
}

void DeviceMark::wait() {
  if (event_) event_->block(stream_of_calling_thread(device_));
}

SideStream::SideStream(const torch::Device& device) {
  if (!device.is_cpu()) {
    stream_ = c10::impl::VirtualGuardImpl(device.type()).getStreamFromGlobalPool(device, true);
  }
}

}  // namespace knuckle
