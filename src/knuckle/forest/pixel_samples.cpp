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

std::size_t PixelSamples::message_bytes(std::uint32_t index) const {
  const DepthImage& image = images_[index];
  return image.depth.message_bytes() + OffsetScale::kMessageBytes + sizeof(std::uint64_t) +
         image.pixels.size() * sizeof(LabelledPixel);
}

void PixelSamples::take(std::uint32_t index, std::vector<std::byte>& message) {
  DepthImage& image = images_[index];
  image.depth.append_to(message);
  image.scale.append_to(message);
  append_value(message, std::uint64_t{image.pixels.size()});
  append_values(message, std::span<const LabelledPixel>(image.pixels));
  image = {};
  free_.push_back(index);
}

std::uint32_t PixelSamples::put(MessageReader& reader) {
  if (free_.empty()) {
    free_.push_back(static_cast<std::uint32_t>(images_.size()));
    images_.emplace_back();
  }
  const std::uint32_t index = free_.back();
  DepthImage& image = images_[index];
  image.depth = DepthTiles::read(reader);
  image.scale = OffsetScale::read(reader);
  const auto pixels = reader.value<std::uint64_t>();
  if (pixels > reader.bytes_left()) fail("a worker's message: an image of {} pixels ends early", pixels);
  image.pixels.resize(pixels);
  reader.read(std::span(image.pixels));
  for (const LabelledPixel& pixel : image.pixels) {
    if (pixel.column < 0 || pixel.column >= image.depth.width() || pixel.row < 0 ||
        pixel.row >= image.depth.height() || pixel.label > 1) {
      fail("a worker's message: pixel ({}, {}) of an image of {} x {}", pixel.column, pixel.row,
           image.depth.width(), image.depth.height());
    }
  }
  free_.pop_back();
  return index;
}

std::uint64_t PixelSamples::DepthImage::hash() const {
  std::uint64_t hash = pixels.empty() ? 0 : depth.hash();
  const PixelScale nearest = scale.at(1);
  hash = mixed_hash(mixed_hash(hash, static_cast<std::uint32_t>(nearest.x)),
                    static_cast<std::uint32_t>(nearest.y));
  for (const LabelledPixel& pixel : pixels) {
    hash = mixed_hash(hash, static_cast<std::uint16_t>(pixel.column));
    hash = mixed_hash(hash, static_cast<std::uint16_t>(pixel.row));
    hash = mixed_hash(hash, pixel.label);
  }
  return hash;
}

std::vector<std::uint64_t> hashes_of_images(const PixelSamples& samples) {
  const std::span<const PixelSamples::DepthImage> images = samples.images();
  std::vector<std::uint64_t> hashes(images.size());
  parallel_for(std::ssize(images), [&](std::int64_t i) {
    const auto index = static_cast<std::size_t>(i);
    hashes[index] = images[index].hash();
  });
  return hashes;
}

ArrangedPart arranged(const PixelSamples& samples, std::span<const std::uint32_t> order,
                      std::span<const std::uint64_t> hashes) {
  const std::int64_t count = samples.sample_count();
  if (count > std::numeric_limits<std::uint32_t>::max()) {
    fail("forest training: {} pixels, expected at most {}", count, std::numeric_limits<std::uint32_t>::max());
  }
  const std::span<const PixelSamples::DepthImage> images = samples.images();
  ArrangedPart part;
  part.samples.samples.reserve(static_cast<std::size_t>(count));
  part.samples.labels.reserve(static_cast<std::size_t>(count));
  for (const std::uint32_t index : order) {
    const PixelSamples::DepthImage& image = images[index];
    // At 1 mm, as in the order, scales are as large as they get; at 1 m each camera has its own.
    const PixelScale scale = image.scale.at(1000);
    part.words.insert(part.words.end(), {hashes[index], static_cast<std::uint32_t>(scale.x),
                                         static_cast<std::uint32_t>(scale.y)});
    for (const LabelledPixel& pixel : image.pixels) {
      part.samples.samples.push_back({index, pixel.column, pixel.row});
      part.samples.labels.push_back(pixel.label);
    }
  }
  return part;
}

ArrangedSamples arranged(const PixelSamples& samples) {
  const std::vector<std::uint64_t> hashes = hashes_of_images(samples);
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < hashes.size(); ++i) {
    if (!samples.images()[i].pixels.empty()) order.push_back(i);
  }
  std::ranges::sort(order, {}, [&](std::uint32_t i) { return std::pair(hashes[i], i); });
  ArrangedPart all = arranged(samples, order, hashes);
  for (const std::uint64_t word : all.words) all.samples.hash = mixed_hash(all.samples.hash, word);
  return std::move(all.samples);
}

}  // namespace knuckle
