// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/propagated_hand.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/label/label_propagation.h"

namespace knuckle {
namespace {

/// What machines saw first, before anything followed from neighbours.
std::vector<ImagePoint> first_estimate_of(HandKey hand, const LabelBook& book) {
  std::vector<ImagePoint> points(book.head().convention.landmarks.size());
  const HandHistory* const history = book.find(hand);
  if (history != nullptr && history->changes.front().act == LabelAct::estimate)
    std::ranges::transform(history->changes.front().landmarks, points.begin(), &LandmarkLabel::at);
  return points;
}

/// The verified hands around one that were fitted.
std::vector<LabelAnchor> anchors_of(HandKey hand, const LabelBook& book, const FittedHands& fits, int reach) {
  std::vector<LabelAnchor> anchors;
  for (const HandKey& other : verified_around(hand, book, fits, reach)) {
    const LabelFit* const fit = fits.find(other);
    if (fit == nullptr) continue;
    anchors.push_back({.away = static_cast<int>(std::abs(other.frame - hand.frame)),
                       .is_before = other.frame < hand.frame,
                       .fit = fit,
                       .labels = &book.find(other)->newest().landmarks,
                       .estimates = first_estimate_of(other, book)});
  }
  return anchors;
}

/// Whether any landmark lies clearly elsewhere, or is labelled in one of both alone.
bool has_moved(const std::vector<LandmarkLabel>& before, const std::vector<LandmarkLabel>& after,
               const Projection& projection) {
  constexpr double kClearlyMm = 1.0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (before[i].at.is_missing() != after[i].at.is_missing()) return true;
    if (before[i].at.is_missing()) continue;
    if ((projection.to_camera(before[i].at) - projection.to_camera(after[i].at)).norm() > kClearlyMm)
      return true;
  }
  return false;
}

}  // namespace

std::vector<HandKey> verified_around(HandKey hand, const LabelBook& book, const FittedHands& fits,
                                     int reach) {
  std::vector<HandKey> around;
  const int sequence = fits.sequence_of(hand.frame);
  for (const int direction : {-1, 1}) {
    for (int away = 1; away <= reach; ++away) {
      const HandKey other{hand.frame + direction * away, hand.side};
      if (other.frame < 0 || other.frame >= book.head().frames || fits.sequence_of(other.frame) != sequence)
        break;
      const HandHistory* const history = book.find(other);
      if (history != nullptr && history->state() == LabelState::verified) around.push_back(other);
    }
  }
  return around;
}

std::optional<PropagatedHand> following_hand(HandKey hand, const Frame& frame, const LabelBook& book,
                                             const FittedHands& fits, int reach) {
  const HandHistory* const history = book.find(hand);
  const std::vector<LabelAnchor> anchors = anchors_of(hand, book, fits, reach);
  if (anchors.empty()) return std::nullopt;
  const Projection projection(frame.camera);
  const std::vector<ImagePoint> estimates =
      estimates_beside(projection, first_estimate_of(hand, book), anchors);
  std::vector<LandmarkLabel> labels(estimates.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    labels[i].at = estimates[i];
    labels[i].is_visible = history == nullptr || history->newest().landmarks[i].is_visible;
  }
  const auto fit = fit_labels(frame, hand.side, book.head().convention, labels, estimates,
                              context_beside(fits.context_of(hand), anchors), fits.options());
  if (!fit) return std::nullopt;
  return PropagatedHand{with_fit(std::move(labels), *fit, LabelState::propagated), *fit};
}

std::optional<PropagatedHand> propagated_hand(HandKey hand, const Frame& frame, const LabelBook& book,
                                              const FittedHands& fits, int reach) {
  const HandHistory* const history = book.find(hand);
  if (history != nullptr && history->state() >= LabelState::corrected) return std::nullopt;
  auto following = following_hand(hand, frame, book, fits, reach);
  if (!following) return std::nullopt;
  const bool has_stayed = history != nullptr && !has_moved(history->newest().landmarks, following->labels,
                                                           Projection(frame.camera));
  if (has_stayed) return std::nullopt;
  return following;
}

}  // namespace knuckle
