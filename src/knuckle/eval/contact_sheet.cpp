// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/contact_sheet.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/eval/drawing.h"

namespace knuckle {
namespace {

constexpr Rgb kPaper{0x2a, 0x27, 0x30};
constexpr Rgb kHandTint{0xff, 0x9a, 0x52};
constexpr double kTintShare = 0.35;
constexpr int kGapPx = 6;

/// From a little before the hand to an arm's length behind it; all depths where no hand is marked.
DepthRange shown_range(const Frame& frame) {
  constexpr double kBefore = 15.0;   // [mm]
  constexpr double kBehind = 450.0;  // [mm]
  double nearest = INFINITY;
  for (std::size_t i = 0; i < frame.mask.size(); ++i) {
    const float depth = frame.depth_mm.data()[i];
    if (frame.mask.data()[i] != 0 && is_measured(depth)) nearest = std::min<double>(nearest, depth);
  }
  if (std::isfinite(nearest)) return {nearest - kBefore, nearest + kBehind};
  return depth_range_in(frame.depth_mm, {0, 0, frame.depth_mm.width(), frame.depth_mm.height()});
}

Image<Rgb> tinted(Image<Rgb> picture, const Image<std::uint8_t>& mask) {
  for (std::size_t i = 0; i < mask.size(); ++i) {
    Rgb& pixel = picture.data()[i];
    if (mask.data()[i] != 0) pixel = mixed(pixel, kHandTint, kTintShare);
  }
  return picture;
}

/// A frame's picture.
Image<Rgb> tile(const Frame& frame, std::int64_t index, int width) {
  const int own_width = std::max(1, frame.depth_mm.width());
  const double scale = static_cast<double>(width) / own_width;
  const int height = std::max(1, static_cast<int>(std::lround(scale * frame.depth_mm.height())));
  const Image<Rgb> full = tinted(colour_mapped(frame.depth_mm, shown_range(frame)), frame.mask);
  Image<Rgb> picture = resized(full, width, height);
  const View view{{0, 0, frame.depth_mm.width(), frame.depth_mm.height()}, scale};
  if (frame.truth) draw_skeleton(picture, *frame.truth, view, kTruthColour);
  constexpr int kMargin = 5;
  draw_text(picture, std::to_string(index), kMargin, height - kMargin);
  return picture;
}

void paste(const Image<Rgb>& picture, Image<Rgb>& sheet, int x, int y) {
  for (int row = 0; row < picture.height(); ++row)
    std::ranges::copy(picture.row(row), sheet.row(y + row).subspan(static_cast<std::size_t>(x)).begin());
}

}  // namespace

void ContactSheetOptions::visit(OptionVisitor& visitor) {
  visitor.integer("columns", columns, closed(1, 100));
  visitor.integer("tile_width_px", tile_width_px, closed(32, 2000));
}

std::vector<std::int64_t> spread_frames(std::int64_t first, std::int64_t count, int tiles) {
  if (first < 0 || count < 1 || tiles < 1)
    fail("contact sheet: {} of {} frames from {} on cannot be shown", tiles, count, first);
  const std::int64_t shown = std::min<std::int64_t>(count, tiles);
  std::vector<std::int64_t> frames;
  for (std::int64_t i = 0; i < shown; ++i)
    frames.push_back(first + (shown == 1 ? 0 : i * (count - 1) / (shown - 1)));
  return frames;
}

Image<Rgb> contact_sheet(const FrameSource& source, const std::vector<std::int64_t>& frames,
                         const ContactSheetOptions& options) {
  check_options(options, "contact sheet");
  if (frames.empty()) fail("contact sheet: there is no frame to show");
  std::vector<Image<Rgb>> tiles(frames.size());
  parallel_for(static_cast<std::int64_t>(frames.size()), [&](std::int64_t i) {
    tiles[i] = tile(source.read(frames[i]), frames[i], options.tile_width_px);
  });
  const int columns = std::min(options.columns, static_cast<int>(tiles.size()));
  const int rows = (static_cast<int>(tiles.size()) + columns - 1) / columns;
  const int tile_height = std::ranges::max(tiles, {}, &Image<Rgb>::height).height();
  Image<Rgb> sheet(kGapPx + columns * (options.tile_width_px + kGapPx),
                   kGapPx + rows * (tile_height + kGapPx), kPaper);
  for (int i = 0; i < static_cast<int>(tiles.size()); ++i) {
    paste(tiles[i], sheet, kGapPx + i % columns * (options.tile_width_px + kGapPx),
          kGapPx + i / columns * (tile_height + kGapPx));
  }
  return sheet;
}

}  // namespace knuckle
