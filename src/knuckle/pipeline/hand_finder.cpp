// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/hand_finder.h"

#include <array>

#include "knuckle/camera/projection.h"
#include "knuckle/segment/detector/side_network.h"
#include "knuckle/segment/hand_region.h"
#include "knuckle/segment/segmenter_factory.h"

namespace knuckle {
namespace {

constexpr std::string_view kSides[] = {"right", "left", "auto"};

/// The known joints among `wanted`, in camera coordinates.
std::vector<Point3> known_joints(const Frame& frame, std::span<const Landmark> wanted) {
  const Projection projection(frame.camera);
  std::vector<Point3> points;
  for (const Landmark landmark : wanted) {
    const int index = frame.truth->convention.index_of(landmark);
    if (index < 0 || frame.truth->joints[index].is_missing()) continue;
    points.push_back(projection.to_camera(frame.truth->joints[index]));
  }
  return points;
}

Point3 mean_of(const std::vector<Point3>& points) {
  Point3 sum = Point3::Zero();
  for (const Point3& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

}  // namespace

void HandOptions::visit(OptionVisitor& visitor) {
  visitor.choice("side", side, kSides);
  visitor.integer("max_hands", max_hands, closed(1, 16));
  visitor.integer("candidates", candidates, closed(1, 16));
  visitor.real("sure_confidence", sure_confidence, closed(0, 1));
  visitor.real("hand_weight", hand_weight, closed(0, 1));
  visitor.real("judged_below", judged_below, closed(0, 1));
  visitor.real("confidence_offset", confidence_offset, closed(-10, 10));
  visitor.real("confidence_slope", confidence_slope, closed(0.01, 10));
}

HandFinder::HandFinder(std::unique_ptr<Segmenter> segmenter, const HandOptions& hand,
                       std::shared_ptr<const SideNetwork> sides)
    : hand_(hand), segmenter_(std::move(segmenter)), sides_(std::move(sides)) {
  check_options(hand_, "hand");
  if (!segmenter_) fail("a pipeline was to be made without a segmenter");
}

HandFinder::HandFinder(const OptionTable& document, const HandOptions& defaults) : hand_(defaults) {
  const OptionTable table = document.table("hand");
  table.read(hand_);
  if (table.has("side_model")) {
    const std::filesystem::path model = table.resolved_path(table.required_text("side_model"));
    sides_ = std::make_shared<const SideNetwork>(load_detector_weights(model));
  }
  segmenter_ = create_segmenter(document.table("segmentation"));
}

HandFinder HandFinder::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  HandFinder finder(document);
  for (const std::string_view other : {"patch", "estimator", "refine", "tracker"}) document.leave(other);
  document.finish();
  finder.resolved_options_ = document.resolved_toml();
  return finder;
}

Segmentation HandFinder::find(const Frame& frame, const std::optional<Point3>& start) const {
  if (!hand_.is_left()) {
    Segmentation segmentation = find_right(frame, start);
    tell_sides(frame, segmentation.hands);
    return segmentation;
  }
  Segmentation segmentation = find_right(mirrored(frame), mirrored(start));
  for (HandRegion& region : segmentation.hands) region = mirrored(region, frame.camera.width);
  return segmentation;
}

Segmentation HandFinder::find_right(const Frame& frame, const std::optional<Point3>& start) const {
  return find_right(frame, start, hand_.max_hands);
}

Segmentation HandFinder::find_right(const Frame& frame, const std::optional<Point3>& start,
                                    int max_hands) const {
  return segmenter_->segment(frame, start, max_hands);
}

void HandFinder::tell_sides(const Frame& frame, std::vector<HandRegion>& hands) const {
  if (!hand_.is_auto() || !sides_) return;
  std::vector<Point3> centres;
  for (const HandRegion& hand : hands) centres.push_back(hand.centre);
  const std::vector<double> right = sides_->right_hands(frame, centres);
  for (std::size_t i = 0; i < hands.size(); ++i) {
    hands[i].right_hand = right[i];
    hands[i].side = right[i] >= 0.5 ? HandSide::right : HandSide::left;
  }
}

Frame as_right_hand(Frame frame, const HandOptions& options) {
  const bool is_left = frame.side ? *frame.side == HandSide::left : options.is_left();
  return is_left ? mirrored(frame) : std::move(frame);
}

std::optional<Point3> mirrored(const std::optional<Point3>& point) {
  if (!point) return std::nullopt;
  return Point3(-point->x(), point->y(), point->z());
}

std::optional<Point3> true_start(const Frame& frame) {
  using enum Landmark;
  static constexpr std::array kPalm = {palm};
  static constexpr std::array kAroundPalm = {wrist, thumb_cmc, index_mcp, middle_mcp, ring_mcp, little_mcp};
  if (!frame.truth) return std::nullopt;
  for (const std::span<const Landmark> wanted :
       {std::span<const Landmark>(kPalm), std::span<const Landmark>(kAroundPalm),
        frame.truth->convention.landmarks}) {
    const std::vector<Point3> joints = known_joints(frame, wanted);
    if (!joints.empty()) return mean_of(joints);
  }
  return std::nullopt;
}

}  // namespace knuckle
