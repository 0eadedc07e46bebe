// SPDX-License-Identifier: Apache-2.0
// The only file that includes Boost: it takes the compiler long.
#include "knuckle/view/live_server.h"

#include <chrono>
#include <cmath>
#include <deque>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <utility>

#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/view/control_message.h"
#include "knuckle/view/page_files.h"
#include "knuckle/view/request_access.h"

namespace knuckle {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;
using Fault = beast::error_code;
using Update = std::shared_ptr<const LiveUpdate>;
using Seconds = std::chrono::duration<double>;

constexpr std::size_t kMostUpdates = 16;       // on their way to the server's thread
constexpr std::size_t kMostRecords = 64;       // on their way to a client
constexpr std::uint32_t kMostHead = 8192;      // of a request [bytes]
constexpr std::uint64_t kMostBody = 1024;      // the same
constexpr std::size_t kMostMessage = 4096;     // of a client [bytes]
constexpr std::size_t kMostDiscarded = 65536;  // after a refusal [bytes]
constexpr int kFrameBuffer = 1 << 19;          // of the system for frames [bytes]: old ones shall not pile up
constexpr std::chrono::seconds kFarewell{1};
constexpr std::chrono::milliseconds kPause{100};  // after a connection could not be accepted

using Steady = std::chrono::steady_clock;

Steady::duration duration_of(double seconds) {
  return std::chrono::duration_cast<Steady::duration>(Seconds(seconds));
}

std::string_view view_of(beast::string_view text) {
  return {text.data(), text.size()};
}

/// Who is connected: kept alive by the operations that are on their way.
class Session : public std::enable_shared_from_this<Session> {
 public:
  Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  virtual ~Session() = default;

  /// There is a new frame, the hub's newest.
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
  LiveInfo info;
  LiveServerOptions options;
  RecordingControl recording;
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
  /// The message of the newest frame, made when the first client asks for it.
  const std::shared_ptr<const std::vector<std::uint8_t>>& newest_message() {
    if (message_ == nullptr)
      message_ = std::make_shared<const std::vector<std::uint8_t>>(frame_message(*newest));
    return message_;
  }
  /// The record of the newest frame, likewise.
  const std::shared_ptr<const std::string>& newest_record() {
    if (record_ == nullptr) record_ = std::make_shared<const std::string>(to_json_line(newest->record));
    return record_;
  }
  void set_newest(Update update) {
    newest = std::move(update);
    message_.reset();
    record_.reset();
  }

 private:
  std::shared_ptr<const std::vector<std::uint8_t>> message_;
  std::shared_ptr<const std::string> record_;
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

/// The records that wait for a client. Where it reads too slowly, the oldest are lost.
class WaitingRecords {
 public:
  void add(std::shared_ptr<const std::string> record) {
    if (records_.size() == kMostRecords) records_.pop_front();
    records_.push_back(std::move(record));
  }
  bool empty() const { return records_.empty(); }
  std::shared_ptr<const std::string> take() {
    auto record = std::move(records_.front());
    records_.pop_front();
    return record;
  }

 private:
  std::deque<std::shared_ptr<const std::string>> records_;
};

/// A client of /api/records or /api/frames.
class SocketSession final : public Session {
 public:
  enum class Kind { records, frames };

  SocketSession(Hub& hub, beast::tcp_stream stream, Kind kind)
      : hub_(hub), socket_(std::move(stream)), kind_(kind), deadline_(hub), message_deadline_(hub) {}
  ~SocketSession() override { hub_.leave(this); }

  void begin(const http::request<http::string_body>& request) {
    hub_.enter(shared_from_this());
    beast::get_lowest_layer(socket_).expires_never();  // Deadline stands for it from now on
    Fault ignored;
    if (kind_ == Kind::frames) {
      beast::get_lowest_layer(socket_).socket().set_option(asio::socket_base::send_buffer_size(kFrameBuffer),
                                                           ignored);
    }
    socket_.set_option(websocket::stream_base::timeout{websocket::stream_base::none(),
                                                       websocket::stream_base::none(), false});
    socket_.set_option(websocket::stream_base::decorator(
        [](websocket::response_type& response) { response.set(http::field::server, "knuckle"); }));
    socket_.read_message_max(kMostMessage);
    socket_.auto_fragment(false);  // one frame per message, sent from where it lies
    socket_.binary(kind_ == Kind::frames);
    is_writing_ = true;
    deadline_.set(hub_.options.request_s, shared_from_this());
    socket_.async_accept(request, [self = self<SocketSession>()](Fault fault) { self->on_accepted(fault); });
  }

  void show() override {
    if (kind_ == Kind::records) records_.add(hub_.newest_record());
    has_newer_ = true;
    write();
  }
  void end() override {
    is_ending_ = true;
    write();
  }
  void close() override { beast::get_lowest_layer(socket_).close(); }

 private:
  void on_accepted(Fault fault) {
    is_writing_ = false;
    deadline_.clear();
    if (fault) return;
    has_newer_ = hub_.newest != nullptr;
    read();
    write();
  }

  /// What clients say is not looked at. A message has to be whole soon, and small.
  void read() {
    socket_.async_read_some(said_, kMostMessage,
                            [self = self<SocketSession>()](Fault fault, std::size_t size) {
                              if (fault) return self->close();
                              self->said_.consume(size);
                              self->watch_message();
                              self->read();
                            });
  }
  void watch_message() {
    const bool is_whole = socket_.is_message_done();
    if (is_whole) message_deadline_.clear();
    if (!is_whole && !is_in_message_) message_deadline_.set(hub_.options.request_s, shared_from_this());
    is_in_message_ = !is_whole;
  }

  void write() {
    if (is_writing_) return;
    if (kind_ == Kind::records && !records_.empty()) {
      const auto record = records_.take();
      send(asio::buffer(*record), record);
    } else if (kind_ == Kind::frames && has_newer_) {
      const auto message = hub_.newest_message();
      send(asio::buffer(*message), message);
    } else if (is_ending_) {
      is_writing_ = true;
      socket_.async_close(websocket::close_code::going_away,
                          [self = self<SocketSession>()](Fault) { self->close(); });
    }
  }

  template <class Owner>
  void send(asio::const_buffer bytes, Owner owner) {
    is_writing_ = true;
    has_newer_ = false;
    deadline_.set(hub_.options.write_s, shared_from_this());
    socket_.async_write(bytes, [self = self<SocketSession>(), owner](Fault fault, std::size_t) {
      self->deadline_.clear();
      self->is_writing_ = false;
      if (fault) return self->close();
      self->write();
    });
  }

  Hub& hub_;
  websocket::stream<beast::tcp_stream> socket_;
  Kind kind_;
  Deadline deadline_;
  Deadline message_deadline_;
  bool is_in_message_ = false;
  beast::flat_static_buffer<kMostMessage> said_;
  WaitingRecords records_;
  bool has_newer_ = false;
  bool is_writing_ = false;
  bool is_ending_ = false;
};

/// A client of /api/records.jsonl: an answer without an end, a line per record.
class LineSession final : public Session {
 public:
  /// `is_chunked`: HTTP/1.1 wants to know where pieces end.
  LineSession(Hub& hub, beast::tcp_stream stream, bool is_chunked)
      : hub_(hub), stream_(std::move(stream)), is_chunked_(is_chunked), deadline_(hub) {}
  ~LineSession() override { hub_.leave(this); }

  void begin() {
    hub_.enter(shared_from_this());
    stream_.expires_never();
    std::string head =
        is_chunked_ ? "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n" : "HTTP/1.0 200 OK\r\n";
    head +=
        "Content-Type: application/x-ndjson\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
        "Connection: close\r\n\r\n";
    send(std::move(head));
    read();
  }
  void show() override {
    records_.add(hub_.newest_record());
    write();
  }
  void end() override {
    is_ending_ = true;
    write();
  }
  void close() override { stream_.close(); }

 private:
  /// Sees that the client goes away. What else it says is not looked at.
  void read() {
    stream_.async_read_some(asio::buffer(said_), [self = self<LineSession>()](Fault fault, std::size_t) {
      if (fault) return self->close();
      self->read();
    });
  }
  void write() {
    if (is_writing_) return;
    if (!records_.empty()) return send(piece_of(*records_.take()));
    if (!is_ending_) return;
    if (is_chunked_ && !std::exchange(is_last_sent_, true)) return send("0\r\n\r\n");
    close();
  }
  std::string piece_of(const std::string& record) const {
    return is_chunked_ ? fmt::format("{:x}\r\n{}\n\r\n", record.size() + 1, record) : record + "\n";
  }
  void send(std::string piece) {
    is_writing_ = true;
    deadline_.set(hub_.options.write_s, shared_from_this());
    sent_ = std::move(piece);
    asio::async_write(stream_, asio::buffer(sent_), [self = self<LineSession>()](Fault fault, std::size_t) {
      self->deadline_.clear();
      self->is_writing_ = false;
      if (fault) return self->close();
      self->write();
    });
  }

  Hub& hub_;
  beast::tcp_stream stream_;
  bool is_chunked_;
  Deadline deadline_;
  std::array<char, 512> said_{};
  WaitingRecords records_;
  std::string sent_;
  bool is_writing_ = false;
  bool is_ending_ = false;
  bool is_last_sent_ = false;
};

using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;

/// Where the page may load things from, and whom it may talk to. Old browsers do not count sockets as 'self'.
std::string content_policy(std::string_view host) {
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

void check(const LiveServerOptions& options) {
  constexpr int kMostPort = 65535;
  constexpr int kMostConnections = 4096;
  constexpr double kLongest = 3600.0;
  if (options.port < 0 || options.port > kMostPort)
    fail("live server: the port is {}, expected 0 to {}", options.port, kMostPort);
  if (options.most_connections < 1 || options.most_connections > kMostConnections)
    fail("live server: {} connections, expected 1 to {}", options.most_connections, kMostConnections);
  for (const double seconds : {options.request_s, options.write_s}) {
    if (!(seconds > 0.0 && seconds <= kLongest))
      fail("live server: a limit of {} s, expected more than 0, at most {}", seconds, kLongest);
  }
}

asio::ip::address address_of(const std::string& host) {
  if (host == "localhost") return asio::ip::address_v4::loopback();
  Fault fault;
  auto address = asio::ip::make_address(host, fault);
  if (fault) fail("--host {}: expected an address of this machine, such as 127.0.0.1 or 0.0.0.0", host);
  return address;
}

Tcp::acceptor acceptor_on(asio::io_context& context, const asio::ip::address& address, int port) {
  const Tcp::endpoint endpoint(address, static_cast<std::uint16_t>(port));
  Tcp::acceptor acceptor(context);
  Fault fault;
  acceptor.open(endpoint.protocol(), fault);
  if (!fault) acceptor.set_option(asio::socket_base::reuse_address(true), fault);
  if (!fault) acceptor.bind(endpoint, fault);
  if (!fault) acceptor.listen(asio::socket_base::max_listen_connections, fault);
  if (fault == asio::error::address_in_use) {
    fail("port {} of {} is in use by another program; choose another port, or 0 for any that is free", port,
         address.to_string());
  }
  if (fault) fail("port {} of {} cannot be served: {}", port, address.to_string(), fault.message());
  return acceptor;
}

/// The address for the user's browser.
std::string address_text(const Tcp::endpoint& endpoint, const std::string& token) {
  const asio::ip::address address = endpoint.address();
  Fault unknown;
  std::string host = address.is_v6() ? fmt::format("[{}]", address.to_string()) : address.to_string();
  if (address.is_unspecified()) {
    if (std::string name = asio::ip::host_name(unknown); !unknown) host = std::move(name);
  }
  return fmt::format("http://{}:{}/{}{}", host, endpoint.port(), token.empty() ? "" : "?token=", token);
}

}  // namespace

class LiveServer::Impl {
 public:
  Impl(LiveInfo info, const LiveServerOptions& options, RecordingControl recording) {
    check(options);
    hub_.info = std::move(info);
    hub_.options = options;
    hub_.recording = std::move(recording);
    hub_.page = read_page_files(options.page);
    const asio::ip::address address = address_of(options.host);
    if (!address.is_loopback()) hub_.access.token = random_token();
    acceptor_.emplace(acceptor_on(hub_.context, address, options.port));
    const Tcp::endpoint endpoint = acceptor_->local_endpoint();
    hub_.access.cookie_name = fmt::format("knuckle_token_{}", endpoint.port());  // ports share cookies
    address_ = address_text(endpoint, hub_.access.token);
    accept();
    thread_ = std::thread([this] { run(); });
  }
  ~Impl() {
    asio::post(hub_.context, [this] { end(); });
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const std::string& address() const { return address_; }

  void publish(Update update) {
    {
      const std::lock_guard lock(mutex_);
      if (updates_.size() == kMostUpdates) updates_.pop_front();
      updates_.push_back(std::move(update));
      if (updates_.size() > 1) return;  // the server's thread is on its way
    }
    asio::post(hub_.context, [this] { show_updates(); });
  }

 private:
  void run() {
    while (true) {
      try {
        hub_.context.run();
        return;
      } catch (const std::exception&) {  // ends the connection that it happened in, and no other
      }
    }
  }

  void accept() {
    acceptor_->async_accept([this](Fault fault, Tcp::socket socket) {
      if (hub_.is_ending) return;
      if (fault) {  // no descriptor is left, say
        pause_.expires_after(kPause);
        return pause_.async_wait([this](Fault cancelled) {
          if (!cancelled && !hub_.is_ending) accept();
        });
      }
      accept();  // first: whatever happens to this one, others are welcome
      welcome(std::move(socket));
    });
  }

  void welcome(Tcp::socket socket) {
    Fault ignored;
    socket.set_option(Tcp::no_delay(true), ignored);
    socket.set_option(asio::socket_base::keep_alive(true), ignored);
    if (hub_.sessions.size() < static_cast<std::size_t>(hub_.options.most_connections))
      return std::make_shared<RequestSession>(hub_, std::move(socket))->begin();
    static constexpr std::string_view kFull =
        "HTTP/1.1 503 Service Unavailable\r\nContent-Type: text/plain\r\nContent-Length: 29\r\n"
        "Connection: close\r\n\r\nToo many are connected here.\n";
    socket.non_blocking(true, ignored);
    socket.write_some(asio::buffer(kFull.data(), kFull.size()), ignored);
    socket.shutdown(Tcp::socket::shutdown_send, ignored);
  }

  void show_updates() {
    std::deque<Update> updates;
    {
      const std::lock_guard lock(mutex_);
      updates.swap(updates_);
    }
    for (const Update& update : updates) {
      hub_.set_newest(update);
      hub_.for_each_session([](Session& session) { session.show(); });
    }
  }

  void end() {
    show_updates();
    hub_.is_ending = true;
    acceptor_->close();
    pause_.cancel();
    hub_.for_each_session([](Session& session) { session.end(); });
    if (hub_.sessions.empty()) return;
    hub_.farewell.expires_after(kFarewell);
    hub_.farewell.async_wait([this](Fault cancelled) {
      if (!cancelled) hub_.for_each_session([](Session& session) { session.close(); });
    });
  }

  Hub hub_;
  std::optional<Tcp::acceptor> acceptor_;
  asio::steady_timer pause_{hub_.context};
  std::string address_;
  std::mutex mutex_;
  std::deque<Update> updates_;  ///< published, not shown yet
  std::thread thread_;
};

bool has_live_server() {
  return true;
}

LiveServer::LiveServer(LiveInfo info, const LiveServerOptions& options, RecordingControl recording)
    : impl_(std::make_unique<Impl>(std::move(info), options, std::move(recording))) {}

LiveServer::~LiveServer() = default;

const std::string& LiveServer::address() const {
  return impl_->address();
}

void LiveServer::publish(std::shared_ptr<const LiveUpdate> update) {
  impl_->publish(std::move(update));
}

}  // namespace knuckle
