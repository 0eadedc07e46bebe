// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/pixel_samples.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <tuple>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/forest/mixed_hash.h"

namespace knuckle {

PixelSamples::PixelSamples(std::int64_t images) : images_(static_cast<std::size_t>(images)) {}

std::size_t PixelSamples::DepthImage::bytes() const {
  return depth.bytes() + sizeof(scale) + sizeof(decltype(pixels)) + pixels.capacity() * sizeof(LabelledPixel);
}

std::size_t PixelSamples::set(std::int64_t index, const Image<float>& depth_mm, const Camera& camera,
                              std::span<const LabelledPixel> pixels) {
  if (index < 0 || index >= std::ssize(images_))
    fail("training image {}: there is room for {}", index, images_.size());
  if (depth_mm.width() != camera.width || depth_mm.height() != camera.height) {
    fail("training image {}: {} x {} pixels, its camera {} x {}", index, depth_mm.width(), depth_mm.height(),
         camera.width, camera.height);
  }
  for (const LabelledPixel& pixel : pixels) {
    if (!depth_mm.contains(pixel.column, pixel.row) ||
        stored_depth(depth_mm(pixel.column, pixel.row)) == kFarDepth) {
      fail("training image {}: pixel ({}, {}) was not measured within {} mm", index, pixel.column, pixel.row,
           kFarDepth);
    }
    if (pixel.label > 1) fail("training image {}: label {}, expected 0 or 1", index, pixel.label);
  }
  DepthImage& image = images_[static_cast<std::size_t>(index)];
  image.depth = DepthTiles(depth_mm);
  image.scale = OffsetScale(camera);
  image.pixels.assign(pixels.begin(), pixels.end());
  std::ranges::sort(image.pixels, {},
                    [](const LabelledPixel& p) { return std::tuple(p.row, p.column, p.label); });
  return image.bytes();
}

std::int64_t PixelSamples::sample_count() const {
  std::int64_t count = 0;
  for (const DepthImage& image : images_) count += std::ssize(image.pixels);
  return count;
}

std::size_t PixelSamples::bytes() const {
  std::size_t bytes = 0;
  for (const DepthImage& image : images_) bytes += image.bytes();
  return bytes;
}

ArrangedSamples arranged(const PixelSamples& samples) {
  const std::int64_t count = samples.sample_count();
  if (count > std::numeric_limits<std::uint32_t>::max()) {
    fail("forest training: {} pixels, expected at most {}", count, std::numeric_limits<std::uint32_t>::max());
  }
  const std::span<const PixelSamples::DepthImage> images = samples.images();
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order(images.size());
  parallel_for(std::ssize(images), [&](std::int64_t i) {
    const auto index = static_cast<std::size_t>(i);
    const PixelSamples::DepthImage& image = images[index];
    std::uint64_t hash = image.pixels.empty() ? 0 : image.depth.hash();
    const PixelScale scale = image.scale.at(1);
    hash = mixed_hash(mixed_hash(hash, static_cast<std::uint32_t>(scale.x)),
                      static_cast<std::uint32_t>(scale.y));
    for (const LabelledPixel& pixel : image.pixels) {
      hash = mixed_hash(hash, static_cast<std::uint16_t>(pixel.column));
      hash = mixed_hash(hash, static_cast<std::uint16_t>(pixel.row));
      hash = mixed_hash(hash, pixel.label);
    }
    order[index] = {hash, static_cast<std::uint32_t>(i)};
  });
  std::ranges::sort(order);
  ArrangedSamples result;
  result.samples.reserve(static_cast<std::size_t>(count));
  result.labels.reserve(static_cast<std::size_t>(count));
  for (const auto& [hash, index] : order) {
    if (images[index].pixels.empty()) continue;
    // At 1 mm, as in the order, scales are as large as they get; at 1 m each camera has its own.
    const PixelScale scale = images[index].scale.at(1000);
    result.hash = mixed_hash(result.hash, hash);
    result.hash = mixed_hash(result.hash, static_cast<std::uint32_t>(scale.x));
    result.hash = mixed_hash(result.hash, static_cast<std::uint32_t>(scale.y));
    for (const LabelledPixel& pixel : images[index].pixels) {
      result.samples.push_back({index, pixel.column, pixel.row});
      result.labels.push_back(pixel.label);
    }
  }
  return result;
}

}  // namespace knuckle
