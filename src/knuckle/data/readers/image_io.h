// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "knuckle/core/image.h"
#include "knuckle/core/image_size.h"
#include "knuckle/core/rgb.h"

namespace knuckle {

/// The size that an image must have; nothing: any that limits.h allows.
using ExpectedSize = std::optional<ImageSize>;

/// Reads a PNG of one 16-bit channel. Throws an Error where the file is missing, cut short, no PNG, of
/// another kind, or of another size than `expected`; the latter before it is decoded.
Image<std::uint16_t> read_png16(const std::filesystem::path& path, const ExpectedSize& expected = {});

/// Reads a PNG of one 8-bit channel.
Image<std::uint8_t> read_png8(const std::filesystem::path& path, const ExpectedSize& expected = {});

/// Reads a PNG of one channel with 8 or 16 bits; see read_png16.
Image<std::uint16_t> read_png8_or_16(const std::filesystem::path& path, const ExpectedSize& expected = {});

/// Reads a PNG of three (or four, then without the last) 8-bit channels.
Image<Rgb> read_png_rgb(const std::filesystem::path& path, const ExpectedSize& expected = {});

/// Write a PNG; the file appears only when whole.
void write_png(const std::filesystem::path& path, const Image<std::uint16_t>& image);
void write_png(const std::filesystem::path& path, const Image<std::uint8_t>& image);
void write_png(const std::filesystem::path& path, const Image<Rgb>& image);

}  // namespace knuckle
