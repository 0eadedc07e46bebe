// SPDX-License-Identifier: Apache-2.0
// Names Boost: included by live_server.cpp alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/view/control_message.h"
#include "knuckle/view/line_session.h"
#include "knuckle/view/session.h"
#include "knuckle/view/socket_session.h"

namespace knuckle {

inline constexpr std::uint32_t kMostHead = 8192;      ///< of a request [bytes]
inline constexpr std::uint64_t kMostBody = 1024;      ///< of a request [bytes]
inline constexpr std::size_t kMostDiscarded = 65536;  ///< after a refusal [bytes]

/// Boost's view of a text as the standard's.
inline std::string_view view_of(beast::string_view text) {
  return {text.data(), text.size()};
}

using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;

/// Where the page may load things from, and whom it may talk to. Old browsers do not count sockets as 'self'.
inline std::string content_policy(std::string_view host) {
  return fmt::format(
      "default-src 'self'; img-src 'self' data: blob:; worker-src 'self' blob:; connect-src 'self'{}; "
      "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
      is_local_host(host) ? fmt::format(" ws://{}", host) : "");
}

/// A request that is read, answered, and maybe followed by another one.
class RequestSession final : public Session {
 public:
  RequestSession(Hub& hub, Tcp::socket socket) : hub_(hub), stream_(std::move(socket)) {}
  ~RequestSession() override { hub_.leave(this); }

  void begin() {
    hub_.enter(shared_from_this());
    read();
  }
  void end() override {
    is_ending_ = true;
    if (!is_answering_) close();
  }
  void close() override { stream_.close(); }

 private:
  void read() {
    parser_.emplace();
    parser_->header_limit(kMostHead);
    parser_->body_limit(kMostBody);
    stream_.expires_after(duration_of(hub_.options.request_s));  // for all of it
    http::async_read(stream_, buffer_, *parser_,
                     [self = self<RequestSession>()](Fault fault, std::size_t) { self->on_read(fault); });
  }

  void on_read(Fault fault) {
    if (fault == http::error::end_of_stream || fault == beast::error::timeout) return close();
    if (fault) {
      const bool is_malformed = fault.category() == make_error_code(http::error::bad_method).category();
      return is_malformed ? refuse_malformed(fault) : close();
    }
    const Request request = parser_->release();
    if (!route(request)) close();  // where the connection goes on as another session, there is nothing left
  }

  void refuse_malformed(Fault fault) {
    Response response = text(http::status::bad_request, "This is no request that can be answered.");
    if (fault == http::error::header_limit)
      response = text(http::status::request_header_fields_too_large, "The head of the request is too long.");
    if (fault == http::error::body_limit)
      response = text(http::status::payload_too_large, "The body of the request is too long.");
    response.keep_alive(false);
    answer(std::move(response));
  }

  /// False where the connection is to be closed without an answer.
  bool route(const Request& request) {
    const std::string_view target = view_of(request.target());
    const std::string_view host = view_of(request[http::field::host]);
    if (request.count(http::field::host) > 1 || request.count(http::field::origin) > 1)
      return reply(request, text(http::status::bad_request, "A request has one Host, and one Origin."));
    const std::string refusal = refusal_of(
        {target, host, view_of(request[http::field::origin]), view_of(request[http::field::cookie])},
        hub_.access);
    if (!refusal.empty()) return reply(request, text(http::status::forbidden, refusal));
    return route_path(request, path_of(target));
  }

  bool route_path(const Request& request, std::string_view path) {
    if (path == "/api/recording") return reply(request, set_recording(request));
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      Response response = text(http::status::method_not_allowed, "Only GET is served here.");
      response.set(http::field::allow, "GET, HEAD");
      return reply(request, std::move(response));
    }
    if (path == "/api/info") {
      return reply(request, content(http::status::ok, "application/json",
                                    info_message(hub_.info, hub_.recording.state(), hub_.newest.get())));
    }
    if (path == "/api/records.jsonl") return begin_lines(request);
    if (path == "/api/records") return begin_socket(request, SocketSession::Kind::records);
    if (path == "/api/frames") return begin_socket(request, SocketSession::Kind::frames);
    return reply(request, page_file(request, path));
  }

  Response page_file(const Request& request, std::string_view path) const {
    const auto file = hub_.page.find(path);
    if (file == hub_.page.end()) {
      return text(http::status::not_found,
                  path == "/" ? "The page is not installed: there is no web/dist/index.html beside Knuckle's "
                                "models. /api/info, /api/records and /api/frames are served."
                              : "There is nothing of this name.");
    }
    Response response = content(http::status::ok, file->second.content_type, file->second.bytes);
    const std::string_view host = view_of(request[http::field::host]);
    response.set("Content-Security-Policy", content_policy(host));
    // What the page loads has the token from here.
    if (!hub_.access.token.empty()) {
      response.set(http::field::set_cookie, fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict",
                                                        hub_.access.cookie_name, hub_.access.token));
    }
    return response;
  }

  Response set_recording(const Request& request) {
    if (request.method() != http::verb::post) {
      Response response = text(http::status::method_not_allowed, "Only POST is served here.");
      response.set(http::field::allow, "POST");
      return response;
    }
    RecordingRequest wanted;
    try {
      wanted = parse_recording_request(request.body());
    } catch (const Error& error) {
      return text(http::status::bad_request, error.what());
    }
    if (!hub_.info.can_record || !hub_.recording.set) {
      return text(http::status::conflict,
                  "There is no place for recordings: start the program with --record-folder.");
    }
    try {
      hub_.recording.set(wanted.on);
    } catch (const Error& error) {
      return text(http::status::conflict, error.what());
    }
    return content(http::status::ok, "application/json",
                   info_message(hub_.info, hub_.recording.state(), hub_.newest.get()));
  }

  static Response content(http::status status, std::string_view type, std::string body) {
    Response response(status, 11);
    response.set(http::field::content_type, beast::string_view(type.data(), type.size()));
    response.set(http::field::cache_control, "no-cache");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.set("Referrer-Policy", "no-referrer");
    response.body() = std::move(body);
    return response;
  }
  static Response text(http::status status, std::string_view sentence) {
    return content(status, "text/plain; charset=utf-8", printable(sentence) + "\n");
  }

  bool reply(const Request& request, Response response) {
    response.version(request.version());
    response.keep_alive(request.keep_alive() && !is_ending_);
    answer(std::move(response), request.method() == http::verb::head);
    return true;
  }

  void answer(Response response, bool without_body = false) {
    response.prepare_payload();
    if (without_body) response.body().clear();  // its length is still told
    is_answering_ = true;
    stream_.expires_after(duration_of(hub_.options.write_s));
    response_ = std::move(response);
    http::async_write(stream_, response_, [self = self<RequestSession>()](Fault fault, std::size_t) {
      self->is_answering_ = false;
      if (fault) return self->close();
      if (!self->response_.keep_alive() || self->is_ending_) return self->part();
      self->read();
    });
  }

  /// Who has not yet sent all gets the answer nevertheless: closing at once would take it back.
  void part() {
    Fault ignored;
    stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
    stream_.expires_after(kFarewell);
    discard(0);
  }
  void discard(std::size_t before) {
    buffer_.clear();
    stream_.async_read_some(buffer_.prepare(kMostMessage),
                            [self = self<RequestSession>(), before](Fault fault, std::size_t size) {
                              if (fault || before + size > kMostDiscarded || self->hub_.is_ending)
                                return self->close();
                              self->discard(before + size);
                            });
  }

  bool begin_lines(const Request& request) {
    if (request.method() != http::verb::get) return false;
    std::make_shared<LineSession>(hub_, std::move(stream_), request.version() >= 11)->begin();
    return true;
  }
  bool begin_socket(const Request& request, SocketSession::Kind kind) {
    if (!websocket::is_upgrade(request)) {
      Response response = text(http::status::upgrade_required,
                               "This is a WebSocket. Records are at /api/records.jsonl without one.");
      response.set(http::field::upgrade, "websocket");
      return reply(request, std::move(response));
    }
    if (buffer_.size() > 0) return false;  // has sent more before it was accepted
    std::make_shared<SocketSession>(hub_, std::move(stream_), kind)->begin(request);
    return true;
  }

  Hub& hub_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{kMostHead + kMostMessage};
  std::optional<http::request_parser<http::string_body>> parser_;
  Response response_;
  bool is_answering_ = false;
  bool is_ending_ = false;
};

}  // namespace knuckle
