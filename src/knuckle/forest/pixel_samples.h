// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/core/worker_messages.h"
#include "knuckle/forest/depth_tiles.h"

namespace knuckle {

/// A pixel of a depth image and its class: 0 or 1.
struct LabelledPixel {
  std::int16_t column = 0;
  std::int16_t row = 0;
  std::uint8_t label = 0;
};

/// Pixels of many depth images, to train a forest on. Images are set in any order, from many threads at once,
/// each at most once; those never set do not take part.
class PixelSamples {
 public:
  /// Room for `images` images.
  explicit PixelSamples(std::int64_t images);

  /// Keeps image `index` (as DepthTiles) and these pixels of it. Returns the bytes that they take. Throws an
  /// Error where the image has not its camera's size, or a pixel lies outside, is not measured
  /// within kFarDepth, or has another label.
  std::size_t set(std::int64_t index, const Image<float>& depth_mm, const Camera& camera,
                  std::span<const LabelledPixel> pixels);

  /// Bytes of an image and its pixels in a message to another worker.
  std::size_t message_bytes(std::uint32_t index) const;
  /// Appends an image and its pixels to the message; its place is free then.
  void take(std::uint32_t index, std::vector<std::byte>& message);
  /// Reads an image from a message, into a free place or a new one, and returns which. Throws an Error where
  /// it is none.
  std::uint32_t put(MessageReader& reader);

  std::int64_t sample_count() const;
  /// What images and pixels take so far.
  std::size_t bytes() const;

  /// One image with the pixels that training takes from it.
  struct DepthImage {
    DepthTiles depth;
    OffsetScale scale{Camera{}};
    std::vector<LabelledPixel> pixels;
    std::size_t bytes() const;
    /// Of image, scale at 1 mm and pixels.
    std::uint64_t hash() const;
  };
  std::span<const DepthImage> images() const { return images_; }

 private:
  std::vector<DepthImage> images_;
  std::vector<std::uint32_t> free_;  // places whose images were taken
};

/// The samples in the order that training works in: by contents only (a 64-bit hash of each image and its
/// samples), so that the forest does not depend on the order in which images were handed over.
struct ArrangedSamples {
  /// A pixel of an image.
  struct Sample {
    std::uint32_t image = 0;
    std::int16_t column = 0;
    std::int16_t row = 0;
  };

  std::vector<Sample> samples;
  std::vector<std::uint8_t> labels;
  std::uint64_t hash = 0;  ///< of all of them
};

/// Throws an Error where there are more than 2^32 - 1.
ArrangedSamples arranged(const PixelSamples& samples);

/// The hash of each image and its samples, by its index; one that was never set has one, too.
std::vector<std::uint64_t> hashes_of_images(const PixelSamples& samples);

/// Samples of which other workers may have those before and after.
struct ArrangedPart {
  ArrangedSamples samples;           ///< without a hash
  std::vector<std::uint64_t> words;  ///< from which the hash of all is mixed
};
/// Those of these images, in this order. `hashes` are those of all images.
ArrangedPart arranged(const PixelSamples& samples, std::span<const std::uint32_t> order,
                      std::span<const std::uint64_t> hashes);

}  // namespace knuckle
