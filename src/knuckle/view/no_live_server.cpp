// SPDX-License-Identifier: Apache-2.0
// Stands for live_server.cpp where Boost is missing.
#include "knuckle/core/error.h"
#include "knuckle/view/live_server.h"

namespace knuckle {

class LiveServer::Impl {};

bool has_live_server() {
  return false;
}

LiveServer::LiveServer(LiveInfo, const LiveServerOptions&, RecordingControl) {
  fail("this build has no server to watch the hand with; build it where Boost is installed (libboost-dev)");
}

LiveServer::~LiveServer() = default;

const std::string& LiveServer::address() const {
  static const std::string none;
  return none;
}

void LiveServer::publish(std::shared_ptr<const LiveUpdate>) {}

}  // namespace knuckle
