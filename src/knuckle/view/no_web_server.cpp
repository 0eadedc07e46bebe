// SPDX-License-Identifier: Apache-2.0
// Stands for web_server.cpp where Boost is missing.
#include "knuckle/core/error.h"
#include "knuckle/view/web_server.h"

namespace knuckle {

class WebServer::Impl {};

bool has_web_server() {
  return false;
}

WebServer::WebServer(WebService, const WebServerOptions&) {
  fail("this build has no server, so it can show no page; build it where Boost is installed (libboost-dev)");
}

WebServer::~WebServer() = default;

const std::string& WebServer::address() const {
  static const std::string none;
  return none;
}

void WebServer::publish(std::shared_ptr<const WebUpdate>) {}

}  // namespace knuckle
