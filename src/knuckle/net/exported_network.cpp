// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/exported_network.h"

#include "knuckle/core/error.h"
#include "knuckle/net/network_file.h"

namespace knuckle {
namespace {

constexpr const char* kKind = "knuckle.kind";
constexpr const char* kOptions = "knuckle.options";

}  // namespace

void set_exported_options(OnnxModel& model, const NetworkOptions& options) {
  model.metadata[kKind] = kNetworkFormat.name;
  model.metadata[kOptions] = network_options_as_toml(options);
}

std::optional<NetworkOptions> exported_options(const OnnxModel& model, const std::string& origin) {
  const auto kind = model.metadata.find(kKind);
  if (kind == model.metadata.end()) return std::nullopt;
  if (kind->second != kNetworkFormat.name) {
    fail("{}: it is a \"{}\", expected a \"{}\", a network that infers poses", origin, kind->second,
         kNetworkFormat.name);
  }
  const auto options = model.metadata.find(kOptions);
  if (options == model.metadata.end()) fail("{}: its metadata have no {}", origin, kOptions);
  return network_options_from_toml(options->second, origin + ": " + kOptions);
}

}  // namespace knuckle
