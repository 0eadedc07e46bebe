// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/image_io.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/png_decoder.h"
#include "knuckle/data/readers/png_encoder.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

PngPixels read_png(const std::filesystem::path& path, const ExpectedSize& expected) {
  const std::string bytes = read_regular_file(path, limits::kImageFileBytes);
  return decode_png({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, path.string(),
                    expected);
}

std::string kind_of(const PngPixels& image) {
  return fmt::format("{} channel(s) of {} bits", image.channels, image.bits);
}

template <class T>
Image<T> single_channel(const PngPixels& decoded, const std::filesystem::path& path) {
  if (decoded.channels != 1 || decoded.bits != static_cast<int>(8 * sizeof(T))) {
    fail("{}: expected 1 channel of {} bits, found {}", path.string(), sizeof(T) * 8, kind_of(decoded));
  }
  Image<T> image(decoded.width, decoded.height);
  std::memcpy(image.data(), decoded.bytes.data(), decoded.bytes.size());
  return image;
}

template <class T>
void write_encoded(const std::filesystem::path& path, const Image<T>& image) {
  const std::vector<std::uint8_t> bytes = encode_png(image);
  write_text_file(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace

Image<std::uint16_t> read_png16(const std::filesystem::path& path, const ExpectedSize& expected) {
  return single_channel<std::uint16_t>(read_png(path, expected), path);
}

Image<std::uint8_t> read_png8(const std::filesystem::path& path, const ExpectedSize& expected) {
  return single_channel<std::uint8_t>(read_png(path, expected), path);
}

Image<std::uint16_t> read_png8_or_16(const std::filesystem::path& path, const ExpectedSize& expected) {
  const PngPixels decoded = read_png(path, expected);
  if (decoded.bits != 8) return single_channel<std::uint16_t>(decoded, path);
  const Image<std::uint8_t> narrow = single_channel<std::uint8_t>(decoded, path);
  Image<std::uint16_t> image(narrow.width(), narrow.height());
  std::ranges::copy(narrow.pixels(), image.pixels().begin());
  return image;
}

Image<Rgb> read_png_rgb(const std::filesystem::path& path, const ExpectedSize& expected) {
  const PngPixels decoded = read_png(path, expected);
  if (decoded.bits != 8 || decoded.channels < 3) {
    fail("{}: expected 3 channels of 8 bits, found {}", path.string(), kind_of(decoded));
  }
  Image<Rgb> image(decoded.width, decoded.height);
  const std::uint8_t* pixel = decoded.bytes.data();
  for (Rgb& rgb : image.pixels()) {
    rgb = {pixel[0], pixel[1], pixel[2]};
    pixel += decoded.channels;
  }
  return image;
}

void write_png(const std::filesystem::path& path, const Image<std::uint16_t>& image) {
  write_encoded(path, image);
}

void write_png(const std::filesystem::path& path, const Image<std::uint8_t>& image) {
  write_encoded(path, image);
}

void write_png(const std::filesystem::path& path, const Image<Rgb>& image) {
  write_encoded(path, image);
}

}  // namespace knuckle
