// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/network_config.h"

#include "knuckle/core/options.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle {

NetworkConfig NetworkConfig::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  NetworkConfig config{.source = source_in(document, "source"),
                       .validation = source_in(document, "validation"),
                       .network = {}};
  const OptionTable patch = document.table("patch");
  const OptionTable network = document.table("network");
  patch.read(config.network.patch);
  network.read(config.network);
  patch.finish();
  network.finish();
  check(config.network, path.string());
  return config;
}

}  // namespace knuckle
