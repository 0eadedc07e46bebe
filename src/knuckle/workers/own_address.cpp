// SPDX-License-Identifier: Apache-2.0
#include "knuckle/workers/own_address.h"

#include <array>
#include <memory>

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

namespace knuckle {
namespace {

/// The own end of a datagram socket that is connected to an address: the system chooses it by its routes.
std::optional<std::string> own_end(const addrinfo& towards) {
  const int socket = ::socket(towards.ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return std::nullopt;
  sockaddr_storage own{};
  socklen_t size = sizeof(own);
  auto* const address = reinterpret_cast<sockaddr*>(&own);
  std::array<char, NI_MAXHOST> text{};
  const bool is_known =
      ::connect(socket, towards.ai_addr, towards.ai_addrlen) == 0 &&
      ::getsockname(socket, address, &size) == 0 &&
      ::getnameinfo(address, size, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) == 0;
  ::close(socket);
  return is_known ? std::optional<std::string>(text.data()) : std::nullopt;
}

}  // namespace

std::optional<std::string> own_address_towards(const std::string& host, std::uint16_t port) {
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found) != 0) return std::nullopt;
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> all(found, &::freeaddrinfo);
  for (const addrinfo* one = all.get(); one != nullptr; one = one->ai_next) {
    if (auto own = own_end(*one)) return own;
  }
  return std::nullopt;
}

}  // namespace knuckle
