// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/fitted_hands.h"

#include <algorithm>
#include <cmath>

namespace knuckle {
namespace {

constexpr std::size_t kMostToLearnFrom = 15;  // verified hands of a sequence: bones are known by then
constexpr std::size_t kMostAtFirst = 60;      // verified hands in all: who opens the page waits for them
constexpr double kUsualPalmMm = 95.0;
constexpr double kUnknownDoubtMm = 20.0;  // of labels that nothing was fitted to

/// How far a hand's labels may be off: how much the fit has to bend what was estimated, and how far the skin
/// is from what was measured.
double doubt_of(const LabelFit& fit) {
  return std::hypot(fit.rms_mm, std::isnan(fit.gap_mm) ? kUnknownDoubtMm : 2.0 * fit.gap_mm);
}

}  // namespace

FittedHands::FittedHands(const FrameSource& source, const LabelBook& book, const LabelFitOptions& options)
    : source_(source), book_(book), options_(options) {
  learn_first_bones();
}

int FittedHands::sequence_of(std::int64_t frame) const {
  const auto known = sequences_.find(frame);
  if (known != sequences_.end()) return known->second;
  return sequences_[frame] = source_.read_label(frame).sequence;
}

LabelFitContext FittedHands::context_of(HandKey hand) const {
  LabelFitContext context;
  const auto bones = bones_.find({sequence_of(hand.frame), hand.side});
  if (bones != bones_.end()) context.bones = &bones->second;
  if (const LabelFit* const fit = find(hand)) context.start = fit->pose;
  return context;
}

std::optional<LabelFit> FittedHands::fit(HandKey hand, const std::vector<LandmarkLabel>& labels,
                                         const Frame& frame) const {
  return fit(hand, labels, frame, context_of(hand));
}

std::optional<LabelFit> FittedHands::fit(HandKey hand, const std::vector<LandmarkLabel>& labels,
                                         const Frame& frame, const LabelFitContext& context) const {
  return fit_labels(frame, hand.side, book_.head().convention, labels, estimates_of(hand), context, options_);
}

/// Where machines saw the landmarks; of a hand that a person began, what it was first.
std::vector<ImagePoint> FittedHands::estimates_of(HandKey hand) const {
  const HandHistory* const history = book_.find(hand);
  std::vector<ImagePoint> points(book_.head().convention.landmarks.size());
  const LabelChange* const estimate = history == nullptr ? nullptr : history->estimate();
  if (estimate == nullptr) return points;
  std::ranges::transform(estimate->landmarks, points.begin(), &LandmarkLabel::at);
  return points;
}

const LabelFit* FittedHands::newest_fit(HandKey hand, const HandHistory& history, const Frame& frame) {
  const auto kept = fits_.find(hand);
  if (kept != fits_.end() && kept->second.revision == history.revision()) return &kept->second.fit;
  const auto fitted = fit(hand, history.newest().landmarks, frame);
  if (!fitted) return nullptr;
  keep(hand, history.revision(), *fitted);
  return find(hand);
}

void FittedHands::keep(HandKey hand, std::int64_t revision, const LabelFit& fit, double share_of_doubt) {
  fits_.insert_or_assign(hand, KeptFit{revision, fit, share_of_doubt * doubt_of(fit)});
}

void FittedHands::keep_unchanged(HandKey hand, std::int64_t before, std::int64_t after) {
  const auto kept = fits_.find(hand);
  if (kept != fits_.end() && kept->second.revision == before) kept->second.revision = after;
}

const LabelFit* FittedHands::find(HandKey hand) const {
  const auto kept = fits_.find(hand);
  return kept == fits_.end() ? nullptr : &kept->second.fit;
}

double FittedHands::doubt_mm(HandKey hand) const {
  const auto kept = fits_.find(hand);
  return kept == fits_.end() ? kUnknownDoubtMm : kept->second.doubt_mm;
}

double FittedHands::palm_mm(HandKey hand) const {
  const LabelFit* const fit = find(hand);
  return fit == nullptr ? kUsualPalmMm : kUsualPalmMm * fit->pose.size;
}

void FittedHands::learn_bones(HandKey hand, const Frame& frame) {
  PersonBones& bones = bones_[{frame.sequence, hand.side}];
  const HandHistory* const history = book_.find(hand);
  if (history == nullptr || history->state() != LabelState::verified) return bones.forget(hand);
  LabelFitContext alone;  // what others say of the bones shall not count twice
  alone.start = context_of(hand).start;
  const auto fitted = fit(hand, history->newest().landmarks, frame, alone);
  if (fitted) bones.learn(hand, fitted->pose);
}

void FittedHands::learn_first_bones() {
  std::map<std::pair<int, HandSide>, std::size_t> learned;
  std::size_t seen = 0;
  for (const auto& [hand, history] : book_.hands()) {
    if (history.state() != LabelState::verified) continue;
    if (++seen > kMostAtFirst) return;
    const FrameLabel label = source_.read_label(hand.frame);
    if (++learned[{label.sequence, hand.side}] > kMostToLearnFrom) continue;
    Frame blank;
    blank.camera = label.camera;
    blank.depth_mm = Image<float>(label.camera.width, label.camera.height);
    const auto fitted = fit(hand, history.newest().landmarks, blank, {});
    if (fitted) bones_[{label.sequence, hand.side}].learn(hand, fitted->pose);
  }
}

}  // namespace knuckle
