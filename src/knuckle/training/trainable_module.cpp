// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/trainable_module.h"

#include <torch/utils.h>

namespace knuckle {

void lay_out_for_channels_last(TrainableModule& network) {
  for (torch::Tensor& parameter : network.parameters()) {
    if (parameter.dim() == 4) {
      parameter.set_data(parameter.detach().contiguous(torch::MemoryFormat::ChannelsLast));
    }
  }
}

}  // namespace knuckle
