// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/png_decoder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/storage/deflate.h"

namespace knuckle {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
constexpr std::uint64_t kDeflatesLimit = 1032;
constexpr std::size_t kHeaderBytes = 13;
constexpr int kPaletteType = 3;

std::uint32_t big_endian(Bytes bytes) {
  std::uint32_t value = 0;
  for (const std::uint8_t byte : bytes.first(4)) value = value << 8 | byte;
  return value;
}

/// The header (11.2.2).
struct PngHeader {
  int width = 0;
  int height = 0;
  int depth = 0;  ///< bits of a sample
  int type = 0;   ///< of colour
  bool is_interlaced = false;

  int samples() const {
    constexpr std::array<int, 7> kSamples{1, 0, 3, 1, 2, 0, 4};
    return kSamples.at(static_cast<std::size_t>(type));
  }
  int bits_per_pixel() const { return depth * samples(); }
  std::size_t row_bytes(int columns) const {
    return (static_cast<std::size_t>(columns) * static_cast<std::size_t>(bits_per_pixel()) + 7) / 8;
  }
};

/// What of a PNG's chunks its pixels are made of.
struct PngParts {
  PngHeader header;
  std::vector<std::uint8_t> palette;  ///< RGB each
  std::vector<std::uint8_t> stream;   ///< all of IDAT
};

/// Every k-th column and row of an image from a first one on (8.2).
struct PngPass {
  int first_column;
  int first_row;
  int column_step;
  int row_step;

  int columns(int width) const { return (width - first_column + column_step - 1) / column_step; }
  int rows(int height) const { return (height - first_row + row_step - 1) / row_step; }
  bool is_empty(const PngHeader& header) const {
    return first_column >= header.width || first_row >= header.height;
  }
};

constexpr std::array<PngPass, 1> kWholeImage{{{0, 0, 1, 1}}};
constexpr std::array<PngPass, 7> kInterlaced{
    {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4}, {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}}};

std::span<const PngPass> passes_of(const PngHeader& header) {
  if (header.is_interlaced) return kInterlaced;
  return kWholeImage;
}

/// Decodes one file.
class PngDecoder {
 public:
  explicit PngDecoder(const std::string& origin) : origin_(origin) {}

  PngPixels decode(Bytes bytes) const {
    const PngParts parts = read_parts(bytes);
    std::vector<std::uint8_t> rows = inflated_rows(parts);
    PngPixels pixels;
    pixels.width = parts.header.width;
    pixels.height = parts.header.height;
    pixels.channels = parts.header.type == kPaletteType ? 3 : parts.header.samples();
    pixels.bits = parts.header.depth == 16 ? 16 : 8;
    const std::size_t pixel_bytes = static_cast<std::size_t>(pixels.channels * pixels.bits / 8);
    pixels.bytes.resize(static_cast<std::size_t>(pixels.width) * static_cast<std::size_t>(pixels.height) *
                        pixel_bytes);
    std::span<std::uint8_t> left = rows;
    for (const PngPass& pass : passes_of(parts.header)) {
      if (!pass.is_empty(parts.header)) place_pass(parts, pass, left, pixels);
    }
    return pixels;
  }

 private:
  [[noreturn]] void damaged(std::string_view why) const {
    fail("{}: the PNG image is damaged: {}", origin_, why);
  }

  PngHeader read_header(Bytes content) const {
    if (content.size() != kHeaderBytes) damaged("its header has another length");
    const std::uint32_t width = big_endian(content);
    const std::uint32_t height = big_endian(content.subspan(4));
    constexpr auto kSide = static_cast<std::uint32_t>(limits::kImageSide);
    if (width < 1 || height < 1 || width > kSide || height > kSide) {
      fail("{}: has {} x {} pixels, expected 1 to {} a side", origin_, width, height, kSide);
    }
    PngHeader header{static_cast<int>(width), static_cast<int>(height), content[8], content[9],
                     content[12] != 0};
    const bool is_byte = header.depth == 8 || header.depth == 16;
    const bool is_part = header.depth == 1 || header.depth == 2 || header.depth == 4;
    bool is_sound = false;
    if (header.type == 0) is_sound = is_byte || is_part;
    if (header.type == kPaletteType) is_sound = header.depth == 8 || is_part;
    if (header.type == 2 || header.type == 4 || header.type == 6) is_sound = is_byte;
    if (!is_sound) {
      fail("{}: the PNG image is of colour type {} with {} bits, which there is not", origin_, header.type,
           header.depth);
    }
    if (content[10] != 0 || content[11] != 0 || content[12] > 1) damaged("it is coded in an unknown way");
    return header;
  }

  PngParts read_parts(Bytes bytes) const {
    const std::string_view start(reinterpret_cast<const char*>(bytes.data()),
                                 std::min(bytes.size(), kSignature.size()));
    if (start != kSignature) fail("{}: not a PNG image", origin_);
    bytes = bytes.subspan(kSignature.size());
    PngParts parts;
    bool has_header = false;
    while (true) {
      constexpr std::size_t kFrame = 12;  // length, name and sum
      if (bytes.size() < kFrame) fail("{}: the PNG image is cut short", origin_);
      const std::uint32_t length = big_endian(bytes);
      if (length > bytes.size() - kFrame) fail("{}: the PNG image is cut short", origin_);
      const Bytes named = bytes.subspan(4, 4 + std::size_t{length});
      const std::string_view name(reinterpret_cast<const char*>(named.data()), 4);
      const Bytes content = named.subspan(4);
      if (!is_sum(crc32(named), big_endian(bytes.subspan(8 + std::size_t{length}))))
        damaged("a sum does not fit");
      bytes = bytes.subspan(kFrame + length);
      if ((name == "IHDR") == has_header) damaged("its header is not its first part");
      if (name == "IEND") break;
      if (name == "IHDR") {
        parts.header = read_header(content);
        has_header = true;
      } else if (name == "PLTE") {
        parts.palette.assign(content.begin(), content.end());
      } else if (name == "IDAT") {
        parts.stream.insert(parts.stream.end(), content.begin(), content.end());
      } else if ((static_cast<unsigned char>(name[0]) & 0x20U) == 0) {
        damaged("it has a part of an unknown kind that it needs");
      }
    }
    if (parts.header.type == kPaletteType && (parts.palette.empty() || parts.palette.size() % 3 != 0)) {
      damaged("its palette is missing or not one of RGB colours");
    }
    return parts;
  }

  /// All rows of all passes, each with its filter before it.
  std::vector<std::uint8_t> inflated_rows(const PngParts& parts) const {
    std::uint64_t size = 0;
    for (const PngPass& pass : passes_of(parts.header)) {
      if (pass.is_empty(parts.header)) continue;
      size += static_cast<std::uint64_t>(pass.rows(parts.header.height)) *
              (1 + parts.header.row_bytes(pass.columns(parts.header.width)));
    }
    if (size > kDeflatesLimit * parts.stream.size()) damaged("it says that it holds more pixels than it can");
    std::vector<std::uint8_t> rows(size);
    if (!inflate(parts.stream, rows)) damaged("its pixels cannot be inflated");
    return rows;
  }

  /// Undoes a row's filter (9.2); `above` is the row before, or zeros.
  void unfilter(int filter, std::span<std::uint8_t> row, Bytes above, std::size_t step) const {
    switch (filter) {
      case 0:
        return;
      case 1:
        for (std::size_t i = step; i < row.size(); ++i)
          row[i] = static_cast<std::uint8_t>(row[i] + row[i - step]);
        return;
      case 2:
        for (std::size_t i = 0; i < row.size(); ++i) row[i] = static_cast<std::uint8_t>(row[i] + above[i]);
        return;
      case 3:
        for (std::size_t i = 0; i < row.size(); ++i) {
          const int left = i < step ? 0 : row[i - step];
          row[i] = static_cast<std::uint8_t>(row[i] + (left + above[i]) / 2);
        }
        return;
      case 4:
        for (std::size_t i = 0; i < row.size(); ++i) {
          const int left = i < step ? 0 : row[i - step];
          const int corner = i < step ? 0 : above[i - step];
          row[i] = static_cast<std::uint8_t>(row[i] + nearest(left, above[i], corner));
        }
        return;
      default:
        damaged("a row has an unknown filter");
    }
  }

  /// Paeth's predictor (9.4).
  static int nearest(int left, int above, int corner) {
    const int from_left = std::abs(above - corner);
    const int from_above = std::abs(left - corner);
    const int from_corner = std::abs(left + above - 2 * corner);
    if (from_left <= from_above && from_left <= from_corner) return left;
    return from_above <= from_corner ? above : corner;
  }

  /// Takes a pass's rows from the front of `rows` and puts its pixels where they belong.
  void place_pass(const PngParts& parts, const PngPass& pass, std::span<std::uint8_t>& rows,
                  PngPixels& pixels) const {
    const PngHeader& header = parts.header;
    const int columns = pass.columns(header.width);
    const std::size_t row_bytes = header.row_bytes(columns);
    const auto step = static_cast<std::size_t>(std::max(1, header.bits_per_pixel() / 8));
    const std::vector<std::uint8_t> zeros(row_bytes, 0);
    Bytes above = zeros;
    for (int row = 0; row < pass.rows(header.height); ++row) {
      const std::span<std::uint8_t> line = rows.subspan(1, row_bytes);
      unfilter(rows[0], line, above, step);
      place_row(parts, pass, line, pass.first_row + row * pass.row_step, columns, pixels);
      above = line;
      rows = rows.subspan(1 + row_bytes);
    }
  }

  void place_row(const PngParts& parts, const PngPass& pass, Bytes line, int row, int columns,
                 PngPixels& pixels) const {
    const auto pixel_bytes = static_cast<std::size_t>(pixels.channels * pixels.bits / 8);
    std::uint8_t* const out = pixels.bytes.data() + static_cast<std::size_t>(row) *
                                                        static_cast<std::size_t>(pixels.width) * pixel_bytes;
    if (parts.header.depth < 8 || parts.header.type == kPaletteType) {
      for (int i = 0; i < columns; ++i) {
        place_small(parts, sample_of(line, i, parts.header.depth),
                    out + static_cast<std::size_t>(pass.first_column + i * pass.column_step) * pixel_bytes);
      }
    } else if (pass.column_step == 1 && pixels.bits == 16) {
      copy_swapped(line, out);
    } else if (pass.column_step == 1) {
      std::ranges::copy(line, out);
    } else {
      for (int i = 0; i < columns; ++i) {
        const Bytes pixel = line.subspan(static_cast<std::size_t>(i) * pixel_bytes, pixel_bytes);
        std::uint8_t* const to =
            out + static_cast<std::size_t>(pass.first_column + i * pass.column_step) * pixel_bytes;
        if (pixels.bits == 16) {
          copy_swapped(pixel, to);
        } else {
          std::ranges::copy(pixel, to);
        }
      }
    }
  }

  static int sample_of(Bytes line, int column, int depth) {
    const int per_byte = 8 / depth;
    const int shift = 8 - depth * (column % per_byte + 1);
    return line[static_cast<std::size_t>(column / per_byte)] >> shift & ((1 << depth) - 1);
  }

  void place_small(const PngParts& parts, int sample, std::uint8_t* to) const {
    if (parts.header.type != kPaletteType) {
      *to = static_cast<std::uint8_t>(sample * 255 / ((1 << parts.header.depth) - 1));
      return;
    }
    const std::size_t colour = 3 * static_cast<std::size_t>(sample);
    if (colour + 3 > parts.palette.size()) damaged("a pixel has a colour beyond its palette");
    std::copy_n(parts.palette.begin() + static_cast<std::ptrdiff_t>(colour), 3, to);
  }

  /// Numbers of 16 bits from big-endian bytes.
  static void copy_swapped(Bytes from, std::uint8_t* to) {
    static_assert(std::endian::native == std::endian::little);
    for (std::size_t i = 0; i + 1 < from.size(); i += 2) {
      to[i] = from[i + 1];
      to[i + 1] = from[i];
    }
  }

  const std::string& origin_;
};

}  // namespace

PngPixels decode_png(std::span<const std::uint8_t> bytes, const std::string& origin) {
  return PngDecoder(origin).decode(bytes);
}

}  // namespace knuckle
