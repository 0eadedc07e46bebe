// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// A request that came from somebody who may ask.
struct WebRequest {
  bool is_post = false;  ///< POST, not GET or HEAD
  std::string path;      ///< as in "/api/info"
  std::string query;     ///< after the path, with its '?'; may be empty
  std::string body;
};

/// What it is answered.
struct WebAnswer {
  int status = 200;
  std::string content_type = "application/json";
  std::string body = {};
  std::string allow = {};  ///< of a 405: the methods that are served
};

/// An answer of one sentence, for people.
WebAnswer sentence_answer(int status, std::string_view sentence);

/// Takes the answer to one request; once, from any thread, as long as the server lives.
using WebReply = std::function<void(WebAnswer)>;

/// How what is published goes to those who listen.
enum class WebFeed : std::uint8_t {
  texts,   ///< a WebSocket: every text, of which 64 may wait
  images,  ///< a WebSocket: the newest image; those that a slow client has no time for are left out
  lines,   ///< an answer without an end: every text, one per line
};

/// What a server serves below /api.
struct WebService {
  /// Answers a request, now or later, or returns false: it is none of the service's. Called by the server's
  /// thread, which waits for it: what takes long belongs to another thread.
  std::function<bool(const WebRequest&, const WebReply&)> answer = nullptr;
  std::map<std::string, WebFeed, std::less<>> feeds = {};  ///< by path
  std::string without_socket = {};                         ///< told to who asks for a socket's path otherwise
};

/// What is published. Each is made once, when the first client takes it, by the server's thread.
struct WebUpdate {
  std::function<std::string()> text;
  std::function<std::vector<std::uint8_t>()> image;
};

/// Where a server listens, and how long it has patience.
struct WebServerOptions {
  std::string host = "127.0.0.1";    ///< an address of this machine, "localhost", or 0.0.0.0 for all of them
  int port = 0;                      ///< [0, 65535]; 0: any free one
  std::filesystem::path page;        ///< folder of the page's files; need not be there
  std::string index = "index.html";  ///< the file of `page` that "/" is
  int most_connections = 64;         ///< [1, 4096]; whoever comes then is told so
  double request_s = 10.0;           ///< for a whole request to come, (0, 3600] [s]
  double write_s = 30.0;             ///< for a message to be taken, (0, 3600] [s]; then the connection ends
};

/// Whether this build has servers: they need Boost.
bool has_web_server();

/// Serves a page and what it asks for: HTTP and WebSocket on one port. It has one thread of its own, and
/// delays nobody: who reads slowly loses what was published meanwhile.
///
/// Where `host` is not this machine alone, a token is made, which every request has to know; `address` holds
/// it.
class WebServer {
 public:
  /// Begins to serve. Throws an Error where the page's files cannot be read, the host is no address, the port
  /// cannot be had, an option is out of range, or this build has no server.
  WebServer(WebService service, const WebServerOptions& options);
  /// Hands over what still waits, for a second at most, and ends all connections.
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Where the page is, as in "http://127.0.0.1:8790/".
  const std::string& address() const;
  /// Sends to all who listen. Takes some microseconds, whatever clients do. Safe to call from any thread.
  void publish(std::shared_ptr<const WebUpdate> update);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace knuckle
