// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/paper_network.h"

namespace knuckle {

PaperNetwork::PaperNetwork(const NetworkOptions& options)
    : NetworkModule(options.patch.size_px),
      banks_(register_module(
          "banks", std::make_shared<ConvolutionBanks>(options.patch.size_px, options.paper.first_maps,
                                                      options.paper.second_maps))),
      layers_(register_module(
          "layers", std::make_shared<FullyConnected>(banks_->feature_count(), connected_layers(options),
                                                     options.paper.dropout))) {}

}  // namespace knuckle
