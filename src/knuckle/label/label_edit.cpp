// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_edit.h"

#include <algorithm>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/label/label_skin.h"
#include "knuckle/label/mask_brush.h"

namespace knuckle {
namespace {

std::string verify(std::vector<LandmarkLabel>& labels) {
  const bool is_empty = std::ranges::all_of(labels, [](const auto& label) { return label.at.is_missing(); });
  if (is_empty) return "There is nothing to verify: no landmark of this hand is labelled.";
  for (LandmarkLabel& label : labels)
    label.state = label.at.is_missing() ? label.state : LabelState::verified;
  return {};
}

/// Missing where no depth was measured.
ImagePoint placed(const LabelRequest& request, const Frame& frame, Landmark landmark, double palm_mm,
                  const std::vector<LandmarkLabel>& labels) {
  std::vector<ImagePoint> others(labels.size());
  std::ranges::transform(labels, others.begin(), &LandmarkLabel::at);
  return placed_on_pixel(frame, request.u, request.v, landmark, palm_mm, labels[request.landmark].at.depth_mm,
                         skin_depths(others));
}

}  // namespace

std::string edit_labels(const LabelRequest& request, const Frame& frame, const Convention& convention,
                        double palm_mm, std::vector<LandmarkLabel>& labels) {
  using Kind = LabelRequest::Kind;
  if (request.kind == Kind::verify) return verify(labels);
  LandmarkLabel& label = labels[request.landmark];
  if (request.kind == Kind::look) {
    if (label.at.is_missing()) return "This landmark is not labelled yet: place it first.";
    label.is_visible = request.is_visible;
    return {};
  }
  if (request.kind == Kind::free) {
    label.state = LabelState::estimated;
    return {};
  }
  ImagePoint at;
  if (request.kind == Kind::place) {
    at = placed(request, frame, convention.landmarks[request.landmark], palm_mm, labels);
    if (at.is_missing()) return "No depth was measured there: place it in the points, or beside.";
  } else {
    at = Projection(frame.camera).to_image(request.point_mm);
    if (at.is_missing() || !(at.depth_mm > 0.0)) return "This point lies behind the camera.";
  }
  label.at = at;
  label.state = LabelState::corrected;
  return {};
}

std::string edit_mask(const LabelRequest& request, const Frame& frame, const LabelFit* fit,
                      std::shared_ptr<const LabelMask>& mask) {
  Image<std::uint8_t> pixels(frame.depth_mm.width(), frame.depth_mm.height());
  if (request.kind == LabelRequest::Kind::outline) {
    if (fit == nullptr) return "The hand model is not fitted here: label at least three landmarks first.";
    auto points = landmarks(adult_skeleton(), fit->pose);
    if (request.hand.side == HandSide::left) {
      for (Point3& point : points) point.x() = -point.x();
    }
    pixels = pixels_near_flesh(frame, points);
  } else {
    if (mask) {
      if (mask->width != pixels.width() || mask->height != pixels.height())
        return "The mask is of an image of another size.";
      pixels = pixels_of(*mask);
    }
    paint(request.stroke, pixels);
  }
  LabelMask painted = mask_from_pixels_of_hand(pixels);
  if (painted.runs.size() > kMostMaskRuns) return "This mask would have too many edges.";
  mask = std::make_shared<const LabelMask>(std::move(painted));
  return {};
}

}  // namespace knuckle
