// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace knuckle {

/// The address of this machine, in numbers, from which packets go to a host: that of the network which joins
/// the two. Sends nothing. Nothing where the host's name is unknown, or no network leads there.
std::optional<std::string> own_address_towards(const std::string& host, std::uint16_t port);

}  // namespace knuckle
