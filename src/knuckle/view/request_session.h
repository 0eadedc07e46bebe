// SPDX-License-Identifier: Apache-2.0
// Names Boost: included by web_server.cpp alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <boost/asio/post.hpp>
#include <fmt/format.h>

#include "knuckle/core/text.h"
#include "knuckle/view/line_session.h"
#include "knuckle/view/session.h"
#include "knuckle/view/socket_session.h"

namespace knuckle {

inline constexpr std::uint32_t kMostHead = 8192;      ///< of a request [bytes]
inline constexpr std::uint64_t kMostBody = 8192;      ///< of a request [bytes]
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
  void close() override {
    stream_.close();
    const auto kept = std::exchange(alive_, nullptr);  // the last act where it was waiting
  }

 private:
  /// What of a request its answer hangs on.
  struct Asked {
    int version = 11;
    bool keeps_alive = false;
    bool is_head = false;
  };

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
    if (ask_service(request, path)) return true;
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return reply(request, response_of(only_get()));
    const auto feed = hub_.service.feeds.find(path);
    if (feed == hub_.service.feeds.end()) return reply(request, page_file(request, path));
    if (feed->second == WebFeed::lines) return begin_lines(request);
    return begin_socket(request, feed->second);
  }

  static WebAnswer only_get() {
    WebAnswer answer = sentence_answer(405, "Only GET is served here.");
    answer.allow = "GET, HEAD";
    return answer;
  }

  /// True where the service answers, now or later; until then the session keeps itself alive. The reply may
  /// come from another thread: it only leads back to this one.
  bool ask_service(const Request& request, std::string_view path) {
    const http::verb method = request.method();
    const bool is_post = method == http::verb::post;
    const bool is_known = is_post || method == http::verb::get || method == http::verb::head;
    if (!hub_.service.answer || !is_known) return false;
    const WebReply take = [&hub = hub_, weak = weak_from_this()](WebAnswer answer) {
      asio::post(hub.context, [weak, answer = std::move(answer)] {
        if (const auto session = weak.lock())
          std::static_pointer_cast<RequestSession>(session)->take_answer(answer);
      });
    };
    begin_waiting(request);
    const std::string_view target = view_of(request.target());
    const WebRequest wanted{is_post, std::string(path), std::string(target.substr(path.size())),
                            request.body()};
    if (hub_.service.answer(wanted, take)) return true;
    is_answering_ = false;
    alive_.reset();
    return false;
  }
  void begin_waiting(const Request& request) {
    is_answering_ = true;
    alive_ = shared_from_this();
    asked_.version = static_cast<int>(request.version());
    asked_.keeps_alive = request.keep_alive();
    asked_.is_head = request.method() == http::verb::head;
  }
  void take_answer(const WebAnswer& from_service) {
    if (!alive_) return;  // closed meanwhile
    const auto kept = std::exchange(alive_, nullptr);
    Response response = response_of(from_service);
    response.version(static_cast<unsigned>(asked_.version));
    response.keep_alive(asked_.keeps_alive && !is_ending_);
    answer(std::move(response), asked_.is_head);
  }

  Response page_file(const Request& request, std::string_view path) const {
    const auto file = hub_.page.find(path);
    if (file == hub_.page.end()) {
      return text(http::status::not_found,
                  path == "/"
                      ? fmt::format("The page is not installed: there is no web/dist/{} beside Knuckle's "
                                    "models. What is below /api is served.",
                                    hub_.options.index)
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

  static Response response_of(const WebAnswer& from_service) {
    Response response =
        content(static_cast<http::status>(from_service.status), from_service.content_type, from_service.body);
    if (!from_service.allow.empty()) response.set(http::field::allow, from_service.allow);
    return response;
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
    return response_of(sentence_answer(static_cast<int>(status), sentence));
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
  bool begin_socket(const Request& request, WebFeed kind) {
    if (!websocket::is_upgrade(request)) {
      Response response = text(http::status::upgrade_required,
                               fmt::format("This is a WebSocket.{}", hub_.service.without_socket));
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
  std::shared_ptr<Session> alive_;  ///< itself, while it waits for the service
  Asked asked_;
};

}  // namespace knuckle
