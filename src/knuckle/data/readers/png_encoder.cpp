// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/png_encoder.h"

#include <array>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <new>
#include <string_view>
#include <utility>

#include <png.h>
#include <zlib.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

struct PixelKind {
  int bits;         ///< of a channel
  int colour_type;  ///< of libpng
};

/// Writes one PNG with libpng into memory. libpng leaves its functions by longjmp; so `write` calls it after
/// its own setjmp, and has no objects with destructors beside that.
class PngWriter {
 public:
  PngWriter() : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, this, take_error, pass_over)) {
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  /// False at a fault.
  template <class T>
  bool write(const Image<T>& image, const PixelKind& kind) {
    if (png_ == nullptr || info_ == nullptr) return false;
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_write_fn(png_, this, take_bytes, nullptr);
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_set_compression_level(png_, Z_BEST_SPEED);
    png_set_compression_strategy(png_, Z_RLE);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(image.width()),
                 static_cast<png_uint_32>(image.height()), kind.bits, kind.colour_type, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png_, info_);
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
    for (int row = 0; row < image.height(); ++row) {
      png_write_row(png_, reinterpret_cast<png_const_bytep>(image.row(row).data()));
    }
    png_write_end(png_, info_);
    return true;
  }

  std::string_view fault() const { return fault_.data(); }
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  [[noreturn]] static void take_error(png_structp png, png_const_charp message) {
    auto& fault = static_cast<PngWriter*>(png_get_error_ptr(png))->fault_;
    std::strncpy(fault.data(), message, fault.size() - 1);
    png_longjmp(png, 1);
  }
  static void pass_over(png_structp /*png*/, png_const_charp /*warning*/) {}

  /// No exception may pass through libpng.
  bool append(png_bytep from, std::size_t count) noexcept {
    try {
      bytes_.insert(bytes_.end(), from, from + count);
      return true;
    } catch (const std::bad_alloc&) {
      return false;
    }
  }
  static void take_bytes(png_structp png, png_bytep from, std::size_t count) {
    if (!static_cast<PngWriter*>(png_get_io_ptr(png))->append(from, count)) png_error(png, "out of memory");
  }

  std::vector<std::uint8_t> bytes_;
  std::array<char, 160> fault_{};
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

template <class T>
std::vector<std::uint8_t> encoded(const Image<T>& image, const PixelKind& kind) {
  PngWriter writer;
  if (!writer.write(image, kind)) {
    fail("an image of {} x {} pixels cannot be encoded as PNG: {}", image.width(), image.height(),
         writer.fault());
  }
  return writer.take();
}

}  // namespace

std::vector<std::uint8_t> encode_png(const Image<std::uint16_t>& image) {
  return encoded(image, {16, PNG_COLOR_TYPE_GRAY});
}

std::vector<std::uint8_t> encode_png(const Image<std::uint8_t>& image) {
  return encoded(image, {8, PNG_COLOR_TYPE_GRAY});
}

std::vector<std::uint8_t> encode_png(const Image<Rgb>& image) {
  static_assert(sizeof(Rgb) == 3, "a row is what PNG writes");
  return encoded(image, {8, PNG_COLOR_TYPE_RGB});
}

}  // namespace knuckle
