// SPDX-License-Identifier: Apache-2.0
// Names Boost: included by web_server.cpp alone.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include <boost/beast/websocket.hpp>

#include "knuckle/view/session.h"
#include "knuckle/view/waiting_records.h"

namespace knuckle {

namespace websocket = beast::websocket;

/// Of the system, for images [bytes]: old ones shall not pile up there.
inline constexpr int kImageBuffer = 1 << 19;

/// A client of a feed of texts or images.
class SocketSession final : public Session {
 public:
  SocketSession(Hub& hub, beast::tcp_stream stream, WebFeed kind)
      : hub_(hub), socket_(std::move(stream)), kind_(kind), deadline_(hub), message_deadline_(hub) {}
  ~SocketSession() override { hub_.leave(this); }

  void begin(const http::request<http::string_body>& request) {
    hub_.enter(shared_from_this());
    beast::get_lowest_layer(socket_).expires_never();  // Deadline stands for it from now on
    Fault ignored;
    if (kind_ == WebFeed::images) {
      beast::get_lowest_layer(socket_).socket().set_option(asio::socket_base::send_buffer_size(kImageBuffer),
                                                           ignored);
    }
    socket_.set_option(websocket::stream_base::timeout{websocket::stream_base::none(),
                                                       websocket::stream_base::none(), false});
    socket_.set_option(websocket::stream_base::decorator(
        [](websocket::response_type& response) { response.set(http::field::server, "knuckle"); }));
    socket_.read_message_max(kMostMessage);
    socket_.auto_fragment(false);  // one frame per message, sent from where it lies
    socket_.binary(kind_ == WebFeed::images);
    is_writing_ = true;
    deadline_.set(hub_.options.request_s, shared_from_this());
    socket_.async_accept(request, [self = self<SocketSession>()](Fault fault) { self->on_accepted(fault); });
  }

  void show() override {
    if (kind_ == WebFeed::texts) records_.add(hub_.newest_text());
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
    if (kind_ == WebFeed::texts && !records_.empty()) {
      const auto record = records_.take();
      send(asio::buffer(*record), record);
    } else if (kind_ == WebFeed::images && has_newer_) {
      const auto message = hub_.newest_image();
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
  WebFeed kind_;
  Deadline deadline_;
  Deadline message_deadline_;
  bool is_in_message_ = false;
  beast::flat_static_buffer<kMostMessage> said_;
  WaitingRecords records_;
  bool has_newer_ = false;
  bool is_writing_ = false;
  bool is_ending_ = false;
};

}  // namespace knuckle
