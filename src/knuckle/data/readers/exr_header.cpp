// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/exr_header.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/named_table.h"

namespace knuckle {
namespace {

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint32_t kManyParts = 0x1000;
constexpr std::size_t kLongestName = 255;
constexpr std::int64_t kMostCachedPixels = std::int64_t{1}
                                           << 24;  // of a row of tiles, where the image is small

/// Types whose values have one size. OpenEXR reads as many bytes whatever an attribute says, so that another
/// size would let it see other attributes than we do. Types that it does not know it skips by their size.
struct TypeSize {
  std::string_view name;
  std::int64_t bytes;
};
constexpr std::array kTypeSizes = {
    TypeSize{"box2i", 16},
    TypeSize{"box2f", 16},
    TypeSize{"chromaticities", 32},
    TypeSize{"compression", 1},
    TypeSize{"double", 8},
    TypeSize{"envmap", 1},
    TypeSize{"deepImageState", 1},
    TypeSize{"float", 4},
    TypeSize{"int", 4},
    TypeSize{"keycode", 28},
    TypeSize{"lineOrder", 1},
    TypeSize{"m33f", 36},
    TypeSize{"m33d", 72},
    TypeSize{"m44f", 64},
    TypeSize{"m44d", 128},
    TypeSize{"rational", 8},
    TypeSize{"tiledesc", 9},
    TypeSize{"timecode", 8},
    TypeSize{"v2i", 8},
    TypeSize{"v2f", 8},
    TypeSize{"v2d", 16},
    TypeSize{"v3i", 12},
    TypeSize{"v3f", 12},
    TypeSize{"v3d", 24},
};

/// What a header says of the image, as far as it decides on memory.
struct ImageLayout {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::int64_t tile_width = 0;  ///< 0: not in tiles
  std::int64_t tile_height = 0;
  std::int64_t channels = 0;
  std::int64_t block_rows = 256;  ///< rows that are unpacked together, by the compression
};

/// By the number of a compression: none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB.
constexpr std::array<std::int64_t, 10> kBlockRows{1, 1, 1, 16, 32, 16, 32, 32, 32, 256};

class ExrHeaderCheck {
 public:
  explicit ExrHeaderCheck(const std::filesystem::path& path)
      : path_(path),
        file_(path, std::ios::binary),
        bytes_(static_cast<std::int64_t>(std::filesystem::file_size(path))) {}

  void run() {
    if (number() != kMagic) fail("{}: cannot be read as an EXR image: it is none", path_.string());
    const bool has_many_parts = (number() & kManyParts) != 0;
    do {
      check_part();
    } while (has_many_parts && file_.peek() != 0);  // an empty header ends the last one
  }

 private:
  void check_part() {
    ImageLayout layout;
    for (std::string name = text(); !name.empty(); name = text()) check_attribute(name, layout);
    check_layout(layout);
  }

  void check_attribute(const std::string& name, ImageLayout& layout) {
    const std::string type = text();
    const std::int64_t size = number();
    const std::int64_t begin = file_.tellg();
    if (size > bytes_ - begin) damaged("'" + name + "' is longer than the file");
    const TypeSize* const known = row_named(kTypeSizes, type);
    if (known != nullptr && size != known->bytes) damaged("'" + name + "' is of another size than its type");
    if (type == "floatvector" && size % 4 != 0) damaged("'" + name + "' is of another size than its type");
    if (type == "chlist") layout.channels = count_channels(begin + size);
    if (type == "preview") check_preview(size);
    if (type == "stringvector") check_texts(begin + size);
    if (type == "idmanifest") fail("{}: holds an ID manifest; expected an image of depth", path_.string());
    if (name == "compression" && type == "compression") {
      const auto number = static_cast<std::size_t>(file_.get());
      if (number < kBlockRows.size()) layout.block_rows = kBlockRows[number];
    }
    if (name == "dataWindow" && type == "box2i") read_window(layout);
    if (name == "tiles" && type == "tiledesc") {
      layout.tile_width = number();
      layout.tile_height = number();
    }
    file_.seekg(begin + size);
  }

  void check_preview(std::int64_t size) {
    const std::uint64_t pixels = std::uint64_t{number()} * number();
    if (size < 8 || size % 4 != 0 || pixels != static_cast<std::uint64_t>(size - 8) / 4)
      damaged("its thumbnail is of another size");
  }

  /// Channels have a name and 16 bytes each; an empty name ends them.
  std::int64_t count_channels(std::int64_t end) {
    constexpr std::int64_t kChannelBytes = 16;
    std::int64_t count = 0;
    while (!text().empty()) {
      if (kChannelBytes > end - file_.tellg()) damaged("its list of channels is longer than it says");
      file_.seekg(kChannelBytes, std::ios::cur);
      ++count;
    }
    if (file_.tellg() != end) damaged("its list of channels is of another length than it says");
    return count;
  }

  void check_texts(std::int64_t end) {
    while (file_.tellg() < end) {
      const std::int64_t length = number();
      if (length > end - file_.tellg()) damaged("a text is longer than what it stands in");
      file_.seekg(length, std::ios::cur);
    }
  }

  void read_window(ImageLayout& layout) {
    std::array<std::int64_t, 4> sides{};
    for (std::int64_t& side : sides) side = static_cast<std::int32_t>(number());
    layout.width = sides[2] - sides[0] + 1;
    layout.height = sides[3] - sides[1] + 1;
  }

  /// Rows of all channels are unpacked together, some at a time. Where tiles lie stands in the file, eight
  /// bytes each; a row of tiles is held in memory.
  void check_layout(const ImageLayout& layout) const {
    const auto is_side = [](std::int64_t side) { return side > 0 && side <= limits::kImageSide; };
    if (!is_side(layout.width) || !is_side(layout.height)) return;  // which is refused with its numbers
    constexpr std::int64_t kValueBytes = 4;
    if (layout.channels > limits::kChunkBytes / (kValueBytes * layout.width * layout.block_rows))
      damaged("it has too many channels to be unpacked");
    if (layout.tile_width <= 0 || layout.tile_height <= 0) return;
    const std::int64_t columns = (layout.width + layout.tile_width - 1) / layout.tile_width;
    const std::int64_t rows = (layout.height + layout.tile_height - 1) / layout.tile_height;
    if (columns > bytes_ / 8 || rows > bytes_ / 8 / columns)
      damaged("it has more tiles than the file can hold");
    const std::int64_t most = std::max(kMostCachedPixels, layout.width * layout.height);
    if (layout.tile_height > most / layout.width) damaged("its tiles are far larger than the image");
  }

  std::uint32_t number() {
    std::array<unsigned char, 4> bytes{};
    file_.read(reinterpret_cast<char*>(bytes.data()), bytes.size());
    if (!file_) damaged("it ends within its header");
    std::uint32_t value = 0;
    for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8U | bytes[i];
    return value;
  }

  /// A text that ends with a zero.
  std::string text() {
    std::string result;
    for (int c = file_.get(); c != 0; c = file_.get()) {
      if (!file_) damaged("it ends within its header");
      if (result.size() == kLongestName) damaged("a name in its header is too long");
      result.push_back(static_cast<char>(c));
    }
    return result;
  }

  [[noreturn]] void damaged(const std::string& why) const {
    fail("{}: cannot be read as an EXR image: {}", path_.string(), why);
  }

  std::filesystem::path path_;
  std::ifstream file_;
  std::int64_t bytes_;
};

}  // namespace

void check_exr_header(const std::filesystem::path& path) {
  ExrHeaderCheck(path).run();
}

}  // namespace knuckle
