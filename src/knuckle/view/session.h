// SPDX-License-Identifier: Apache-2.0
// Names Boost: included by web_server.cpp alone.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include "knuckle/view/page_files.h"
#include "knuckle/view/request_access.h"
#include "knuckle/view/web_server.h"

namespace knuckle {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Tcp = asio::ip::tcp;
using Fault = beast::error_code;
using Update = std::shared_ptr<const WebUpdate>;

/// For clients to take what still waits, at the end; and for those who were refused.
inline constexpr std::chrono::seconds kFarewell{1};
/// What a client may say at once [bytes].
inline constexpr std::size_t kMostMessage = 4096;

/// Seconds as timers take them.
inline std::chrono::steady_clock::duration duration_of(double seconds) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(seconds));
}

/// Who is connected: kept alive by the operations that are on their way.
class Session : public std::enable_shared_from_this<Session> {
 public:
  Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  virtual ~Session() = default;

  /// There is something new, the hub's newest.
  virtual void show() {}
  /// Ends the connection once all that waits has been sent.
  virtual void end() = 0;
  /// Ends the connection now.
  virtual void close() = 0;

 protected:
  /// This, kept alive.
  template <class Derived>
  std::shared_ptr<Derived> self() {
    return std::static_pointer_cast<Derived>(shared_from_this());
  }
};

/// What all sessions of a server share. Everything in it belongs to the server's thread.
struct Hub {
  std::unordered_map<Session*, std::weak_ptr<Session>> sessions;  // outlives the context, which may hold some
  asio::io_context context{1};
  WebService service;
  WebServerOptions options;
  PageFiles page;
  RequestAccess access;
  Update newest;  ///< null before the first
  bool is_ending = false;
  asio::steady_timer farewell{context};

  void enter(const std::shared_ptr<Session>& session) { sessions.emplace(session.get(), session); }
  void leave(Session* session) {
    sessions.erase(session);
    if (is_ending && sessions.empty()) farewell.cancel();
  }
  template <class Visit>
  void for_each_session(const Visit& visit) {
    std::vector<std::shared_ptr<Session>> all;  // visiting may end some
    for (const auto& [key, session] : sessions) {
      if (auto alive = session.lock()) all.push_back(std::move(alive));
    }
    for (const auto& session : all) visit(*session);
  }
  /// The image of what is newest, made when the first client asks for it.
  const std::shared_ptr<const std::vector<std::uint8_t>>& newest_image() {
    if (image_ == nullptr) image_ = std::make_shared<const std::vector<std::uint8_t>>(newest->image());
    return image_;
  }
  /// Its text, likewise.
  const std::shared_ptr<const std::string>& newest_text() {
    if (text_ == nullptr) text_ = std::make_shared<const std::string>(newest->text());
    return text_;
  }
  void set_newest(Update update) {
    newest = std::move(update);
    image_.reset();
    text_.reset();
  }

 private:
  std::shared_ptr<const std::vector<std::uint8_t>> image_;
  std::shared_ptr<const std::string> text_;
};

/// Ends what takes too long.
class Deadline {
 public:
  explicit Deadline(Hub& hub) : timer_(hub.context) {}

  /// Closes `session` after so many seconds, unless `clear` comes before.
  void set(double seconds, const std::shared_ptr<Session>& session) {
    timer_.expires_after(duration_of(seconds));
    timer_.async_wait([weak = std::weak_ptr<Session>(session)](Fault fault) {
      if (fault) return;  // cleared
      if (const auto alive = weak.lock()) alive->close();
    });
  }
  void clear() { timer_.cancel(); }

 private:
  asio::steady_timer timer_;
};

}  // namespace knuckle
