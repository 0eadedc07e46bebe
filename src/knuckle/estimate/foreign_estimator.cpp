// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/foreign_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/net/heat_map_decoding.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 2> kPatches = {"cube", "hand"};
constexpr std::array<std::string_view, 3> kAnswers = {"uvd", "xyz", "heat_maps"};
constexpr std::array<std::string_view, 3> kAxes = {"right_down_far", "right_up_far", "right_up_near"};
constexpr std::array<std::string_view, 2> kPeaks = {"gaussian", "mean_shift"};

/// The depths that a patch shows: d from -end to end.
double depth_end(const std::string& patch) {
  return patch == "hand" ? kPatchBackground : 1.0;
}

/// The straight line through (from_low, to_low) and (from_high, to_high).
double mapped(double value, double from_low, double from_high, double to_low, double to_high) {
  return to_low + (value - from_low) * (to_high - to_low) / (from_high - from_low);
}

/// The side of the square patch that the network takes.
int patch_size(const OnnxNetwork& file) {
  const OnnxShape& shape = file.input_shape();
  const bool is_channel_first = shape[1] == 1 && shape[2] == shape[3];
  const bool is_channel_last = shape[3] == 1 && shape[1] == shape[2];
  if (shape[0] != 1 || !(is_channel_first || is_channel_last)) {
    fail(
        "{}: its input is {} x {} x {} x {}, expected a square patch of one channel: 1 x 1 x N x N or 1 x N "
        "x N x 1",
        file.origin(), shape[0], shape[1], shape[2], shape[3]);
  }
  return static_cast<int>(is_channel_first ? shape[2] : shape[1]);
}

PatchOptions patch_options(const OnnxNetwork& file, const ForeignNetworkOptions& options) {
  return {.size_px = patch_size(file), .mode = options.patch, .cube_mm = options.cube_mm};
}

Landmark landmark_named(const Convention& convention, const std::string& name) {
  const auto found =
      std::ranges::find(convention.landmarks, name, [](Landmark landmark) { return name_of(landmark); });
  if (found == convention.landmarks.end()) {
    fail("order: '{}' is no landmark of {}; write \"-\" for one that is not used", name, convention.name);
  }
  return *found;
}

}  // namespace

void ForeignNetworkOptions::visit(OptionVisitor& visitor) {
  constexpr double kMost = 1e6;
  visitor.choice("patch", patch, kPatches);
  visitor.real("cube_mm", cube_mm, closed(10, 2000));
  visitor.real("near_value", near_value, closed(-kMost, kMost));
  visitor.real("far_value", far_value, closed(-kMost, kMost));
  visitor.choice("gives", gives, kAnswers);
  visitor.text("landmarks_output", landmarks_output);
  visitor.text("confidence_output", confidence_output);
  visitor.texts("order", order, {});
  visitor.real("first_pixel", first_pixel, closed(-kMost, kMost));
  visitor.real("last_pixel", last_pixel, closed(-kMost, kMost));
  visitor.real("near_depth", near_depth, closed(-kMost, kMost));
  visitor.real("far_depth", far_depth, closed(-kMost, kMost));
  visitor.real("xyz_mm", xyz_mm, open_closed(0, 10000));
  visitor.choice("axes", axes, kAxes);
  visitor.choice("peak", peak, kPeaks);
}

ForeignNetworkOptions foreign_defaults(const std::string& patch) {
  ForeignNetworkOptions options;
  options.patch = patch;
  options.near_value = options.near_depth = -depth_end(patch);
  options.far_value = options.far_depth = depth_end(patch);
  return options;
}

ForeignEstimator::ForeignEstimator(OnnxNetwork file, const Convention& convention,
                                   ForeignNetworkOptions options, int passes)
    : file_(std::move(file)),
      convention_(convention),
      options_(std::move(options)),
      passes_(passes),
      patches_(patch_options(file_, options_)) {
  check_options(options_, file_.origin());
  if (options_.near_value == options_.far_value)
    fail("{}: near_value and far_value are the same", file_.origin());
  if (options_.near_depth == options_.far_depth)
    fail("{}: near_depth and far_depth are the same", file_.origin());
  if (options_.first_pixel == options_.last_pixel)
    fail("{}: first_pixel and last_pixel are the same", file_.origin());
  if (options_.patch == "hand" && passes_ != 1)
    fail("{}: passes is {}, but a patch of the hand is looked at once", file_.origin(), passes_);
  if (options_.patch == "hand" && options_.gives == "heat_maps") {
    fail("{}: heat maps look depth up in a cube; expected patch = \"cube\"", file_.origin());
  }
  find_places();
  landmarks_ = static_cast<std::size_t>(output_for_landmarks());
  check_landmarks_output();
  if (options_.confidence_output.empty()) return;
  confidence_ = file_.output_named(options_.confidence_output);
  if (confidence_ < 0) fail("{}: it has no output '{}'", file_.origin(), options_.confidence_output);
  const std::int64_t found = count_of(file_.outputs()[static_cast<std::size_t>(confidence_)].shape);
  if (found != static_cast<std::int64_t>(given_)) {
    fail("{}: its output '{}' has {} numbers, expected one per landmark ({})", file_.origin(),
         options_.confidence_output, found, given_);
  }
}

/// Where each of the convention's landmarks is in the network's own order.
void ForeignEstimator::find_places() {
  const auto count = static_cast<std::size_t>(convention_.size());
  given_ = options_.order.empty() ? count : options_.order.size();
  if (options_.order.empty()) {
    for (std::size_t i = 0; i < count; ++i) places_.push_back(i);
    return;
  }
  places_.assign(count, given_);
  for (std::size_t i = 0; i < given_; ++i) {
    const std::string& name = options_.order[i];
    if (name == "-") continue;
    const auto place = static_cast<std::size_t>(convention_.index_of(landmark_named(convention_, name)));
    if (places_[place] != given_) fail("order: '{}' is there twice", name);
    places_[place] = i;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (places_[i] == given_) fail("order: '{}' is missing", name_of(convention_.landmarks[i]));
  }
}

int ForeignEstimator::output_for_landmarks() const {
  std::vector<std::string> names;
  for (const OnnxValue& output : file_.outputs()) names.push_back(output.name);
  if (options_.landmarks_output.empty()) {
    if (names.size() == 1) return 0;
    fail("{}: it has {} outputs; say which gives the landmarks, landmarks_output = one of {}", file_.origin(),
         names.size(), joined(names));
  }
  const int place = file_.output_named(options_.landmarks_output);
  if (place < 0) {
    fail("{}: it has no output '{}', but {}", file_.origin(), options_.landmarks_output, joined(names));
  }
  return place;
}

void ForeignEstimator::check_landmarks_output() {
  const OnnxValue& output = file_.outputs()[landmarks_];
  const OnnxShape& shape = output.shape;
  const auto given = static_cast<std::int64_t>(given_);
  if (options_.gives == "heat_maps") {
    if (shape.size() != 4 || shape[1] != given || shape[2] != shape[3] || shape[2] < 4) {
      fail("{}: its output '{}' is no {} square heat maps of 4 cells a side or more (1 x {} x N x N)",
           file_.origin(), output.name, given, given);
    }
    map_cells_ = static_cast<int>(shape[2]);
    return;
  }
  if (count_of(shape) != 3 * given) {
    fail("{}: its output '{}' has {} numbers, expected 3 for each of {} landmarks", file_.origin(),
         output.name, count_of(shape), given);
  }
  is_planar_ =
      shape.size() >= 2 && shape[shape.size() - 1] == given && shape[shape.size() - 2] == 3 && given != 3;
}

PatchPose ForeignEstimator::estimate(const HandPatch& patch) const {
  const int size = patches_.options().size_px;
  if (patch.pixels.width() != size || patch.pixels.height() != size) {
    fail("network: a patch of {} x {}, expected {} x {}", patch.pixels.width(), patch.pixels.height(), size,
         size);
  }
  const std::vector<std::vector<float>> outputs = file_.run(input_of(patch));
  PatchPose pose;
  if (options_.gives == "heat_maps") {
    pose = peaks_in(outputs[landmarks_], patch);
  } else {
    pose.joints = joints_in(outputs[landmarks_], patch);
  }
  if (confidence_ >= 0) {
    pose.confidence.clear();
    const std::vector<float>& given = outputs[static_cast<std::size_t>(confidence_)];
    for (const std::size_t place : places_) pose.confidence.push_back(std::clamp(given[place], 0.0f, 1.0f));
  }
  return pose;
}

std::vector<float> ForeignEstimator::input_of(const HandPatch& patch) const {
  const double end = depth_end(options_.patch);
  std::vector<float> input;
  input.reserve(patch.pixels.size());
  for (const float d : patch.pixels.pixels()) {
    input.push_back(static_cast<float>(mapped(d, -end, end, options_.near_value, options_.far_value)));
  }
  return input;
}

std::vector<PatchPoint> ForeignEstimator::joints_in(const std::vector<float>& numbers,
                                                    const HandPatch& patch) const {
  std::vector<PatchPoint> joints;
  for (const std::size_t place : places_) {
    const auto number = [&](std::size_t axis) -> double {
      return is_planar_ ? numbers[axis * given_ + place] : numbers[3 * place + axis];
    };
    joints.push_back(point_of({number(0), number(1), number(2)}, patch));
  }
  return joints;
}

PatchPoint ForeignEstimator::point_of(const Point3& given, const HandPatch& patch) const {
  if (options_.gives == "uvd") {
    const double end = depth_end(options_.patch);
    return {mapped(given.x(), options_.first_pixel, options_.last_pixel, -1.0, 1.0),
            mapped(given.y(), options_.first_pixel, options_.last_pixel, -1.0, 1.0),
            mapped(given.z(), options_.near_depth, options_.far_depth, -end, end)};
  }
  Point3 offset = options_.xyz_mm * given;
  if (options_.axes != "right_down_far") offset.y() = -offset.y();
  if (options_.axes == "right_up_near") offset.z() = -offset.z();
  const Projection projection(patch.camera);
  const PatchGeometry& geometry = patch.geometry;
  const Point3 centre =
      projection.to_camera(ImagePoint{geometry.centre_u, geometry.centre_v, geometry.mean_depth_mm});
  const PatchPoint point = geometry.to_patch(projection.to_image(Point3(centre + offset)));
  if (!std::isfinite(point.u + point.v + point.d)) {
    fail("{}: a landmark that it gives lies behind the camera", file_.origin());
  }
  return point;
}

PatchPose ForeignEstimator::peaks_in(const std::vector<float>& maps, const HandPatch& patch) const {
  const auto cells = static_cast<std::size_t>(map_cells_) * map_cells_;
  std::vector<float> ordered;
  for (const std::size_t place : places_) {
    const auto first = maps.begin() + static_cast<std::ptrdiff_t>(place * cells);
    ordered.insert(ordered.end(), first, first + static_cast<std::ptrdiff_t>(cells));
  }
  NetworkOptions network;
  network.architecture = "heatmap2d";
  network.convention = convention_.name;
  network.patch = patches_.options();
  network.paper.map_cells = map_cells_;
  network.paper.peak = options_.peak;
  NetworkPrediction prediction = decode_heat_maps(network, ordered, patch.pixels.pixels());
  return {std::move(prediction.joints), std::move(prediction.confidence)};
}

}  // namespace knuckle
