// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <knuckle/camera/projection.h>
#include <knuckle/core/options.h>
#include <knuckle/segment/hand_region.h>
#include <knuckle/segment/nearest_pixel.h>
#include <knuckle/segment/segmenter.h>

namespace own {

struct BallSegmenterOptions {
  double radius_mm = 120.0;  ///< (0, 1000] [mm]

  void visit(knuckle::OptionVisitor& visitor) {
    visitor.real("radius_mm", radius_mm, knuckle::open_closed(0, 1000));
  }
};

/// The hand is all that is measured in a ball around the start, or around the nearest point.
class BallSegmenter final : public knuckle::Segmenter {
 public:
  explicit BallSegmenter(const BallSegmenterOptions& options) : options_(options) {
    knuckle::check_options(options_, "ball segmentation");
  }

  /// Finds one hand, however many are asked for.
  knuckle::Segmentation segment(const knuckle::Frame& frame, const std::optional<knuckle::Point3>& start,
                                int /*max_hands*/) const override {
    knuckle::check_size(frame);
    knuckle::check_start(frame, start);
    const auto nearest = knuckle::nearest_pixel(frame.depth_mm);
    if (!nearest) return {{}, "no measurement in the frame"};
    const knuckle::Projection projection(frame.camera);
    const auto point_at = [&](int column, int row, float depth_mm) {
      return projection.to_camera(
          knuckle::ImagePoint{static_cast<double>(column), static_cast<double>(row), depth_mm});
    };
    const knuckle::Point3 centre =
        start ? *start : point_at(nearest->column, nearest->row, nearest->depth_mm);

    std::vector<std::int32_t> pixels;  // row * width + column
    for (int row = 0; row < frame.depth_mm.height(); ++row) {
      for (int column = 0; column < frame.depth_mm.width(); ++column) {
        const float depth = frame.depth_mm(column, row);
        if (!knuckle::is_measured(depth)) continue;
        if ((point_at(column, row, depth) - centre).norm() > options_.radius_mm) continue;
        pixels.push_back(row * frame.depth_mm.width() + column);
      }
    }
    if (pixels.empty()) return {{}, "nothing is measured near the start"};
    knuckle::HandRegion hand = knuckle::region_of_pixels(pixels, frame.depth_mm.width());
    hand.centre = centre;
    hand.score = static_cast<double>(pixels.size());
    return {{hand}, ""};
  }

 private:
  BallSegmenterOptions options_;
};

}  // namespace own
