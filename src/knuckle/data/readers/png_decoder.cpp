// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/png_decoder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <string_view>

#include <png.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr std::size_t kSignatureBytes = 8;
constexpr std::uint64_t kDeflatesLimit = 1032;

/// Reads one PNG with libpng, whose warnings and errors are kept, not printed: a warning before the pixels
/// are whole is an error too. libpng leaves its functions by longjmp; so each of the steps below calls libpng
/// after its own setjmp, and has no objects with destructors beside that.
class PngReader {
 public:
  explicit PngReader(std::span<const std::uint8_t> bytes) : left_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, take_error, take_warning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  /// Up to the first pixels. False at a fault.
  bool read_header() {
    if (png_ == nullptr || info_ == nullptr) return false;
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, this, give_bytes);
    png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // ours are checked by the caller
    png_set_crc_action(png_, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_set_benign_errors(png_, 0);
    // Only pixels matter: what is said about gamma, profiles, texts and transparency is passed over.
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, reinterpret_cast<png_const_bytep>("tRNS"), 1);
    png_read_info(png_, info_);
    file_bits_per_pixel_ = std::uint64_t{png_get_bit_depth(png_, info_)} * png_get_channels(png_, info_);
    return true;
  }

  /// Says what pixels shall look like. Takes memory for a row, so its length has to be checked before. False
  /// at a fault.
  bool prepare_pixels() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    if (png_get_color_type(png_, info_) == PNG_COLOR_TYPE_PALETTE) {
      png_set_packing(png_);  // numbers of colours: libpng itself takes one beyond the palette for black
    } else {
      png_set_expand_gray_1_2_4_to_8(png_);
    }
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }

  /// All pixels, and what stands behind them. False at a fault. `rows` has the address of each row.
  bool read_pixels(png_bytepp rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_image(png_, rows);
    png_read_end(png_, nullptr);
    return true;
  }

  std::uint64_t width() const { return png_get_image_width(png_, info_); }
  std::uint64_t height() const { return png_get_image_height(png_, info_); }
  int channels() const { return png_get_channels(png_, info_); }
  int bits() const { return png_get_bit_depth(png_, info_); }
  std::size_t row_bytes() const { return png_get_rowbytes(png_, info_); }
  /// Of the pixels as they stand in the file.
  std::uint64_t file_bytes() const { return width() * height() * file_bits_per_pixel_ / 8; }
  /// The colours that a pixel of the palette may have; none where pixels are no numbers of colours.
  std::span<const png_color> palette() const {
    png_colorp colours = nullptr;
    int count = 0;
    if (png_get_color_type(png_, info_) != PNG_COLOR_TYPE_PALETTE) return {};
    png_get_PLTE(png_, info_, &colours, &count);
    return {colours, static_cast<std::size_t>(count)};
  }
  bool is_cut_short() const { return is_cut_short_; }
  std::string_view fault() const { return fault_.data(); }

 private:
  void keep(const char* message) {
    if (fault_[0] != '\0') return;  // the first one is the cause
    std::strncpy(fault_.data(), message, fault_.size() - 1);
  }
  [[noreturn]] static void take_error(png_structp png, png_const_charp message) {
    static_cast<PngReader*>(png_get_error_ptr(png))->keep(message);
    png_longjmp(png, 1);
  }
  static void take_warning(png_structp png, png_const_charp message) {
    static_cast<PngReader*>(png_get_error_ptr(png))->keep(message);
  }
  static void give_bytes(png_structp png, png_bytep to, std::size_t count) {
    auto* const reader = static_cast<PngReader*>(png_get_io_ptr(png));
    if (count > reader->left_.size()) {
      reader->is_cut_short_ = true;
      png_error(png, "cut short");
    }
    std::copy_n(reader->left_.begin(), count, to);
    reader->left_ = reader->left_.subspan(count);
  }

  std::span<const std::uint8_t> left_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  std::uint64_t file_bits_per_pixel_ = 0;
  bool is_cut_short_ = false;
  std::array<char, 160> fault_{};
};

[[noreturn]] void fail_of(const PngReader& reader, const std::string& origin) {
  if (reader.is_cut_short()) fail("{}: the PNG image is cut short", origin);
  fail("{}: the PNG image is damaged: {}", origin, printable(reader.fault()));
}

/// RGB in place of numbers of colours.
std::vector<std::uint8_t> looked_up(std::span<const std::uint8_t> numbers, std::span<const png_color> palette,
                                    const std::string& origin) {
  std::vector<std::uint8_t> colours;
  colours.reserve(3 * numbers.size());
  for (const std::uint8_t number : numbers) {
    if (number >= palette.size()) {
      fail("{}: the PNG image is damaged: a pixel has a colour beyond its palette", origin);
    }
    const png_color& colour = palette[number];
    colours.insert(colours.end(), {colour.red, colour.green, colour.blue});
  }
  return colours;
}

}  // namespace

PngPixels decode_png(std::span<const std::uint8_t> bytes, const std::string& origin,
                     const std::optional<ImageSize>& expected) {
  if (bytes.size() < kSignatureBytes || png_sig_cmp(bytes.data(), 0, kSignatureBytes) != 0) {
    fail("{}: not a PNG image", origin);
  }
  PngReader reader(bytes);
  if (!reader.read_header()) fail_of(reader, origin);
  const ImageSize size{static_cast<std::int64_t>(reader.width()), static_cast<std::int64_t>(reader.height())};
  require_image_size(size, origin);
  if (expected) require_same_size(size, *expected, origin);
  if (reader.file_bytes() > kDeflatesLimit * bytes.size()) {
    fail("{}: the PNG image is damaged: it says that it holds more pixels than it can", origin);
  }
  if (!reader.prepare_pixels()) fail_of(reader, origin);
  PngPixels pixels;
  pixels.width = static_cast<int>(reader.width());
  pixels.height = static_cast<int>(reader.height());
  pixels.channels = reader.channels();
  pixels.bits = reader.bits();
  pixels.bytes.resize(reader.row_bytes() * reader.height());
  std::vector<png_bytep> rows;
  for (std::uint64_t row = 0; row < reader.height(); ++row) {
    rows.push_back(pixels.bytes.data() + row * reader.row_bytes());
  }
  if (!reader.read_pixels(rows.data()) || !reader.fault().empty()) fail_of(reader, origin);
  if (const auto palette = reader.palette(); !palette.empty()) {
    pixels.channels = 3;
    pixels.bytes = looked_up(pixels.bytes, palette, origin);
  }
  return pixels;
}

}  // namespace knuckle
