// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "knuckle/view/live_messages.h"

namespace knuckle {

/// What a server offers of recordings. Called by the server's thread: they have to be quick, and safe to call
/// while frames come.
struct RecordingControl {
  std::function<RecordingState()> state = [] { return RecordingState(); };
  /// Begins a recording, or ends the one that is running. Throws an Error that says in a sentence why not.
  std::function<void(bool on)> set = {};
};

/// Where a server listens, and how long it has patience.
struct LiveServerOptions {
  std::string host = "127.0.0.1";  ///< an address of this machine, "localhost", or 0.0.0.0 for all of them
  int port = 8790;                 ///< [0, 65535]; 0: any free one
  std::filesystem::path page;      ///< folder of the page's files; need not be there
  int most_connections = 64;       ///< [1, 4096]; whoever comes then is told so
  double request_s = 10.0;         ///< for a whole request to come, (0, 3600] [s]
  double write_s = 30.0;           ///< for a message to be taken, (0, 3600] [s]; then the connection ends
};

/// Whether this build has the server: it needs Boost.
bool has_live_server();

/// Shows a live stream to the browser and to programs: HTTP and WebSocket on one port (docs/live.md says what
/// is served). It has one thread of its own, and delays nobody: who reads slowly loses frames.
///
/// Where `host` is not this machine alone, a token is made, which every request has to know; `address` holds
/// it.
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
