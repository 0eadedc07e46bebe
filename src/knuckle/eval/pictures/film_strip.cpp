// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/film_strip.h"

#include <algorithm>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/eval/pictures/drawing.h"

namespace knuckle {
namespace {

constexpr int kStripGapPx = 4;
constexpr int kMarginPx = 4;

/// "12", or "12: 7.5 mm": the number stands at the beginning of a row's caption.
std::string label_of(const GalleryRow& row, const GalleryPicture& picture) {
  const std::string number = row.caption.substr(0, row.caption.find_first_of(" :", sizeof("Frame ") - 1));
  const std::string_view frame = std::string_view(number).substr(sizeof("Frame ") - 1);
  return picture.note.empty() ? std::string(frame) : fmt::format("{}: {}", frame, picture.note);
}

}  // namespace

void FilmStripOptions::visit(OptionVisitor& visitor) {
  visitor.integer("columns", columns, closed(1, 100));
  visitor.integer("picture_size_px", picture_size_px, closed(64, 2000));
  visitor.integer("most_frames", most_frames, closed(1, 1000));
}

Image<Rgb> film_strip(const GalleryInput& input, const FilmStripOptions& options) {
  check_options(options, "film strip");
  const std::vector<GalleryRow> rows = make_gallery(
      input,
      {.even_frames = options.most_frames, .worst_frames = 0, .picture_size_px = options.picture_size_px});
  if (rows.empty()) fail("film strip: there is no frame to show");
  const int size = options.picture_size_px;
  const int frames = static_cast<int>(rows.size());
  const int columns = std::min(options.columns, frames);
  const int bands = (frames + columns - 1) / columns;
  const int pictures = static_cast<int>(
      std::ranges::max(rows, {}, [](const GalleryRow& row) { return row.pictures.size(); }).pictures.size());
  const int band_height = pictures * size + kStripGapPx;
  const int width = kStripGapPx + columns * (size + kStripGapPx);
  const int height = kStripGapPx + bands * band_height;
  if (std::max(width, height) > limits::kImageSide) {
    fail("film strip: {} x {} pixels, an image has at most {} a side; take smaller pictures or fewer frames",
         width, height, limits::kImageSide);
  }
  Image<Rgb> strip(width, height, kSheetColour);
  for (int i = 0; i < frames; ++i) {
    const int x = kStripGapPx + i % columns * (size + kStripGapPx);
    int y = kStripGapPx + i / columns * band_height;
    for (const GalleryPicture& shown : rows[i].pictures) {
      Image<Rgb> picture = shown.picture;
      draw_text(picture, label_of(rows[i], shown), kMarginPx, size - kMarginPx);
      paste(picture, strip, x, y);
      y += size;
    }
  }
  return strip;
}

}  // namespace knuckle
