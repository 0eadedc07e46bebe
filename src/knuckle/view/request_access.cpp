// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/request_access.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <sys/random.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

bool is_digits(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

bool is_port(std::string_view text) {
  constexpr std::size_t kMostDigits = 5;
  return !text.empty() && text.size() <= kMostDigits && is_digits(text);
}

/// 127.x.x.x: the addresses by which a machine calls itself.
bool is_loopback_v4(std::string_view name) {
  const std::vector<std::string_view> parts = split(name, '.');
  constexpr std::size_t kMostDigits = 3;
  return parts.size() == 4 && parts[0] == "127" && std::ranges::all_of(parts, [](std::string_view part) {
           return !part.empty() && part.size() <= kMostDigits && is_digits(part);
         });
}

/// The machine and port that a page comes from; nothing where the text is no origin of http or https.
std::optional<std::string_view> host_of_origin(std::string_view origin) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (origin.starts_with(scheme)) return origin.substr(scheme.size());
  }
  return std::nullopt;  // "null", files, extensions
}

/// Looks at all of `expected`, whatever was sent.
bool is_same_secret(std::string_view sent, std::string_view expected) {
  std::uint8_t difference = sent.size() == expected.size() ? 0 : 1;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const char other = i < sent.size() ? sent[i] : '\0';
    difference |= static_cast<std::uint8_t>(other ^ expected[i]);
  }
  return difference == 0;
}

std::string_view cookie_value(std::string_view cookies, std::string_view name) {
  for (const std::string_view part : split(cookies, ';')) {
    const std::string_view cookie = trimmed(part);
    if (cookie.starts_with(name) && cookie.substr(name.size()).starts_with('='))
      return cookie.substr(name.size() + 1);
  }
  return {};
}

std::string refusal_without_token(const RequestOrigin& request) {
  if (!is_local_host(request.host)) return "This address is served to this machine alone.";
  if (request.origin.empty()) return {};
  const auto page = host_of_origin(request.origin);
  if (!page || !is_local_host(*page)) return "Pages of other places are not served.";
  return {};
}

std::string refusal_with_token(const RequestOrigin& request, const RequestAccess& access) {
  if (is_same_secret(query_value(request.target, "token"), access.token)) return {};
  constexpr const char* kWithoutToken = "The token of the address that the program printed is missing.";
  if (!is_same_secret(cookie_value(request.cookie, access.cookie_name), access.token)) return kWithoutToken;
  // Browsers send cookies along with requests of other pages, too.
  if (!request.origin.empty() && host_of_origin(request.origin) != request.host)
    return "Pages of other places are not served.";
  return {};
}

}  // namespace

std::string_view path_of(std::string_view target) {
  return target.substr(0, target.find_first_of("?#"));
}

std::string_view query_value(std::string_view target, std::string_view name) {
  const std::size_t question = target.find('?');
  if (question == std::string_view::npos) return {};
  const std::string_view query = target.substr(question + 1);
  for (const std::string_view part : split(query.substr(0, query.find('#')), '&')) {
    if (part.starts_with(name) && part.substr(name.size()).starts_with('='))
      return part.substr(name.size() + 1);
  }
  return {};
}

bool is_local_host(std::string_view host) {
  std::string_view name = host;
  if (const std::size_t colon = host.rfind(':'); colon != std::string_view::npos && !host.ends_with(']')) {
    name = host.substr(0, colon);
    if (!is_port(host.substr(colon + 1))) return false;
  }
  return lower_case(name) == "localhost" || name == "[::1]" || is_loopback_v4(name);
}

std::string refusal_of(const RequestOrigin& request, const RequestAccess& access) {
  return access.token.empty() ? refusal_without_token(request) : refusal_with_token(request, access);
}

std::string random_token() {
  std::array<std::uint8_t, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    fail("the system gives no random numbers, which a token is made of");
  std::string token;
  for (const std::uint8_t byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

}  // namespace knuckle
