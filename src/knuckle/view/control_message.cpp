// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/control_message.h"

#include <cstddef>

#include <nlohmann/json.hpp>

#include "knuckle/core/error.h"

namespace knuckle {

RecordingRequest parse_recording_request(std::string_view json) {
  constexpr const char* kExpected = R"(expected {"on": true} or {"on": false})";
  constexpr std::size_t kMostBytes = 256;  // nesting is bounded with it
  if (json.size() > kMostBytes) fail("{} bytes, {}", json.size(), kExpected);
  const auto request = nlohmann::json::parse(json, nullptr, /*allow_exceptions=*/false);
  if (request.size() != 1 || !request.contains("on")) fail("{}", kExpected);
  const auto& on = request["on"];
  if (!on.is_boolean()) fail("'on' is {}, {}", on.type_name(), kExpected);
  return {on.get<bool>()};
}

}  // namespace knuckle
