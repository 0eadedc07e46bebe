// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/detector_samples.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle {
namespace {

constexpr double kLeastExtentMm = 20.0;     // of a truth of few landmarks
constexpr double kLeastVisibleShare = 0.2;  // of a hand that has to be found

/// Centre and extent of the landmarks that are known; nothing where none is, or lies behind the camera.
std::optional<HandToDetect> hand_of(const HandPose& pose, const Projection& projection) {
  std::vector<Point3> points;
  Point3 sum = Point3::Zero();
  for (const ImagePoint& joint : pose.joints) {
    if (joint.is_missing()) continue;
    points.push_back(projection.to_camera(joint));
    sum += points.back();
  }
  if (points.empty()) return std::nullopt;
  HandToDetect hand;
  hand.centre = sum / static_cast<double>(points.size());
  if (!hand.centre.allFinite() || hand.centre.z() <= 0.0) return std::nullopt;
  hand.extent_mm = kLeastExtentMm;
  for (const Point3& point : points) hand.extent_mm = std::max(hand.extent_mm, (point - hand.centre).norm());
  return hand;
}

}  // namespace

std::vector<HandToDetect> hands_to_detect(const Frame& frame) {
  const Projection projection(frame.camera);
  std::vector<HandToDetect> labelled;
  for (const HandTruth& truth : frame.hands) {
    std::optional<HandToDetect> hand = hand_of(truth.pose, projection);
    if (!hand) continue;
    hand->side = truth.side;
    hand->counts = truth.visible_share >= kLeastVisibleShare;
    labelled.push_back(*hand);
  }
  if (!frame.hands.empty() || !frame.truth) return labelled;
  std::optional<HandToDetect> hand = hand_of(*frame.truth, projection);
  if (!hand) return labelled;
  hand->side = frame.side;
  labelled.push_back(*hand);
  return labelled;
}

DetectorSamples::DetectorSamples(const DetectorOptions& options, std::int64_t count)
    : options_(options),
      count_(count),
      codes_(cells() * static_cast<std::size_t>(count)),
      measured_(codes_.size()),
      hands_(static_cast<std::size_t>(count) * std::tuple_size_v<LabelledHands>) {}

std::int64_t DetectorSamples::bytes(std::int64_t count, const DetectorOptions& options) {
  const std::int64_t cells = std::int64_t{options.width} * options.height;
  return count * (3 * cells + static_cast<std::int64_t>(sizeof(LabelledHands)));
}

void DetectorSamples::set(std::int64_t index, const DetectorInput& input, const LabelledHands& hands) {
  const std::size_t first = static_cast<std::size_t>(index) * cells();
  const float* const inverse = input.inverse_depth.data();
  const float* const shares = input.measured_share.data();
  for (std::size_t i = 0; i < cells(); ++i) {
    codes_[first + i] = static_cast<std::uint16_t>(std::lround(inverse[i] * kCodesPerUnit));
    measured_[first + i] = static_cast<std::uint8_t>(std::lround(shares[i] * kPlaces));
  }
  std::ranges::copy(hands, hands_.begin() + index * std::ssize(hands));
}

DetectorSample DetectorSamples::sample(std::int64_t index) const {
  const auto i = static_cast<std::size_t>(index);
  constexpr std::size_t kNumbers = std::tuple_size_v<LabelledHands>;
  return {std::span(codes_).subspan(i * cells(), cells()), std::span(measured_).subspan(i * cells(), cells()),
          std::span(hands_).subspan(i * kNumbers, kNumbers)};
}

LabelledHands hand_numbers(const std::vector<HandToDetect>& hands, const DetectorView& view) {
  LabelledHands numbers;
  numbers.fill(static_cast<float>(kNaN));
  const std::size_t count = std::min(hands.size(), kMostLabelledHands);
  for (std::size_t i = 0; i < count; ++i) {
    const ViewPlace place = view.to_view(hands[i].centre);
    float* const to = numbers.data() + i * kHandNumbers;
    to[kHandU] = static_cast<float>(place.u);
    to[kHandV] = static_cast<float>(place.v);
    to[kHandInverseDepth] = static_cast<float>(std::log(place.inverse_depth));
    to[kHandExtent] = static_cast<float>(std::log(hands[i].extent_mm / kExtentUnitMm));
    if (hands[i].side) to[kHandSide] = *hands[i].side == HandSide::right ? 1.0f : 0.0f;
    to[kHandCounts] = hands[i].counts ? 1.0f : 0.0f;
  }
  return numbers;
}

void DetectorSource::visit(OptionVisitor& visitor) {
  visitor.integer("most", most, closed(0, 1e9));
}

DetectorFrames::DetectorFrames(std::span<const DetectorSource> sources, const DetectorOptions& options)
    : options_(options), views_([options](const Camera& camera) {
        return std::make_shared<const DetectorView>(options, camera);
      }) {
  for (const DetectorSource& set : sources) {
    Part part{open_source(set.source), count_, 0};
    if (!part.source->convention()) fail("{}: the source has no truth to train on", set.source);
    const std::int64_t all = part.source->size();
    part.count = set.most > 0 ? std::min<std::int64_t>(set.most, all) : all;
    count_ += part.count;
    parts_.push_back(std::move(part));
  }
}

void DetectorFrames::put(std::int64_t number, DetectorSamples& to, std::int64_t place) const {
  const Part& part = *std::prev(std::ranges::upper_bound(parts_, number, {}, &Part::first));
  const Frame frame = part.source->read((number - part.first) * part.source->size() / part.count);
  const std::shared_ptr<const DetectorView> view = views_.of(frame.camera);
  to.set(place, view->shrink(frame.depth_mm), hand_numbers(hands_to_detect(frame), *view));
}

DetectorSamples samples_of(const DetectorFrames& frames) {
  DetectorSamples samples(frames.options(), frames.size());
  Progress progress("samples", "frames", frames.size());
  parallel_for(frames.size(), [&](std::int64_t i) {
    frames.put(i, samples, i);
    progress.advance();
  });
  return samples;
}

}  // namespace knuckle
