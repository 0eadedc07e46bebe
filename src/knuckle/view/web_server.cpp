// SPDX-License-Identifier: Apache-2.0
// The only source that includes Boost, by the sessions' headers: it takes the compiler long.
#include "knuckle/view/web_server.h"

#include <chrono>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/post.hpp>

#include "knuckle/core/error.h"
#include "knuckle/view/request_session.h"

namespace knuckle {
namespace {

constexpr std::size_t kMostUpdates = 16;          // on their way to the server's thread
constexpr std::chrono::milliseconds kPause{100};  // after a connection could not be accepted

void check(const WebServerOptions& options) {
  constexpr int kMostPort = 65535;
  constexpr int kMostConnections = 4096;
  constexpr double kLongest = 3600.0;
  if (options.port < 0 || options.port > kMostPort)
    fail("server: the port is {}, expected 0 to {}", options.port, kMostPort);
  if (options.most_connections < 1 || options.most_connections > kMostConnections)
    fail("server: {} connections, expected 1 to {}", options.most_connections, kMostConnections);
  for (const double seconds : {options.request_s, options.write_s}) {
    if (!(seconds > 0.0 && seconds <= kLongest))
      fail("server: a limit of {} s, expected more than 0, at most {}", seconds, kLongest);
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

class WebServer::Impl {
 public:
  Impl(WebService service, const WebServerOptions& options) {
    check(options);
    hub_.service = std::move(service);
    hub_.options = options;
    hub_.page = read_page_files(options.page, options.index);
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

bool has_web_server() {
  return true;
}

WebServer::WebServer(WebService service, const WebServerOptions& options)
    : impl_(std::make_unique<Impl>(std::move(service), options)) {}

WebServer::~WebServer() = default;

const std::string& WebServer::address() const {
  return impl_->address();
}

void WebServer::publish(std::shared_ptr<const WebUpdate> update) {
  impl_->publish(std::move(update));
}

}  // namespace knuckle
