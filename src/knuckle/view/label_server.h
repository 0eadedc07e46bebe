// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "knuckle/label/label_session.h"
#include "knuckle/view/label_messages.h"
#include "knuckle/view/web_server.h"

namespace knuckle {

/// Serves the page for labelling (docs/labelling.md says what is served). One thread answers requests, in
/// their order; another does what can wait, while nobody asks: it estimates frames, and lets neighbours
/// follow verified ones. Whatever the page sends is read as that of a stranger.
class LabelServer {
 public:
  /// The session has to live as long; it is used by the server's threads alone. Throws an Error as WebServer
  /// does.
  LabelServer(LabelInfo info, LabelSession& session, const WebServerOptions& options);
  /// Ends both threads and all connections. What was accepted is in the session.
  ~LabelServer();
  LabelServer(const LabelServer&) = delete;
  LabelServer& operator=(const LabelServer&) = delete;

  /// Where the page is, as in "http://127.0.0.1:8791/".
  const std::string& address() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace knuckle
