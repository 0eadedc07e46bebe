// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/drawing.h"

#include <array>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr Rgb kNoMeasurement{0x0c, 0x0b, 0x12};
constexpr Rgb kRim{0x10, 0x0e, 0x18};
constexpr int kSubpixelBits = 4;  // OpenCV draws at 1/16 of a pixel

/// From far to near, of rising lightness: plum to cream, which leaves cyan and orange to the skeletons.
constexpr std::array<Rgb, 5> kDepthColours = {{
    {0x24, 0x1d, 0x33},
    {0x4a, 0x3d, 0x5c},
    {0x80, 0x6c, 0x85},
    {0xba, 0xa6, 0xab},
    {0xf4, 0xea, 0xdc},
}};

/// The colour of `nearness` in [0, 1].
Rgb depth_colour(double nearness) {
  const double place = std::clamp(nearness, 0.0, 1.0) * (kDepthColours.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), kDepthColours.size() - 2);
  return mixed(kDepthColours[below], kDepthColours[below + 1], place - static_cast<double>(below));
}

cv::Mat as_matrix(Image<Rgb>& picture) {
  return cv::Mat(picture.height(), picture.width(), CV_8UC3, picture.data());
}

/// OpenCV's colours are in the order of our channels here: the matrix above keeps red first.
cv::Scalar scalar(const Rgb& colour) {
  return cv::Scalar(colour.red, colour.green, colour.blue);
}

/// Maps image coordinates to the picture's, as OpenCV's fixed-point numbers.
class PictureMap {
 public:
  explicit PictureMap(const View& view) : view_(view) {}

  cv::Point operator()(const ImagePoint& point) const {
    return {fixed_point((point.u + 0.5 - view_.crop.x) * view_.scale - 0.5),
            fixed_point((point.v + 0.5 - view_.crop.y) * view_.scale - 0.5)};
  }

 private:
  /// Far outside the picture a line's end need not be exact, but must not overflow.
  static int fixed_point(double value) {
    constexpr double kFar = 1e5;
    return static_cast<int>(std::lround(std::clamp(value, -kFar, kFar) * (1 << kSubpixelBits)));
  }

  const View& view_;
};

/// One pass over bones and joints: the rim, or the colour within.
struct Pen {
  cv::Scalar colour;
  int line_width;    // [px]
  int joint_radius;  // [1/16 px]
};

void draw_with(cv::Mat& canvas, const HandPose& pose, const PictureMap& to_picture, const Pen& pen) {
  for (const Bone& bone : skeleton_of(pose.convention)) {
    const ImagePoint& from = pose.joints[bone.from];
    const ImagePoint& to = pose.joints[bone.to];
    if (from.is_missing() || to.is_missing()) continue;
    cv::line(canvas, to_picture(from), to_picture(to), pen.colour, pen.line_width, cv::LINE_AA,
             kSubpixelBits);
  }
  for (const ImagePoint& joint : pose.joints) {
    if (joint.is_missing()) continue;
    cv::circle(canvas, to_picture(joint), pen.joint_radius, pen.colour, cv::FILLED, cv::LINE_AA,
               kSubpixelBits);
  }
}

/// A part of an image; pixels beyond its border are `outside`.
template <class T>
Image<T> crop_of(const Image<T>& image, const Box& crop, const T& outside) {
  Image<T> result(crop.width, crop.height, outside);
  const Box inside = intersection(crop, {0, 0, image.width(), image.height()});
  for (int row = inside.y; row < inside.bottom(); ++row) {
    const auto source = image.row(row).subspan(inside.x, inside.width);
    std::ranges::copy(source, result.row(row - crop.y).begin() + (inside.x - crop.x));
  }
  return result;
}

}  // namespace

Rgb mixed(const Rgb& from, const Rgb& to, double share) {
  const auto channel = [&](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround(a + share * (b - a)));
  };
  return {channel(from.red, to.red), channel(from.green, to.green), channel(from.blue, to.blue)};
}

Image<Rgb> colour_mapped(const Image<float>& depth_mm, const DepthRange& range) {
  const double span_mm = std::max(range.far_mm - range.near_mm, 1e-6);
  Image<Rgb> picture(depth_mm.width(), depth_mm.height(), kNoMeasurement);
  for (std::size_t i = 0; i < depth_mm.size(); ++i) {
    const double depth = depth_mm.pixels()[i];
    if (depth > 0.0) picture.pixels()[i] = depth_colour((range.far_mm - depth) / span_mm);
  }
  return picture;
}

DepthRange depth_range_in(const Image<float>& depth_mm, const Box& crop) {
  const Box inside = intersection(crop, {0, 0, depth_mm.width(), depth_mm.height()});
  std::vector<float> measured;
  for (int row = inside.y; row < inside.bottom(); ++row) {
    for (int column = inside.x; column < inside.right(); ++column) {
      if (depth_mm(column, row) > 0.0f) measured.push_back(depth_mm(column, row));
    }
  }
  if (measured.empty()) return {};
  std::ranges::sort(measured);
  const std::size_t outliers = measured.size() / 100;
  return {measured[outliers], measured[measured.size() - 1 - outliers]};
}

Image<Rgb> picture_of(const Image<float>& depth_mm, const View& view, const DepthRange& range) {
  if (view.crop.empty() || !(view.scale > 0.0)) fail("a picture needs a crop and a scale above 0");
  return resized(colour_mapped(crop_of(depth_mm, view.crop, 0.0f), range), view.width(), view.height());
}

Image<Rgb> cropped(const Image<Rgb>& picture, const Box& crop) {
  return crop_of(picture, crop, kNoMeasurement);
}

Image<Rgb> resized(const Image<Rgb>& picture, int width, int height) {
  Image<Rgb> original = picture;
  Image<Rgb> result(width, height);
  cv::Mat canvas = as_matrix(result);
  const bool shrinks = width < picture.width();
  cv::resize(as_matrix(original), canvas, canvas.size(), 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_NEAREST);
  return result;
}

void draw_box(Image<Rgb>& picture, const Box& box, const View& view, const Rgb& colour) {
  const PictureMap to_picture(view);
  const cv::Point first = to_picture({box.x - 0.5, box.y - 0.5, 0.0});
  const cv::Point last = to_picture({box.right() - 0.5, box.bottom() - 0.5, 0.0});
  cv::Mat canvas = as_matrix(picture);
  cv::rectangle(canvas, first, last, scalar(kRim), 4, cv::LINE_AA, kSubpixelBits);
  cv::rectangle(canvas, first, last, scalar(colour), 2, cv::LINE_AA, kSubpixelBits);
}

void draw_text(Image<Rgb>& picture, std::string_view text, int x, int y) {
  constexpr double kSize = 0.38;  // of OpenCV's letters: capitals of 8 px
  const std::string letters(text);
  cv::Mat canvas = as_matrix(picture);
  const auto write = [&](const Rgb& colour, int width) {
    cv::putText(canvas, letters, {x, y}, cv::FONT_HERSHEY_SIMPLEX, kSize, scalar(colour), width, cv::LINE_AA);
  };
  write(kRim, 3);
  write(kDepthColours.back(), 1);
}

void draw_skeleton(Image<Rgb>& picture, const HandPose& pose, const View& view, const Rgb& colour) {
  constexpr double kSizeForWidth = 200.0;  // a picture of so many pixels has lines of one pixel
  const int width =
      std::max(1, static_cast<int>(std::lround(std::max(picture.width(), picture.height()) / kSizeForWidth)));
  const int radius = (3 * width) << (kSubpixelBits - 1);  // 1.5 line widths
  cv::Mat canvas = as_matrix(picture);
  const PictureMap to_picture(view);
  draw_with(canvas, pose, to_picture, {scalar(kRim), width + 2, radius + (1 << kSubpixelBits)});
  draw_with(canvas, pose, to_picture, {scalar(colour), width, radius});
}

void paste(const Image<Rgb>& picture, Image<Rgb>& sheet, int x, int y) {
  for (int row = 0; row < picture.height(); ++row)
    std::ranges::copy(picture.row(row), sheet.row(y + row).subspan(static_cast<std::size_t>(x)).begin());
}

Image<Rgb> picture_of(const Frame& frame) {
  constexpr double kComfortableWidth = 640.0;  // [px]
  const Box all{0, 0, frame.depth_mm.width(), frame.depth_mm.height()};
  const View view{all, std::max(1.0, std::floor(kComfortableWidth / std::max(1, all.width)))};
  Image<Rgb> picture = picture_of(frame.depth_mm, view, depth_range_in(frame.depth_mm, all));
  if (frame.truth) draw_skeleton(picture, *frame.truth, view, kTruthColour);
  return picture;
}

std::string hex_code(const Rgb& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour.red, colour.green, colour.blue);
}

}  // namespace knuckle
