// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_session.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>

#include <fmt/chrono.h>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/data/defined_pose.h"
#include "knuckle/label/label_edit.h"
#include "knuckle/label/label_propagation.h"
#include "knuckle/label/label_skin.h"

namespace knuckle {
namespace {

constexpr std::size_t kKeptFrames = 12;
constexpr std::size_t kMostToLearnFrom = 15;  // verified hands of a sequence: bones are known by then
constexpr double kUsualPalmMm = 95.0;
constexpr int kFollowingReach = 4;        // frames on both sides that surely follow a verified one
constexpr double kUnknownDoubtMm = 20.0;  // of labels that nothing was fitted to

bool has_landmarks(const LabelChange& change) {
  return std::ranges::any_of(change.landmarks,
                             [](const LandmarkLabel& label) { return !label.at.is_missing(); });
}

bool is_labelled(const LabelChange& change) {
  return change.mask != nullptr || has_landmarks(change);
}

/// All of them visible: what is hidden a person says. A machine's guess would make good estimates count for
/// nothing.
std::vector<LandmarkLabel> labels_of(const HandPose& pose) {
  std::vector<LandmarkLabel> labels(pose.joints.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (!pose.joints[i].is_missing()) labels[i].at = pose.joints[i];
  }
  return labels;
}

/// Whether any landmark lies clearly elsewhere, or is labelled in one of both alone: less is not worth a line
/// in the file.
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

double milliseconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

/// How far a hand's labels may be off: how much the fit has to bend what was estimated, and how far the skin
/// is from what was measured.
double doubt_of(const LabelFit& fit) {
  return std::hypot(fit.rms_mm, std::isnan(fit.gap_mm) ? kUnknownDoubtMm : 2.0 * fit.gap_mm);
}

}  // namespace

LabelSession::LabelSession(const FrameSource& source, LabelJournal& journal, LabelSessionOptions options)
    : source_(source), journal_(journal), options_(std::move(options)), frames_(source, kKeptFrames) {
  for (const auto& [hand, history] : journal_.book().hands()) looked_at_.insert(hand.frame);
  learn_all_bones();
}

LabelSession::~LabelSession() = default;

std::string LabelSession::now() const {
  return options_.now ? options_.now()
                      : fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

int LabelSession::sequence_of(std::int64_t index) const {
  const auto known = sequences_.find(index);
  if (known != sequences_.end()) return known->second;
  return sequences_[index] = source_.read_label(index).sequence;
}

// --- frames ---

LabelledFrame LabelSession::frame(std::int64_t index) {
  auto frame = frames_.read(index);
  estimate(index, *frame);
  const std::lock_guard lock(mutex_);
  return labelled(index, std::move(frame));
}

LabelledFrame LabelSession::labelled(std::int64_t index, std::shared_ptr<const Frame> frame) {
  LabelledFrame labelled{.index = index, .frame = std::move(frame), .hands = {}};
  for (const HandSide side : {HandSide::right, HandSide::left}) {
    const HandKey hand{index, side};
    const HandHistory* const history = journal_.book().find(hand);
    if (history != nullptr && is_labelled(history->newest()))
      labelled.hands.push_back(labelled_hand(hand, *history, *labelled.frame));
  }
  return labelled;
}

LabelledHand LabelSession::labelled_hand(HandKey hand, const HandHistory& history, const Frame& frame) {
  const LabelChange& newest = history.newest();
  LabelledHand labelled{.side = hand.side,
                        .revision = newest.revision,
                        .state = history.state(),
                        .landmarks = newest.landmarks,
                        .fit = {},
                        .mask = newest.mask,
                        .seconds = 0.0,
                        .author = newest.author,
                        .time = newest.time};
  for (const LabelChange& change : history.changes) labelled.seconds += change.seconds;
  auto kept = fits_.find(hand);
  if (kept == fits_.end() || kept->second.revision != newest.revision) {
    const auto fit = fitted(hand, newest.landmarks, frame, context_of(hand));
    if (!fit) return labelled;
    kept = fits_.insert_or_assign(hand, KeptFit{newest.revision, *fit, doubt_of(*fit)}).first;
  }
  labelled.fit = kept->second.fit;
  return labelled;
}

std::vector<FrameStanding> LabelSession::standings() const {
  const std::lock_guard lock(mutex_);
  std::vector<FrameStanding> standings(static_cast<std::size_t>(head().frames));
  for (const auto& [hand, history] : journal_.book().hands()) {
    if (!is_labelled(history.newest())) continue;
    FrameStanding& standing = standings[static_cast<std::size_t>(hand.frame)];
    const LabelState state = history.state();
    standing.state = std::min(standing.state.value_or(state), state);
    if (state == LabelState::verified) continue;
    const auto fit = fits_.find(hand);
    standing.doubt_mm =
        std::max(standing.doubt_mm, fit == fits_.end() ? kUnknownDoubtMm : fit->second.doubt_mm);
  }
  return standings;
}

std::optional<std::int64_t> LabelSession::proposed(std::int64_t after) const {
  return proposed_frame(standings(), after, kFollowingReach);
}

std::vector<double> LabelSession::seconds_of_verified() const {
  const std::lock_guard lock(mutex_);
  std::vector<double> seconds;
  for (const auto& [hand, history] : journal_.book().hands()) {
    if (history.state() != LabelState::verified) continue;
    double sum = 0.0;
    for (const LabelChange& change : history.changes) sum += change.seconds;
    seconds.push_back(sum);
  }
  return seconds;
}

std::string LabelSession::fault() const {
  const std::lock_guard lock(mutex_);
  return journal_.fault();
}

std::size_t LabelSession::waiting() const {
  const std::lock_guard lock(mutex_);
  return journal_.waiting();
}

// --- the hand model ---

/// Where machines saw the landmarks; of a hand that a person began, what it was first.
std::vector<ImagePoint> LabelSession::estimates_of(HandKey hand) const {
  const HandHistory* const history = journal_.book().find(hand);
  std::vector<ImagePoint> points(head().convention.landmarks.size());
  const LabelChange* const estimate = history == nullptr ? nullptr : history->estimate();
  if (estimate == nullptr) return points;
  std::ranges::transform(estimate->landmarks, points.begin(), &LandmarkLabel::at);
  return points;
}

LabelFitContext LabelSession::context_of(HandKey hand) const {
  LabelFitContext context;
  const auto bones = bones_.find({sequence_of(hand.frame), hand.side});
  if (bones != bones_.end()) context.bones = &bones->second;
  const auto kept = fits_.find(hand);
  if (kept != fits_.end()) context.start = kept->second.fit.pose;
  return context;
}

double LabelSession::palm_mm(HandKey hand) const {
  const auto kept = fits_.find(hand);
  return kept == fits_.end() ? kUsualPalmMm : kUsualPalmMm * kept->second.fit.pose.size;
}

std::optional<LabelFit> LabelSession::fitted(HandKey hand, const std::vector<LandmarkLabel>& labels,
                                             const Frame& frame, const LabelFitContext& context) const {
  return fit_labels(frame, hand.side, head().convention, labels, estimates_of(hand), context, options_.fit);
}

void LabelSession::learn_bones(HandKey hand, const Frame& frame) {
  PersonBones& bones = bones_[{frame.sequence, hand.side}];
  const HandHistory* const history = journal_.book().find(hand);
  if (history == nullptr || history->state() != LabelState::verified) return bones.forget(hand);
  LabelFitContext alone;  // what others say of the bones shall not count twice
  alone.start = context_of(hand).start;
  const auto fit = fitted(hand, history->newest().landmarks, frame, alone);
  if (fit) bones.learn(hand, fit->pose);
}

/// From the landmarks alone: images need not be read.
void LabelSession::learn_all_bones() {
  std::map<std::pair<int, HandSide>, std::size_t> learned;
  for (const auto& [hand, history] : journal_.book().hands()) {
    if (history.state() != LabelState::verified) continue;
    const FrameLabel label = source_.read_label(hand.frame);
    if (++learned[{label.sequence, hand.side}] > kMostToLearnFrom) continue;
    Frame blank;
    blank.camera = label.camera;
    blank.depth_mm = Image<float>(label.camera.width, label.camera.height);
    const auto fit = fitted(hand, history.newest().landmarks, blank, {});
    if (fit) bones_[{label.sequence, hand.side}].learn(hand, fit->pose);
  }
}

// --- changes ---

LabelAnswer LabelSession::apply(const LabelRequest& request) {
  if (request.kind == LabelRequest::Kind::undo) return step_back(LabelAct::undo);
  if (request.kind == LabelRequest::Kind::redo) return step_back(LabelAct::redo);
  const auto frame = frames_.read(request.hand.frame);
  const std::lock_guard lock(mutex_);
  return change_hand(request, frame);
}

LabelAnswer LabelSession::change_hand(const LabelRequest& request,
                                      const std::shared_ptr<const Frame>& frame) {
  LabelAnswer answer;
  const HandHistory* const history = journal_.book().find(request.hand);
  if (request.revision != (history == nullptr ? 0 : history->revision())) {
    answer.is_refused = true;
    answer.remark =
        "The labels of this hand were changed elsewhere meanwhile; what you see now is how they stand.";
    answer.labelled = labelled(request.hand.frame, frame);
    return answer;
  }
  LabelChange change{.frame = request.hand.frame,
                     .side = request.hand.side,
                     .revision = request.revision + 1,
                     .act = LabelAct::correct,
                     .author = options_.author,
                     .time = now(),
                     .seconds = request.seconds};
  change.landmarks.resize(head().convention.landmarks.size());
  if (history != nullptr) {
    change.landmarks = history->newest().landmarks;
    change.mask = history->newest().mask;
  }
  if (request.kind == LabelRequest::Kind::brush || request.kind == LabelRequest::Kind::outline)
    return change_mask(request, frame, std::move(change));
  if (request.kind == LabelRequest::Kind::look) change.act = LabelAct::look;
  if (request.kind == LabelRequest::Kind::verify) change.act = LabelAct::verify;
  const bool verifies_mask_alone = change.act == LabelAct::verify && change.mask && !has_landmarks(change);
  if (!verifies_mask_alone)
    answer.remark = edit_labels(request, *frame, head().convention, palm_mm(request.hand), change.landmarks);
  if (!answer.remark.empty()) {
    answer.labelled = labelled(request.hand.frame, frame);
    return answer;
  }
  const auto begin = std::chrono::steady_clock::now();
  if (request.kind == LabelRequest::Kind::place && request.uses_model)
    settle_depth(request, *frame, change.landmarks);
  const auto fit = fitted(request.hand, change.landmarks, *frame, context_of(request.hand));
  answer.fit_ms = milliseconds_since(begin);
  const bool moves_others = request.uses_model && change.act == LabelAct::correct;
  if (fit && moves_others) change.landmarks = with_fit(change.landmarks, *fit, LabelState::estimated);
  if (request.is_preview) {
    answer.labelled = labelled(request.hand.frame, frame);
    auto& hands = answer.labelled.hands;
    auto hand = std::ranges::find(hands, request.hand.side, &LabelledHand::side);
    if (hand == hands.end()) hand = hands.insert(hands.end(), LabelledHand{.side = request.hand.side});
    hand->landmarks = change.landmarks;
    hand->fit = fit;
    return answer;
  }
  if (fit) fits_.insert_or_assign(request.hand, KeptFit{change.revision, *fit, doubt_of(*fit)});
  const bool was_verified = history != nullptr && history->state() == LabelState::verified;
  const bool is_verify = change.act == LabelAct::verify;
  commit(std::move(change));
  if (is_verify || was_verified) learn_bones(request.hand, *frame);
  if (is_verify) queue_neighbours(request.hand);
  answer.labelled = labelled(request.hand.frame, frame);
  return answer;
}

/// Landmarks stay as they are, and so does what was fitted to them.
LabelAnswer LabelSession::change_mask(const LabelRequest& request, const std::shared_ptr<const Frame>& frame,
                                      LabelChange change) {
  change.act = LabelAct::brush;
  std::optional<LabelFit> fit;
  if (request.kind == LabelRequest::Kind::outline)
    fit = fitted(request.hand, change.landmarks, *frame, context_of(request.hand));
  LabelAnswer answer;
  answer.remark = edit_mask(request, *frame, fit ? &*fit : nullptr, change.mask);
  if (answer.remark.empty() && !request.is_preview) {
    const auto kept = fits_.find(request.hand);
    if (kept != fits_.end() && kept->second.revision == request.revision)
      kept->second.revision = change.revision;
    commit(std::move(change));
  }
  answer.labelled = labelled(request.hand.frame, frame);
  return answer;
}

/// A landmark that was shown on a pixel stays on it; how deep it lies the hand model says as well, fitted to
/// all the others. Of a hidden one it alone does: the skin that is seen there is not its own.
void LabelSession::settle_depth(const LabelRequest& request, const Frame& frame,
                                std::vector<LandmarkLabel>& labels) const {
  LabelFitContext context = context_of(request.hand);
  context.left_out = request.landmark;
  const auto fit = fitted(request.hand, labels, frame, context);
  if (!fit || fit->points[request.landmark].is_missing()) return;
  LandmarkLabel& label = labels[request.landmark];
  const double fitted_mm = fit->points[request.landmark].depth_mm;
  label.at.depth_mm = label.is_visible ? settled_depth_mm(label.at.depth_mm, fitted_mm) : fitted_mm;
}

LabelAnswer LabelSession::step_back(LabelAct act) {
  LabelAnswer answer;
  std::optional<LabelChange> change;
  {
    const std::lock_guard lock(mutex_);
    change = act == LabelAct::undo ? journal_.book().undone() : journal_.book().redone();
  }
  if (!change) {
    answer.is_refused = true;
    answer.remark = act == LabelAct::undo ? "There is nothing to undo." : "There is nothing to redo.";
    return answer;
  }
  const HandKey hand{change->frame, change->side};
  const auto frame = frames_.read(hand.frame);
  const std::lock_guard lock(mutex_);
  change = act == LabelAct::undo ? journal_.book().undone() : journal_.book().redone();
  if (!change || HandKey{change->frame, change->side} != hand) {
    answer.is_refused = true;
    answer.remark = "The labels were changed elsewhere meanwhile; try again.";
    answer.labelled = labelled(hand.frame, frame);
    return answer;
  }
  change->author = options_.author;
  change->time = now();
  commit(std::move(*change));
  learn_bones(hand, *frame);
  answer.labelled = labelled(hand.frame, frame);
  return answer;
}

void LabelSession::commit(LabelChange change) {
  const HandKey hand{change.frame, change.side};
  const std::int64_t revision = change.revision;
  journal_.add(std::move(change));
  looked_at_.insert(hand.frame);
  if (changed) changed(hand, revision);
}

// --- what can wait ---

bool LabelSession::work() {
  {
    const std::lock_guard lock(mutex_);
    if (journal_.waiting() > 0) journal_.flush();
  }
  return propagate_one() || estimate_one();
}

void LabelSession::estimate(std::int64_t index, const Frame& frame) {
  if (!options_.estimate) return;
  {
    const std::lock_guard lock(mutex_);
    if (!looked_at_.insert(index).second) return;
  }
  std::vector<LabelChange> changes = estimated(index, frame);
  const std::lock_guard lock(mutex_);
  for (LabelChange& change : changes) {
    if (journal_.book().find({index, change.side}) == nullptr) commit(std::move(change));
  }
  labelled(index, std::make_shared<const Frame>(frame));  // how doubtful it is
}

/// The first hand of each side.
std::vector<LabelChange> LabelSession::estimated(std::int64_t index, const Frame& frame) const {
  std::vector<LabelChange> changes;
  for (const EstimatedHand& hand : options_.estimate(frame)) {
    if (std::ranges::find(changes, hand.side, &LabelChange::side) != changes.end()) continue;
    changes.push_back({.frame = index,
                       .side = hand.side,
                       .revision = 1,
                       .act = LabelAct::estimate,
                       .author = options_.estimator,
                       .time = now(),
                       .seconds = 0.0,
                       .landmarks = labels_of(converted(hand.pose, head().convention))});
  }
  return changes;
}

bool LabelSession::estimate_one() {
  if (!options_.estimate) return false;
  std::int64_t index = 0;
  {
    const std::lock_guard lock(mutex_);
    while (next_estimate_ < head().frames && looked_at_.contains(next_estimate_)) ++next_estimate_;
    if (next_estimate_ == head().frames) return false;
    index = next_estimate_++;
  }
  try {
    estimate(index, *frames_.read(index));
  } catch (const Error&) {  // who opens this frame is told
  }
  return true;
}

/// The nearest first: they follow most surely. On each side as far as the next verified frame.
void LabelSession::queue_neighbours(HandKey hand) {
  std::array<bool, 2> goes_on{true, true};
  for (int away = 1; away <= options_.reach; ++away) {
    for (const int direction : {-1, 1}) {
      bool& goes = goes_on[direction < 0 ? 0 : 1];
      const HandKey other{hand.frame + direction * away, hand.side};
      goes = goes && other.frame >= 0 && other.frame < head().frames;
      if (!goes) continue;
      const HandHistory* const history = journal_.book().find(other);
      if (history != nullptr && history->state() == LabelState::verified) goes = false;
      if (history != nullptr && history->state() >= LabelState::corrected) continue;
      std::erase(to_propagate_, other);
      to_propagate_.push_back(other);
    }
  }
}

bool LabelSession::propagate_one() {
  HandKey hand;
  {
    const std::lock_guard lock(mutex_);
    if (to_propagate_.empty()) return false;
    hand = to_propagate_.front();
    to_propagate_.pop_front();
  }
  try {
    const auto frame = frames_.read(hand.frame);
    estimate(hand.frame, *frame);
    const std::lock_guard lock(mutex_);
    propagate(hand, *frame);
  } catch (const Error&) {  // who opens this frame is told
  }
  return true;
}

/// What machines saw first, before anything followed from neighbours.
std::vector<ImagePoint> LabelSession::first_estimate_of(HandKey hand) const {
  std::vector<ImagePoint> points(head().convention.landmarks.size());
  const HandHistory* const history = journal_.book().find(hand);
  if (history != nullptr && history->changes.front().act == LabelAct::estimate)
    std::ranges::transform(history->changes.front().landmarks, points.begin(), &LandmarkLabel::at);
  return points;
}

/// The verified hands around one, in the same sequence.
std::vector<LabelAnchor> LabelSession::anchors_of(HandKey hand) const {
  std::vector<LabelAnchor> anchors;
  const int sequence = sequence_of(hand.frame);
  for (const int direction : {-1, 1}) {
    for (int away = 1; away <= options_.reach; ++away) {
      const HandKey other{hand.frame + direction * away, hand.side};
      if (other.frame < 0 || other.frame >= head().frames || sequence_of(other.frame) != sequence) break;
      const HandHistory* const history = journal_.book().find(other);
      if (history == nullptr || history->state() != LabelState::verified) continue;
      const auto fit = fits_.find(other);
      if (fit == fits_.end()) continue;
      anchors.push_back({.away = away,
                         .is_before = direction < 0,
                         .fit = &fit->second.fit,
                         .labels = &history->newest().landmarks,
                         .estimates = first_estimate_of(other)});
    }
  }
  return anchors;
}

void LabelSession::propagate(HandKey hand, const Frame& frame) {
  const HandHistory* const history = journal_.book().find(hand);
  if (history != nullptr && history->state() >= LabelState::corrected) return;
  const std::vector<LabelAnchor> anchors = anchors_of(hand);
  if (anchors.empty()) return;
  const std::vector<ImagePoint> estimates =
      estimates_beside(Projection(frame.camera), first_estimate_of(hand), anchors);
  const LabelFitContext context = context_beside(context_of(hand), anchors);
  std::vector<LandmarkLabel> labels(estimates.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    labels[i].at = estimates[i];
    labels[i].is_visible = history == nullptr || history->newest().landmarks[i].is_visible;
  }
  const auto fit = fit_labels(frame, hand.side, head().convention, labels, estimates, context, options_.fit);
  if (!fit) return;
  labels = with_fit(std::move(labels), *fit, LabelState::propagated);
  if (history != nullptr && !has_moved(history->newest().landmarks, labels, Projection(frame.camera))) return;
  const std::int64_t revision = history == nullptr ? 1 : history->revision() + 1;
  fits_.insert_or_assign(hand, KeptFit{revision, *fit, 0.5 * doubt_of(*fit)});
  commit({.frame = hand.frame,
          .side = hand.side,
          .revision = revision,
          .act = LabelAct::propagate,
          .author = "propagation",
          .time = now(),
          .seconds = 0.0,
          .landmarks = std::move(labels)});
}

}  // namespace knuckle
