// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/image_io.h"

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

Image<std::uint16_t> random_depth() {
  Random random(5);
  Image<std::uint16_t> image(31, 17);
  for (auto& pixel : image.pixels()) pixel = static_cast<std::uint16_t>(random());
  return image;
}

TEST(ImageIoTest, SixteenBitsComeBackAsWritten) {
  const TemporaryFolder folder;
  const auto image = random_depth();
  write_png(folder / "depth.png", image);
  EXPECT_EQ(read_png16(folder / "depth.png"), image);
}

TEST(ImageIoTest, ColoursComeBackInTheirOrder) {
  const TemporaryFolder folder;
  Image<Rgb> image(2, 1);
  image(0, 0) = {255, 128, 0};
  image(1, 0) = {1, 2, 3};
  write_png(folder / "colour.png", image);
  EXPECT_EQ(read_png_rgb(folder / "colour.png"), image);
}

TEST(ImageIoTest, APngOfAnotherKindIsRefused) {
  const TemporaryFolder folder;
  write_png(folder / "mask.png", Image<std::uint8_t>(4, 4));
  const std::string message = error_of([&] { read_png16(folder / "mask.png"); });
  EXPECT_THAT(message, HasSubstr("mask.png"));
  EXPECT_THAT(message, HasSubstr("expected 1 channel of 16 bits, found 1 channel(s) of 8 bits"));
  EXPECT_THAT(error_of([&] { read_png_rgb(folder / "mask.png"); }), HasSubstr("expected 3 channels"));
}

TEST(ImageIoTest, APngCutAnywhereIsRefused) {
  const TemporaryFolder folder;
  Image<std::uint16_t> noise(320, 240);  // enough to fill several of the file's chunks
  Random random(8);
  for (auto& pixel : noise.pixels()) pixel = static_cast<std::uint16_t>(random());
  write_png(folder / "whole.png", noise);
  const std::string bytes = read_text_file(folder / "whole.png");
  // Some versions of the library take the missing rows for zeros: it must not even be asked.
  for (const std::size_t missing :
       {bytes.size() * 9 / 10, bytes.size() / 2, std::size_t{100}, std::size_t{12}, std::size_t{1}}) {
    write_text_file(folder / "cut.png", bytes.substr(0, bytes.size() - missing));
    EXPECT_THAT(error_of([&] { read_png16(folder / "cut.png"); }),
                HasSubstr("cut.png: the PNG image is cut short"))
        << missing;
  }
  write_text_file(folder / "cut.png", "");
  EXPECT_THAT(error_of([&] { read_png16(folder / "cut.png"); }), HasSubstr("cut.png: not a PNG image"));
}

TEST(ImageIoTest, ATextIsNoPng) {
  const TemporaryFolder folder;
  write_text_file(folder / "text.png", "hello");
  EXPECT_THAT(error_of([&] { read_png16(folder / "text.png"); }), HasSubstr("text.png: not a PNG image"));
}

}  // namespace
}  // namespace knuckle
