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

/// Tiles in rows, each a frame's pictures one below the other and a gap.
struct StripLayout {
  int frames = 0;
  int columns = 1;
  int tile_width = 0;   ///< [px]
  int tile_height = 0;  ///< [px]

  int width() const { return kStripGapPx + columns * tile_width; }
  int height() const { return kStripGapPx + (frames + columns - 1) / columns * tile_height; }
};

/// Throws an Error where no image holds the strip.
StripLayout layout_of(int frames, int pictures, const FilmStripOptions& options) {
  StripLayout layout{frames, std::min(options.columns, frames), options.picture_size_px + kStripGapPx,
                     pictures * options.picture_size_px + kStripGapPx};
  while (layout.height() > limits::kImageSide && layout.columns < frames) ++layout.columns;
  if (std::max(layout.width(), layout.height()) > limits::kImageSide) {
    fail("film strip: {} x {} pixels, an image has at most {} a side; take smaller pictures or fewer frames",
         layout.width(), layout.height(), limits::kImageSide);
  }
  return layout;
}

int most_pictures(const std::vector<GalleryRow>& rows) {
  std::size_t most = 0;
  for (const GalleryRow& row : rows) most = std::max(most, row.pictures.size());
  return static_cast<int>(most);
}

}  // namespace

void FilmStripOptions::visit(OptionVisitor& visitor) {
  visitor.integer("columns", columns, closed(1, 100));
  visitor.integer("picture_size_px", picture_size_px, closed(64, 2000));
  visitor.integer("most_frames", most_frames, closed(1, 1000));
}

Image<Rgb> film_strip(const GalleryInput& input, const FilmStripOptions& options) {
  check_options(options, "film strip");
  const int frames = static_cast<int>(std::min<std::int64_t>(frames_to_show(input), options.most_frames));
  if (frames < 1) fail("film strip: there is no frame to show");
  layout_of(frames, 1, options);  // refuses what is too much before its pictures are made
  const std::vector<GalleryRow> rows = make_gallery(
      input,
      {.even_frames = options.most_frames, .worst_frames = 0, .picture_size_px = options.picture_size_px});
  const StripLayout layout = layout_of(frames, most_pictures(rows), options);
  const int size = options.picture_size_px;
  Image<Rgb> strip(layout.width(), layout.height(), kSheetColour);
  for (int i = 0; i < layout.frames; ++i) {
    const int x = kStripGapPx + i % layout.columns * layout.tile_width;
    int y = kStripGapPx + i / layout.columns * layout.tile_height;
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
