// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/exported_estimator.h"

#include <algorithm>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/net/heat_map_decoding.h"
#include "knuckle/net/paper_architecture.h"

namespace knuckle {
namespace {

std::string text_of(const OnnxShape& shape) {
  std::string text;
  for (const std::int64_t size : shape) text += fmt::format("{}{}", text.empty() ? "" : " x ", size);
  return text;
}

}  // namespace

ExportedEstimator::ExportedEstimator(OnnxNetwork file, NetworkOptions network,
                                     const NetworkEstimatorOptions& options)
    : file_(std::move(file)),
      network_(std::move(network)),
      options_(options),
      convention_(network_.landmarks()),
      patches_(network_.patch) {
  check_options(options_, "network estimator");
  const std::int64_t size = network_.patch.size_px;
  const OnnxShape expected = {1, 1, size, size};
  if (file_.input_shape() != expected) {
    fail("{}: its input is {}, but its metadata ask for {}", file_.origin(), text_of(file_.input_shape()),
         text_of(expected));
  }
  find_outputs();
}

void ExportedEstimator::find_outputs() {
  const std::int64_t joints = network_.joint_count();
  if (network_.architecture.starts_with("heatmap")) {
    const std::int64_t cells = network_.paper.map_cells;
    const std::int64_t bins = depth_bins_per_joint(network_);
    heat_maps_ = output("heat_maps", {1, joints, cells, cells}, true);
    if (bins > 0) depth_bins_ = output("depth_bins", {1, joints, bins}, true);
    return;
  }
  landmarks_ = output("landmarks", {1, joints, 3}, true);
  confidence_ = output("confidence", {1, joints}, network_.architecture == "dense");
  right_hand_ = output("right_hand", {1, 1}, false);
  hand_ = output("hand", {1, 1}, false);
}

int ExportedEstimator::output(const std::string& name, const OnnxShape& shape, bool is_required) const {
  const int place = file_.output_named(name);
  if (place < 0) {
    if (is_required) fail("{}: it has no output '{}', which its metadata ask for", file_.origin(), name);
    return -1;
  }
  const OnnxShape& found = file_.outputs()[static_cast<std::size_t>(place)].shape;
  if (found != shape) {
    fail("{}: its output '{}' is {}, but its metadata ask for {}", file_.origin(), name, text_of(found),
         text_of(shape));
  }
  return place;
}

PatchPose ExportedEstimator::estimate(const HandPatch& patch) const {
  const int size = network_.patch.size_px;
  if (patch.pixels.width() != size || patch.pixels.height() != size) {
    fail("network: a patch of {} x {}, expected {} x {}", patch.pixels.width(), patch.pixels.height(), size,
         size);
  }
  const std::vector<std::vector<float>> outputs = file_.run(patch.pixels.pixels());
  const auto at = [&](int place) -> const std::vector<float>& {
    return outputs[static_cast<std::size_t>(place)];
  };
  if (heat_maps_ >= 0) {
    std::vector<float> maps = at(heat_maps_);
    if (depth_bins_ >= 0) maps.insert(maps.end(), at(depth_bins_).begin(), at(depth_bins_).end());
    NetworkPrediction prediction = decode_heat_maps(network_, maps, patch.pixels.pixels());
    return {std::move(prediction.joints), std::move(prediction.confidence)};
  }
  PatchPose pose;
  const std::vector<float>& numbers = at(landmarks_);
  for (std::size_t i = 0; i < numbers.size(); i += 3) {
    pose.joints.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  }
  if (confidence_ >= 0) {
    for (const float confidence : at(confidence_))
      pose.confidence.push_back(std::clamp(confidence, 0.0f, 1.0f));
  }
  if (right_hand_ >= 0) pose.right_hand = std::clamp(at(right_hand_).front(), 0.0f, 1.0f);
  if (hand_ >= 0) pose.hand = std::clamp(at(hand_).front(), 0.0f, 1.0f);
  return pose;
}

}  // namespace knuckle
