// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/dense_architecture.h"

namespace knuckle {

std::vector<DenseUnit> dense_units(const DenseNetworkOptions& options) {
  const int channels[] = {options.stem_channels, options.quarter_channels, options.eighth_channels,
                          options.sixteenth_channels};
  std::vector<DenseUnit> units = {{"stem", 1, channels[0], 5, 2}};
  for (int stage = 1; stage <= kDenseStages; ++stage) {
    const std::string number = std::to_string(stage);
    units.push_back({"down" + number, channels[stage - 1], channels[stage], 3, 2});
    for (int i = 0; i < options.blocks; ++i) {
      const std::string block = "block" + number + "_" + std::to_string(i);
      units.push_back({block + ".first", channels[stage], channels[stage], 3, 1});
      units.push_back({block + ".second", channels[stage], channels[stage], 3, 1});
    }
  }
  units.push_back({"lateral2", channels[3], channels[2], 1, 1});
  units.push_back({"lateral1", channels[2], channels[1], 1, 1});
  units.push_back({"smooth2", channels[2], channels[2], 3, 1});
  units.push_back({"smooth1", channels[1], options.head_channels, 3, 1});
  return units;
}

std::vector<NetworkArray> dense_arrays(const NetworkOptions& options) {
  using enum NetworkArray::Precision;
  std::vector<NetworkArray> arrays;
  for (const DenseUnit& unit : dense_units(options.dense)) {
    arrays.push_back(
        {unit.name + ".convolution.weight", {unit.outputs, unit.inputs, unit.kernel, unit.kernel}, half});
    add_norm(arrays, unit.name + ".norm", unit.outputs);
  }
  const int maps = kMapsPerJoint * options.joint_count();
  arrays.push_back({"head.weight", {maps, options.dense.head_channels, 1, 1}, half});
  arrays.push_back({"head.bias", {maps}, half});
  return arrays;
}

}  // namespace knuckle
