// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_options.h"

#include <array>

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 1> kArchitectures = {"dense"};
constexpr int kDenseStride = 16;  // of the coarsest features

}  // namespace

std::span<const std::string_view> network_architectures() {
  return kArchitectures;
}

void DenseNetworkOptions::visit(OptionVisitor& visitor) {
  visitor.integer("stem_channels", stem_channels, closed(1, 1024));
  visitor.integer("quarter_channels", quarter_channels, closed(1, 1024));
  visitor.integer("eighth_channels", eighth_channels, closed(1, 1024));
  visitor.integer("sixteenth_channels", sixteenth_channels, closed(1, 1024));
  visitor.integer("head_channels", head_channels, closed(1, 1024));
  visitor.integer("blocks", blocks, closed(1, 16));
  visitor.real("kernel", kernel, open_closed(0, 4));
  visitor.real("dense_weight", dense_weight, closed(0, 100));
}

void NetworkOptions::visit(OptionVisitor& visitor) {
  visitor.choice("architecture", architecture, kArchitectures);
  visitor.text("convention", convention);
  dense.visit(visitor);
}

void check(const NetworkOptions& options, std::string_view what) {
  check_options(options, what);
  check_options(options.patch, what);
  convention_from_name(options.convention);
  if (!options.patch.is_cube()) fail("{}: the network \"dense\" sees patches of the mode \"cube\"", what);
  if (options.patch.size_px % kDenseStride != 0) {
    fail("{}: size_px is {}, expected a multiple of {} for the network \"dense\"", what,
         options.patch.size_px, kDenseStride);
  }
}

std::string network_options_as_toml(const NetworkOptions& options) {
  return "[patch]\n" + options_as_toml(options.patch) + "[network]\n" + options_as_toml(options);
}

NetworkOptions network_options_from_toml(std::string_view toml, const std::string& origin) {
  const OptionTable document = OptionTable::parse(toml, origin);
  NetworkOptions options;
  document.table("patch").read(options.patch);
  document.table("network").read(options);
  document.finish();
  check(options, origin);
  return options;
}

}  // namespace knuckle
