// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace knuckle {

/// What of a request says where it comes from: texts as they were sent, empty where there was none.
struct RequestOrigin {
  std::string_view target;  ///< path and query, as in "/api/info?token=..."
  std::string_view host;    ///< the header `Host`
  std::string_view origin;  ///< the header `Origin`: the page that asks; scripts send none
  std::string_view cookie;  ///< the header `Cookie`
};

/// Who may ask.
struct RequestAccess {
  /// What every request has to know, in its query or in the cookie that the page gets; empty: requests of
  /// this machine are served, and no others.
  std::string token;
  std::string cookie_name = "knuckle_token";
};

/// The path of a request's target: all before '?' and '#'.
std::string_view path_of(std::string_view target);

/// The value of `name` in the target's query, as it was sent; empty where there is none.
std::string_view query_value(std::string_view target, std::string_view name);

/// Whether `host` (as in "localhost:8790", "127.0.0.1", "[::1]:80") names this machine, and nothing but a
/// machine and a port.
bool is_local_host(std::string_view host);

/// Why the request is refused, in a sentence; empty where it is served.
///
/// Without a token: its `Host` has to be this machine's, so that a foreign page whose name was made to lead
/// here (DNS rebinding) gets nothing; and its `Origin`, where it has one, so that foreign pages cannot open
/// sockets. With a token: the query has to hold it; or the cookie, and then a page that asks has to come from
/// the same address. Tokens are compared in a time that does not depend on what was sent.
std::string refusal_of(const RequestOrigin& request, const RequestAccess& access);

/// 128 random bits as 32 hexadecimal digits. Throws an Error where the system gives none.
std::string random_token();

}  // namespace knuckle
