// SPDX-License-Identifier: Apache-2.0
// Names Boost: included by web_server.cpp alone.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>

#include <boost/asio/write.hpp>
#include <fmt/format.h>

#include "knuckle/view/session.h"
#include "knuckle/view/waiting_records.h"

namespace knuckle {

/// A client of a feed of lines: an answer without an end.
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
    records_.add(hub_.newest_text());
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

}  // namespace knuckle
