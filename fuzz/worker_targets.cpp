// SPDX-License-Identifier: Apache-2.0
// What workers of one training send each other.
#include "fuzz_target.h"

#include <stdexcept>

#include "knuckle/forest/pixel_samples.h"

namespace knuckle::fuzz {

/// Training images, one after another. Each that is read can be trained on: all its pixels lead somewhere.
void run_worker_samples(Bytes bytes) {
  PixelSamples samples(0);
  MessageReader reader(std::as_bytes(bytes));
  while (!reader.is_at_end()) {
    const PixelSamples::DepthImage& image = samples.images()[samples.put(reader)];
    for (const LabelledPixel& pixel : image.pixels) {
      const std::int16_t depth = image.depth(pixel.column, pixel.row);
      constexpr OffsetPair kFar{kMostOffset, -kMostOffset, -kMostOffset, kMostOffset};
      (void)offset_feature(image.depth, pixel.column, pixel.row, image.scale.at(depth), kFar);
      if (depth < 1 || depth > kFarDepth) throw std::logic_error("a depth that no image has");
    }
  }
  (void)arranged(samples);
}

}  // namespace knuckle::fuzz
