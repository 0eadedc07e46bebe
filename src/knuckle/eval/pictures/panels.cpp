// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/panels.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/eval/pictures/drawing.h"

namespace knuckle {
namespace {

constexpr int kPanelGapPx = 6;
constexpr Rgb kGap{0xff, 0xff, 0xff};

/// The smallest box around what is not 0; empty where all is.
Box box_of(const Image<std::uint8_t>& mask) {
  Box box;
  for (int row = 0; row < mask.height(); ++row) {
    for (int column = 0; column < mask.width(); ++column) {
      if (mask(column, row) == 0) continue;
      if (box.empty()) box = {column, row, 1, 1};
      const int right = std::max(box.right(), column + 1);
      box.x = std::min(box.x, column);
      box.width = right - box.x;
      box.height = row + 1 - box.y;
    }
  }
  return box;
}

Box surroundings(const Box& box, int width, int height) {
  const int x = box.width / 2;
  const int y = box.height / 2;
  return intersection({box.x - x, box.y - y, box.width + 2 * x, box.height + 2 * y}, {0, 0, width, height});
}

Image<float> as_depths(const Image<std::uint8_t>& mask) {
  Image<float> result(mask.width(), mask.height());
  for (std::size_t i = 0; i < mask.size(); ++i) result.data()[i] = mask.data()[i] != 0 ? 1.0f : 2.0f;
  return result;
}

/// Bright where the amplitude is large: as depths, whose near end is bright.
Image<float> as_depths(const Image<std::uint16_t>& infrared) {
  std::vector<std::uint16_t> sorted(infrared.pixels().begin(), infrared.pixels().end());
  std::ranges::sort(sorted);
  const double white = std::max<double>(sorted[sorted.size() - 1 - sorted.size() / 100], 1.0);
  Image<float> result(infrared.width(), infrared.height());
  for (std::size_t i = 0; i < infrared.size(); ++i) {
    result.data()[i] = 2.0f - static_cast<float>(std::sqrt(std::min(infrared.data()[i] / white, 1.0)));
  }
  return result;
}

Image<Rgb> beside_each_other(const std::vector<Image<Rgb>>& pictures) {
  int width = -kPanelGapPx;
  for (const Image<Rgb>& picture : pictures) width += picture.width() + kPanelGapPx;
  Image<Rgb> result(width, pictures.front().height(), kGap);
  int left = 0;
  for (const Image<Rgb>& picture : pictures) {
    for (int row = 0; row < picture.height(); ++row) {
      std::ranges::copy(picture.row(row), result.row(row).begin() + left);
    }
    left += picture.width() + kPanelGapPx;
  }
  return result;
}

}  // namespace

Image<Rgb> panels_of(const Frame& frame, int height) {
  if (height < 1) fail("panels: height is {}, expected at least 1", height);
  const int frame_width = frame.depth_mm.width();
  const int frame_height = frame.depth_mm.height();
  const Box hand = box_of(frame.mask);
  const Box crop =
      hand.empty() ? Box{0, 0, frame_width, frame_height} : surroundings(hand, frame_width, frame_height);
  const View view{crop, static_cast<double>(height) / crop.height};
  constexpr DepthRange kUnit{1.0, 2.0};
  std::vector<Image<Rgb>> pictures = {picture_of(frame.depth_mm, view, depth_range_in(frame.depth_mm, crop))};
  if (!frame.mask.empty()) pictures.push_back(picture_of(as_depths(frame.mask), view, kUnit));
  if (!frame.infrared.empty()) pictures.push_back(picture_of(as_depths(frame.infrared), view, kUnit));
  return beside_each_other(pictures);
}

}  // namespace knuckle
