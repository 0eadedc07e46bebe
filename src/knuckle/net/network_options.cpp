// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_options.h"

#include <array>

#include "knuckle/core/limits.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/net/network_architectures.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 2> kPeaks = {"gaussian", "mean_shift"};

/// Throws where one patch's features would take more memory than a machine has to spare for each of its
/// cores: a small file could ask for that.
void check_memory(const NetworkOptions& options, std::string_view what) {
  constexpr auto kMostFeatures = static_cast<double>(limits::kPatchFeatures);  // a quarter of a gigabyte
  const double pixels = static_cast<double>(options.patch.size_px) * options.patch.size_px;
  const DenseNetworkOptions& dense = options.dense;
  const PaperNetworkOptions& paper = options.paper;
  const double features = options.architecture == "dense"
                              ? pixels * (dense.stem_channels / 4.0 + dense.quarter_channels / 16.0 +
                                          dense.eighth_channels / 64.0 + dense.sixteenth_channels / 256.0 +
                                          dense.head_channels / 16.0)
                              : pixels * (paper.first_maps + paper.second_maps);
  if (features > kMostFeatures) {
    fail("{}: a patch of {} px and so many channels make {:.0f} features per patch, expected at most {:.0f}",
         what, options.patch.size_px, features, kMostFeatures);
  }
}

}  // namespace

void DenseNetworkOptions::visit(OptionVisitor& visitor) {
  visitor.integer("stem_channels", stem_channels, closed(1, 1024));
  visitor.integer("quarter_channels", quarter_channels, closed(1, 1024));
  visitor.integer("eighth_channels", eighth_channels, closed(1, 1024));
  visitor.integer("sixteenth_channels", sixteenth_channels, closed(1, 1024));
  visitor.integer("head_channels", head_channels, closed(1, 1024));
  visitor.integer("blocks", blocks, closed(1, 16));
  visitor.real("kernel", kernel, open_closed(0, 4));
  visitor.real("dense_weight", dense_weight, closed(0, 100));
  visitor.flag("tells_side", tells_side);
  visitor.flag("tells_hand", tells_hand);
  visitor.real("question_weight", question_weight, closed(0, 100));
}

void PaperNetworkOptions::visit(OptionVisitor& visitor) {
  visitor.integer("first_maps", first_maps, closed(1, 1024));
  visitor.integer("second_maps", second_maps, closed(1, 1024));
  visitor.integer("hidden_units", hidden_units, closed(1, 65536));
  visitor.integer("subspace_units", subspace_units, closed(1, 65536));
  visitor.real("dropout", dropout, closed_open(0, 1));
  visitor.integer("map_cells", map_cells, closed(4, 256));
  visitor.integer("depth_bins", depth_bins, closed(3, 1024));
  visitor.real("peak_deviation", peak_deviation, closed(0.5, 10));
  visitor.choice("peak", peak, kPeaks);
}

void NetworkOptions::visit(OptionVisitor& visitor) {
  visitor.choice("architecture", architecture, network_architectures());
  visitor.text("convention", convention);
  architecture_of(*this).visit(*this, visitor);
}

const Convention& NetworkOptions::landmarks() const {
  return convention_from_text(convention);
}

void check(const NetworkOptions& options, std::string_view what) {
  check_options(options, what);
  check_options(options.patch, what);
  (void)options.landmarks();
  const int size = options.patch.size_px;
  if (!options.patch.is_cube()) {
    fail("{}: the network \"{}\" sees patches of the mode \"cube\"", what, options.architecture);
  }
  const int smallest = architecture_of(options).smallest_patch_px;
  if (size % kNetworkStride != 0 || size < smallest) {
    fail("{}: size_px is {}, expected a multiple of {}, at least {}, for the network \"{}\"", what, size,
         kNetworkStride, smallest, options.architecture);
  }
  check_memory(options, what);
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
