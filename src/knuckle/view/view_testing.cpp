// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/view_testing.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <stdexcept>
#include <utility>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace knuckle::testing {

PlainClient::PlainClient(int port, int receive_bytes)
    : descriptor_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const timeval longest{10, 0};
  ::setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &longest, sizeof(longest));
  ::setsockopt(descriptor_, SOL_SOCKET, SO_SNDTIMEO, &longest, sizeof(longest));
  if (receive_bytes > 0)
    ::setsockopt(descriptor_, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof(receive_bytes));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0)
    throw std::runtime_error("nobody listens at the port");
}

PlainClient::~PlainClient() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

PlainClient::PlainClient(PlainClient&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), waiting_(std::move(other.waiting_)) {}

bool PlainClient::send(std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

void PlainClient::end_sending() const {
  ::shutdown(descriptor_, SHUT_WR);
}

bool PlainClient::fill() {
  char block[65536];
  const ssize_t count = ::recv(descriptor_, block, sizeof(block), 0);
  if (count <= 0) return false;
  waiting_.append(block, static_cast<std::size_t>(count));
  return true;
}

std::string PlainClient::line() {
  std::size_t end = 0;
  while ((end = waiting_.find('\n')) == std::string::npos) {
    if (!fill()) return {};
  }
  std::string line = waiting_.substr(0, end);
  waiting_.erase(0, end + 1);
  if (line.ends_with('\r')) line.pop_back();
  return line;
}

std::string PlainClient::bytes(std::size_t count) {
  while (waiting_.size() < count && fill()) {
  }
  std::string bytes = waiting_.substr(0, count);
  waiting_.erase(0, bytes.size());
  return bytes;
}

bool PlainClient::ends() {
  waiting_.clear();
  char block[65536];
  ssize_t count = 0;
  while ((count = ::recv(descriptor_, block, sizeof(block), 0)) > 0) {
  }
  return count == 0 || (errno != EAGAIN && errno != EWOULDBLOCK);
}

HttpAnswer PlainClient::answer(bool has_body) {
  HttpAnswer answer;
  const std::string status = line();
  if (!status.starts_with("HTTP/1.")) return answer;
  answer.status = std::stoi(status.substr(std::string_view("HTTP/1.1 ").size()));
  for (std::string field = line(); !field.empty(); field = line()) {
    const std::size_t colon = field.find(':');
    std::string name = field.substr(0, colon);
    std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
    answer.fields[name] = field.substr(colon + 2);
  }
  if (has_body && answer.fields.contains("content-length"))
    answer.body = bytes(std::stoul(answer.fields["content-length"]));
  return answer;
}

HttpAnswer PlainClient::open_socket(std::string_view target, std::string_view more_fields) {
  send(request(fmt::format("GET {}", target),
               fmt::format("Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{}",
                           more_fields)));
  return answer();
}

SocketMessage PlainClient::message() {
  const std::string head = bytes(2);
  if (head.size() < 2) return {};
  std::uint64_t size = static_cast<std::uint8_t>(head[1]);
  constexpr std::uint64_t kTwoBytes = 126;
  constexpr std::uint64_t kEightBytes = 127;
  if (size >= kTwoBytes) {
    const std::string more = bytes(size == kEightBytes ? 8 : 2);
    size = 0;
    for (const char c : more) size = size * 256 + static_cast<std::uint8_t>(c);
  }
  SocketMessage message{static_cast<std::uint8_t>(head[0]) & 15, bytes(size)};
  if (message.bytes.size() < size) return {};
  return message;
}

std::string request(std::string_view method_and_target, std::string_view more_fields, std::string_view body) {
  const bool has_host = more_fields.starts_with("Host:");
  std::string text = fmt::format("{} HTTP/1.1\r\n{}{}", method_and_target,
                                 has_host ? "" : "Host: localhost\r\n", more_fields);
  if (!body.empty()) text += fmt::format("Content-Length: {}\r\n", body.size());
  return text + "\r\n" + std::string(body);
}

std::string client_frame(int first_byte, std::string_view payload, bool mask) {
  constexpr std::size_t kMostInOneByte = 125;
  std::string frame{static_cast<char>(first_byte)};
  const int masked = mask ? 128 : 0;
  if (payload.size() <= kMostInOneByte) {
    frame += static_cast<char>(masked | static_cast<int>(payload.size()));
  } else {
    frame += static_cast<char>(masked | 126);
    frame += static_cast<char>(payload.size() / 256);
    frame += static_cast<char>(payload.size() % 256);
  }
  if (mask) frame += std::string(4, '\0');  // a mask that changes nothing
  return frame + std::string(payload);
}

int open_descriptors() {
  const std::filesystem::directory_iterator entries("/proc/self/fd");
  return static_cast<int>(std::distance(begin(entries), end(entries)));
}

}  // namespace knuckle::testing
