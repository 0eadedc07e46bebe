// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/encoder_decoder_shape.h"

namespace knuckle {

std::vector<EncoderDecoderUnit> encoder_decoder_units(const EncoderDecoderShape& shape) {
  const int channels[] = {shape.stem, shape.quarter, shape.eighth, shape.sixteenth};
  std::vector<EncoderDecoderUnit> units = {{"stem", shape.inputs, channels[0], 5, 2}};
  for (int stage = 1; stage <= kEncoderStages; ++stage) {
    const std::string number = std::to_string(stage);
    units.push_back({"down" + number, channels[stage - 1], channels[stage], 3, 2});
    for (int i = 0; i < shape.blocks; ++i) {
      const std::string block = "block" + number + "_" + std::to_string(i);
      units.push_back({block + ".first", channels[stage], channels[stage], 3, 1});
      units.push_back({block + ".second", channels[stage], channels[stage], 3, 1});
    }
  }
  units.push_back({"lateral2", channels[3], channels[2], 1, 1});
  units.push_back({"lateral1", channels[2], channels[1], 1, 1});
  units.push_back({"smooth2", channels[2], channels[2], 3, 1});
  units.push_back({"smooth1", channels[1], shape.head, 3, 1});
  return units;
}

std::vector<NetworkArray> encoder_decoder_arrays(const EncoderDecoderShape& shape) {
  using enum NetworkArray::Precision;
  std::vector<NetworkArray> arrays;
  for (const EncoderDecoderUnit& unit : encoder_decoder_units(shape)) {
    arrays.push_back(
        {unit.name + ".convolution.weight", {unit.outputs, unit.inputs, unit.kernel, unit.kernel}, half});
    add_norm(arrays, unit.name + ".norm", unit.outputs);
  }
  arrays.push_back({"head.weight", {shape.maps, shape.head, 1, 1}, half});
  arrays.push_back({"head.bias", {shape.maps}, half});
  return arrays;
}

}  // namespace knuckle
