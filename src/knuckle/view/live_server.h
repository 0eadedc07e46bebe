// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "knuckle/view/live_messages.h"
#include "knuckle/view/web_server.h"

namespace knuckle {

/// What a server offers of recordings. Called by the server's thread: they have to be quick, and safe to call
/// while frames come.
struct RecordingControl {
  std::function<RecordingState()> state = [] { return RecordingState(); };
  /// Begins a recording, or ends the one that is running. Throws an Error that says in a sentence why not.
  std::function<void(bool on)> set = {};
};

/// Where it listens; its usual port is 8790.
using LiveServerOptions = WebServerOptions;

/// Whether this build has the server: it needs Boost.
bool has_live_server();

/// Shows a live stream to the browser and to programs by a WebServer (docs/live.md says what is served): who
/// reads slowly loses frames.
class LiveServer {
 public:
  /// Begins to serve. Throws an Error where the page's files cannot be read, the host is no address, the port
  /// cannot be had, an option is out of range, or this build has no server.
  LiveServer(LiveInfo info, const LiveServerOptions& options, RecordingControl recording = {});
  /// Hands over what still waits, for a second at most, and ends all connections.
  ~LiveServer();
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  /// Where the page is, as in "http://127.0.0.1:8790/".
  const std::string& address() const;
  /// Shows a frame. Takes some microseconds, whatever clients do. Safe to call from any thread.
  void publish(std::shared_ptr<const LiveUpdate> update);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace knuckle
