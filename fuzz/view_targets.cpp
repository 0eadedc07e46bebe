// SPDX-License-Identifier: Apache-2.0
// What the server of `live --view` reads itself of a request; the rest is Boost.Beast's.
#include "fuzz_target.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "knuckle/core/text.h"
#include "knuckle/view/control_message.h"
#include "knuckle/view/request_access.h"

namespace knuckle::fuzz {

/// The message that begins and ends recordings.
void run_control(Bytes bytes) {
  (void)parse_recording_request(as_text(bytes));
}

/// Target, Host, Origin and Cookie, a line each.
void run_request(Bytes bytes) {
  std::array<std::string_view, 4> parts{};
  const auto lines = split(as_text(bytes), '\n');
  std::ranges::copy_n(lines.begin(), static_cast<std::ptrdiff_t>(std::min(lines.size(), parts.size())),
                      parts.begin());
  const RequestOrigin request{parts[0], parts[1], parts[2], parts[3]};
  const std::string refusal = refusal_of(request, {});
  // The name of this machine is told again in an answer's field.
  const bool is_plain =
      request.host.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.:[]") ==
      std::string_view::npos;
  if (is_local_host(request.host) && !is_plain) throw std::logic_error("no machine has that name");
  if (refusal.empty() && !is_local_host(request.host)) throw std::logic_error("a foreign host is served");
  const RequestAccess access{.token = "00112233445566778899aabbccddeeff"};
  const bool knows_token = as_text(bytes).find(access.token) != std::string_view::npos;
  if (!knows_token && refusal_of(request, access).empty())
    throw std::logic_error("who does not know the token is served");
  (void)path_of(request.target);
}

}  // namespace knuckle::fuzz
