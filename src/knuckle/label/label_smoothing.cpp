// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_smoothing.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <Eigen/Cholesky>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/portable_math.h"

namespace knuckle {
namespace {

/// A hand of a sequence, in the order of time.
struct HandInTime {
  std::int64_t frame = 0;
  double time = 0.0;
  Camera camera;
  const HandHistory* history = nullptr;
  std::vector<Point3> places;   ///< one per landmark [mm]; not finite where it is not labelled
  std::vector<double> weights;  ///< inverse squares of their deviations [1 / mm²]
};

/// Whether a person put the landmark where it is now, rather than finding the whole hand right.
bool is_placed(const HandHistory& history, std::size_t landmark) {
  const ImagePoint& now = history.newest().landmarks[landmark].at;
  return std::ranges::any_of(history.changes, [&](const LabelChange& change) {
    const LandmarkLabel& label = change.landmarks[landmark];
    return label.state == LabelState::corrected && label.at.u == now.u && label.at.v == now.v &&
           label.at.depth_mm == now.depth_mm;
  });
}

double deviation_mm(const HandHistory& history, std::size_t landmark, const LabelFitOptions& options) {
  if (!is_placed(history, landmark)) return options.estimate_mm;
  return history.newest().landmarks[landmark].is_visible ? options.pin_mm : options.guess_mm;
}

HandInTime in_time(HandKey hand, const HandHistory& history, const FrameLabel& frame,
                   const LabelFitOptions& options) {
  HandInTime in_time{.frame = hand.frame,
                     .time = frame.time_s.value_or(kNaN),
                     .camera = frame.camera,
                     .history = &history,
                     .places = {},
                     .weights = {}};
  const Projection projection(frame.camera);
  const std::vector<LandmarkLabel>& labels = history.newest().landmarks;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const ImagePoint& at = labels[i].at;
    in_time.places.push_back(at.is_missing() ? Point3::Constant(kNaN) : projection.to_camera(at));
    in_time.weights.push_back(std::pow(deviation_mm(history, i, options), -2.0));
  }
  return in_time;
}

/// Hands of one sequence and side.
class HandTrajectory {
 public:
  HandTrajectory(std::vector<HandInTime> hands, int reach) : hands_(std::move(hands)), reach_(reach) {
    const auto is_no_later = [](const HandInTime& one, const HandInTime& next) {
      return !(one.time < next.time);  // or has no time
    };
    if (std::ranges::adjacent_find(hands_, is_no_later) == hands_.end()) return;
    for (HandInTime& hand : hands_) hand.time = static_cast<double>(hand.frame);
  }

  void smooth_into(SmoothedLabels& smoothed, HandSide side) const {
    for (std::size_t h = 0; h < hands_.size(); ++h) {
      std::vector<ImagePoint>& points = smoothed[{hands_[h].frame, side}];
      for (std::size_t i = 0; i < hands_[h].places.size(); ++i) points.push_back(smoothed_point(h, i));
    }
  }

 private:
  ImagePoint smoothed_point(std::size_t hand, std::size_t landmark) const {
    const HandInTime& now = hands_[hand];
    const ImagePoint& labelled = now.history->newest().landmarks[landmark].at;
    const Point3 place = smoothed_place(hand, landmark);
    if (!place.allFinite() || !(place.z() > 0.0)) return labelled;
    return Projection(now.camera).to_image(place);
  }

  /// Not finite where the label is missing, or too few are near.
  Point3 smoothed_place(std::size_t hand, std::size_t landmark) const {
    constexpr int kTerms = 3;  // of a parabola
    const HandInTime& now = hands_[hand];
    if (!now.places[landmark].allFinite()) return now.places[landmark];
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    int count = 0;
    for (const HandInTime& other : near(now.frame)) {
      if (!other.places[landmark].allFinite()) continue;
      const double moment = (other.time - now.time) / unit_of_time(now);
      const Eigen::Vector3d powers(1.0, moment, moment * moment);
      const double away = static_cast<double>(other.frame - now.frame) / (0.6 * reach_);
      const double weight = portable_exp(-0.5 * away * away) * other.weights[landmark];
      squares += weight * powers * powers.transpose();
      products += weight * powers * other.places[landmark].transpose();
      ++count;
    }
    const int terms = std::min(kTerms, count - 1);
    if (terms < 2) return Point3::Constant(kNaN);
    const Eigen::MatrixXd solved = squares.topLeftCorner(terms, terms).ldlt().solve(products.topRows(terms));
    return solved.row(0).transpose();
  }

  std::span<const HandInTime> near(std::int64_t frame) const {
    const auto begin = std::ranges::lower_bound(hands_, frame - reach_, {}, &HandInTime::frame);
    const auto end = std::ranges::upper_bound(hands_, frame + reach_, {}, &HandInTime::frame);
    return {begin, end};
  }

  /// That of a reach, so that moments are about 1.
  double unit_of_time(const HandInTime& now) const {
    double farthest = 0.0;
    for (const HandInTime& other : near(now.frame))
      farthest = std::max(farthest, std::abs(other.time - now.time));
    return farthest > 0.0 ? farthest : 1.0;
  }

  std::vector<HandInTime> hands_;
  int reach_;
};

}  // namespace

SmoothedLabels smoothed_labels(const FrameSource& source, const LabelBook& book, LabelState least, int reach,
                               const LabelFitOptions& options) {
  constexpr int kFarthest = 100;
  if (reach < 1 || reach > kFarthest)
    fail("labels are smoothed over 1 to {} frames on both sides, {} were asked for", kFarthest, reach);
  std::map<std::pair<int, HandSide>, std::vector<HandInTime>> sequences;
  for (const auto& [hand, history] : book.hands()) {
    if (history.state() < least || !has_landmarks(history.newest())) continue;
    const FrameLabel frame = source.read_label(hand.frame);
    sequences[{frame.sequence, hand.side}].push_back(in_time(hand, history, frame, options));
  }
  SmoothedLabels smoothed;
  for (auto& [sequence, hands] : sequences)
    HandTrajectory(std::move(hands), reach).smooth_into(smoothed, sequence.second);
  return smoothed;
}

}  // namespace knuckle
