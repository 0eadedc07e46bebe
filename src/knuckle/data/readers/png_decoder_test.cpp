// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/png_decoder.h"

#include "knuckle/core/testing.h"
#include "knuckle/core/testing_memory.h"
#include "knuckle/storage/deflate.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::peak_memory_kb;

using Bytes = std::vector<std::uint8_t>;

void append_number(Bytes& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

void append_chunk(Bytes& png, const std::string& name, const Bytes& content) {
  Bytes named(name.begin(), name.end());
  named.insert(named.end(), content.begin(), content.end());
  append_number(png, static_cast<std::uint32_t>(content.size()));
  png.insert(png.end(), named.begin(), named.end());
  append_number(png, crc32(named));
}

struct Png {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  int bits = 8;
  int type = 0;
  bool is_interlaced = false;
  Bytes palette = {};
  Bytes rows = {};  ///< with their filters

  Bytes bytes() const {
    Bytes png{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    Bytes header;
    append_number(header, width);
    append_number(header, height);
    header.insert(header.end(), {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(type), 0, 0,
                                 static_cast<std::uint8_t>(is_interlaced ? 1 : 0)});
    append_chunk(png, "IHDR", header);
    if (!palette.empty()) append_chunk(png, "PLTE", palette);
    append_chunk(png, "IDAT", deflated(rows));
    append_chunk(png, "IEND", {});
    return png;
  }
};

std::string fault_of(const Bytes& png) {
  const std::string message = error_of([&] { decode_png(png, "a.png"); });
  EXPECT_THAT(message, AllOf(HasSubstr("a.png"), Not(HasSubstr("\n"))));
  return message;
}

TEST(PngDecoder, UndoesEachFilter) {
  // Rows of 3 pixels; worked by hand from section 9 of the standard.
  const Png png{.width = 3, .height = 5, .rows = {0, 10, 20, 30,   // as they are
                                                  1, 1,  1,  1,    // left: 1 2 3
                                                  2, 5,  5,  5,    // above: 6 7 8
                                                  3, 10, 10, 10,   // mean: 13 20 24
                                                  4, 1,  1,  1}};  // Paeth: 14 21 25
  EXPECT_EQ(decode_png(png.bytes(), "a").bytes,
            (Bytes{10, 20, 30, 1, 2, 3, 6, 7, 8, 13, 20, 24, 14, 21, 25}));
}

TEST(PngDecoder, StretchesNarrowGreyAndLooksColoursUp) {
  const Png grey{.width = 3, .height = 1, .bits = 2, .rows = {0, 0b00'01'11'00}};
  EXPECT_EQ(decode_png(grey.bytes(), "a").bytes, (Bytes{0, 85, 255}));
  const Png colours{
      .width = 2, .height = 1, .bits = 4, .type = 3, .palette = {1, 2, 3, 4, 5, 6}, .rows = {0, 0x10}};
  EXPECT_EQ(decode_png(colours.bytes(), "a").bytes, (Bytes{4, 5, 6, 1, 2, 3}));
  Png beyond = colours;
  beyond.rows = {0, 0x20};
  EXPECT_THAT(fault_of(beyond.bytes()), HasSubstr("beyond its palette"));
}

TEST(PngDecoder, PutsInterlacedPixelsWhereTheyBelong) {
  // 2 x 2: pass 1 holds (0, 0), pass 6 (1, 0), pass 7 the second row.
  const Png png{.width = 2, .height = 2, .is_interlaced = true, .rows = {0, 1, 0, 2, 0, 3, 4}};
  EXPECT_EQ(decode_png(png.bytes(), "a").bytes, (Bytes{1, 2, 3, 4}));
}

TEST(PngDecoder, RefusesImpossibleSizesBeforeMemoryIsTaken) {
  EXPECT_THAT(fault_of(Png{.width = 65535, .height = 65535, .bits = 16, .rows = {0}}.bytes()),
              HasSubstr("65535 x 65535 pixels, expected 1 to 16384"));
  EXPECT_THAT(fault_of(Png{.width = 16384, .height = 2048, .bits = 16, .rows = {0}}.bytes()),
              HasSubstr("more pixels than it can"));
  EXPECT_THAT(fault_of(Png{.width = 16384, .height = 2930, .bits = 16, .rows = {0}}.bytes()),
              HasSubstr("16384 x 2930 pixels, expected at most 48000000 in all"));
  EXPECT_THAT(fault_of(Png{.width = 0, .height = 5, .rows = {0}}.bytes()), HasSubstr("width is zero"));
  EXPECT_THAT(fault_of(Png{.width = 3, .height = 1, .rows = {0, 1, 2}}.bytes()), HasSubstr("Not enough"));
  EXPECT_THAT(fault_of(Png{.width = 3, .height = 1, .rows = {0, 1, 2, 3, 4}}.bytes()), HasSubstr("Too much"));
  EXPECT_THAT(fault_of(Png{.width = 3, .height = 1, .rows = {9, 1, 2, 3}}.bytes()), HasSubstr("filter"));
  EXPECT_THAT(fault_of(Png{.width = 3, .height = 1, .bits = 7, .rows = {9, 1, 2, 3}}.bytes()),
              HasSubstr("bit depth"));
  EXPECT_THAT(fault_of(Png{.width = 3, .height = 1, .type = 5, .rows = {9, 1, 2, 3}}.bytes()),
              HasSubstr("color type"));
}

TEST(PngDecoder, RefusesAnotherSizeThanTheCamerasBeforeItLooksAtThePixels) {
  Bytes png = Png{.width = 3, .height = 2, .rows = {0, 1, 2, 3, 2, 1, 1, 1}}.bytes();
  EXPECT_EQ(decode_png(png, "a", ImageSize{3, 2}).width, 3);
  png.resize(png.size() - 20);  // pixels that cannot be decoded
  EXPECT_EQ(testing::error_of([&] {
              decode_png(png, "a", ImageSize{3, 3});
            }),
            "a: is 3x2 pixels, expected 3x3");
  EXPECT_EQ(testing::error_of([&] {
              decode_png(png, "a", ImageSize{2, 2});
            }),
            "a: is 3x2 pixels, expected 2x2");
}

TEST(PngDecoder, TakesNoMemoryForARowThatIsTooLong) {
  const long before = peak_memory_kb();
  for (const int type : {0, 2, 6}) {
    const Png png{.width = 503316800, .height = 2, .type = type, .rows = Bytes(64)};
    EXPECT_THAT(fault_of(png.bytes()), HasSubstr("503316800 x 2"));
  }
  EXPECT_LT(peak_memory_kb() - before, 100000);
}

TEST(PngDecoder, RefusesAnyChangedByteAndAnyCut) {
  const Bytes png = Png{.width = 3, .height = 2, .rows = {0, 1, 2, 3, 2, 1, 1, 1}}.bytes();
  ASSERT_EQ(decode_png(png, "a").bytes, (Bytes{1, 2, 3, 2, 3, 4}));
  for (std::size_t i = 0; i < png.size(); ++i) {
    Bytes changed = png;
    changed[i] = static_cast<std::uint8_t>(changed[i] ^ 4);
    fault_of(changed);
    fault_of({png.begin(), png.begin() + static_cast<std::ptrdiff_t>(i)});
  }
}

}  // namespace
}  // namespace knuckle
