// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/contact_sheet.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/eval/metrics/segmentation_metrics.h"
#include "knuckle/eval/pictures/drawing.h"

namespace knuckle {
namespace {

constexpr Rgb kHandTint{0xff, 0x9a, 0x52};
constexpr double kTintShare = 0.35;
constexpr int kGapPx = 6;

/// The depths from a little before the hand to `behind_mm` behind its nearest point; all depths in view where
/// no hand is marked.
DepthRange range_from_hand(const Frame& frame, double behind_mm) {
  constexpr double kBefore = 15.0;  // [mm]
  double nearest = INFINITY;
  for (std::size_t i = 0; i < frame.mask.size(); ++i) {
    const float depth = frame.depth_mm.data()[i];
    if (frame.mask.data()[i] != 0 && is_measured(depth)) nearest = std::min<double>(nearest, depth);
  }
  if (std::isfinite(nearest)) return {nearest - kBefore, nearest + behind_mm};
  return depth_range_in(frame.depth_mm, {0, 0, frame.depth_mm.width(), frame.depth_mm.height()});
}

/// The frame's pixels as colours, its hand tinted.
Image<Rgb> coloured(const Frame& frame, double behind_mm) {
  Image<Rgb> picture = colour_mapped(frame.depth_mm, range_from_hand(frame, behind_mm));
  for (std::size_t i = 0; i < frame.mask.size(); ++i) {
    Rgb& pixel = picture.data()[i];
    if (frame.mask.data()[i] != 0) pixel = mixed(pixel, kHandTint, kTintShare);
  }
  return picture;
}

Image<Rgb> whole_frame(const Frame& frame, std::int64_t index, int width) {
  constexpr double kBody = 450.0;  // [mm] behind the hand that stay visible
  constexpr int kMargin = 5;
  const double scale = static_cast<double>(width) / std::max(1, frame.depth_mm.width());
  const int height = std::max(1, static_cast<int>(std::lround(scale * frame.depth_mm.height())));
  Image<Rgb> picture = resized(coloured(frame, kBody), width, height);
  draw_text(picture, std::to_string(index), kMargin, height - kMargin);
  return picture;
}

/// A square around the true hand with its skeleton; dark where there is no truth.
Image<Rgb> hand_close_up(const Frame& frame, int side) {
  constexpr double kHand = 200.0;  // [mm]
  constexpr double kMargin = 1.4;  // of the hand's size
  const std::optional<Rectangle> hand = frame.truth ? rectangle_around(*frame.truth) : std::nullopt;
  if (!hand) return Image<Rgb>(side, side, kSheetColour);
  const double extent = std::max({hand->right - hand->left, hand->bottom - hand->top, 1.0});
  const int size = static_cast<int>(std::ceil(kMargin * extent));
  const View view{{static_cast<int>(std::lround((hand->left + hand->right - size) / 2.0)),
                   static_cast<int>(std::lround((hand->top + hand->bottom - size) / 2.0)), size, size},
                  static_cast<double>(side) / size};
  Image<Rgb> picture = resized(cropped(coloured(frame, kHand), view.crop), side, side);
  draw_skeleton(picture, *frame.truth, view, kTruthColour);
  return picture;
}

/// What the sheet shows of one frame, side by side.
struct Tile {
  Image<Rgb> frame;
  Image<Rgb> hand;

  int height() const { return frame.height(); }
};

Tile tile(const Frame& frame, std::int64_t index, int width) {
  Tile made{whole_frame(frame, index, width), {}};
  made.hand = hand_close_up(frame, made.height());
  return made;
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
  std::vector<Tile> tiles(frames.size());
  parallel_for(static_cast<std::int64_t>(frames.size()), [&](std::int64_t i) {
    tiles[i] = tile(source.read(frames[i]), frames[i], options.tile_width_px);
  });
  const int columns = std::min(options.columns, static_cast<int>(tiles.size()));
  const int rows = (static_cast<int>(tiles.size()) + columns - 1) / columns;
  const int height = std::ranges::max(tiles, {}, &Tile::height).height();
  const int width = options.tile_width_px + height;
  Image<Rgb> sheet(kGapPx + columns * (width + kGapPx), kGapPx + rows * (height + kGapPx), kSheetColour);
  for (int i = 0; i < static_cast<int>(tiles.size()); ++i) {
    const int x = kGapPx + i % columns * (width + kGapPx);
    const int y = kGapPx + i / columns * (height + kGapPx);
    paste(tiles[i].frame, sheet, x, y);
    paste(tiles[i].hand, sheet, x + options.tile_width_px, y);
  }
  return sheet;
}

}  // namespace knuckle
