// SPDX-License-Identifier: Apache-2.0
// What a person does to labels in a session: each change is checked, made with the hand model's help, kept.
#include <algorithm>
#include <chrono>
#include <utility>

#include "knuckle/label/label_edit.h"
#include "knuckle/label/label_session.h"
#include "knuckle/label/label_skin.h"

namespace knuckle {
namespace {

double milliseconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

bool changes_mask(LabelRequest::Kind kind) {
  return kind == LabelRequest::Kind::brush || kind == LabelRequest::Kind::outline;
}

/// Of what changes landmarks.
LabelAct act_of(LabelRequest::Kind kind) {
  if (kind == LabelRequest::Kind::look) return LabelAct::look;
  if (kind == LabelRequest::Kind::verify) return LabelAct::verify;
  return LabelAct::correct;
}

}  // namespace

LabelAnswer LabelSession::apply(const LabelRequest& request) {
  if (request.kind == LabelRequest::Kind::undo) return step_back(LabelAct::undo);
  if (request.kind == LabelRequest::Kind::redo) return step_back(LabelAct::redo);
  const auto frame = frames_.read(request.hand.frame);
  const std::lock_guard lock(mutex_);
  return change_hand(request, frame);
}

LabelAnswer LabelSession::change_hand(const LabelRequest& request,
                                      const std::shared_ptr<const Frame>& frame) {
  const HandHistory* const history = journal_.book().find(request.hand);
  if (request.revision != (history == nullptr ? 0 : history->revision())) {
    LabelAnswer refused = as_it_stands(
        request, frame,
        "The labels of this hand were changed elsewhere meanwhile; what you see now is how they stand.");
    refused.is_refused = true;
    return refused;
  }
  LabelChange change = begun_change(request);
  return changes_mask(request.kind) ? change_mask(request, frame, std::move(change))
                                    : change_landmarks(request, frame, std::move(change));
}

/// The frame after a request, and why nothing was done; empty where it was.
LabelAnswer LabelSession::as_it_stands(const LabelRequest& request, std::shared_ptr<const Frame> frame,
                                       std::string remark) {
  LabelAnswer answer;
  answer.remark = std::move(remark);
  answer.labelled = labelled(request.hand.frame, std::move(frame));
  return answer;
}

/// The hand's next revision, with what it has now.
LabelChange LabelSession::begun_change(const LabelRequest& request) const {
  LabelChange change{.frame = request.hand.frame,
                     .side = request.hand.side,
                     .revision = request.revision + 1,
                     .act = LabelAct::correct,
                     .author = options_.author,
                     .time = now(),
                     .seconds = request.seconds};
  change.landmarks.resize(head().convention.landmarks.size());
  if (const HandHistory* const history = journal_.book().find(request.hand)) {
    change.landmarks = history->newest().landmarks;
    change.mask = history->newest().mask;
  }
  return change;
}

/// Landmarks stay as they are, and so does what was fitted to them.
LabelAnswer LabelSession::change_mask(const LabelRequest& request, const std::shared_ptr<const Frame>& frame,
                                      LabelChange change) {
  change.act = LabelAct::brush;
  std::optional<LabelFit> fit;
  if (request.kind == LabelRequest::Kind::outline) fit = fits_.fit(request.hand, change.landmarks, *frame);
  std::string remark = edit_mask(request, *frame, fit ? &*fit : nullptr, change.mask);
  if (remark.empty() && !request.is_preview) {
    fits_.keep_unchanged(request.hand, request.revision, change.revision);
    commit(std::move(change));
  }
  return as_it_stands(request, frame, std::move(remark));
}

LabelAnswer LabelSession::change_landmarks(const LabelRequest& request,
                                           const std::shared_ptr<const Frame>& frame, LabelChange change) {
  change.act = act_of(request.kind);
  const bool verifies_mask_alone = change.act == LabelAct::verify && change.mask && !has_landmarks(change);
  if (!verifies_mask_alone) {
    std::string remark =
        edit_labels(request, *frame, head().convention, fits_.palm_mm(request.hand), change.landmarks);
    if (!remark.empty()) return as_it_stands(request, frame, std::move(remark));
  }
  LabelAnswer answer;
  const auto begin = std::chrono::steady_clock::now();
  if (request.kind == LabelRequest::Kind::place && request.uses_model)
    settle_depth(request, *frame, change.landmarks);
  const auto fit = fits_.fit(request.hand, change.landmarks, *frame);
  answer.fit_ms = milliseconds_since(begin);
  const bool moves_others = request.uses_model && change.act == LabelAct::correct;
  if (fit && moves_others) change.landmarks = with_fit(change.landmarks, *fit, LabelState::estimated);
  if (request.is_preview) {
    answer.labelled = preview(request, frame, change, fit);
  } else {
    commit_landmarks(*frame, std::move(change), fit);
    answer.labelled = labelled(request.hand.frame, frame);
  }
  return answer;
}

/// A landmark that was shown on a pixel stays on it; how deep it lies the hand model says as well, fitted to
/// all the others. Of a hidden one it alone does: the skin that is seen there is not its own.
void LabelSession::settle_depth(const LabelRequest& request, const Frame& frame,
                                std::vector<LandmarkLabel>& labels) const {
  LabelFitContext context = fits_.context_of(request.hand);
  context.left_out = request.landmark;
  const auto fit = fits_.fit(request.hand, labels, frame, context);
  if (!fit || fit->points[request.landmark].is_missing()) return;
  LandmarkLabel& label = labels[request.landmark];
  const double fitted_mm = fit->points[request.landmark].depth_mm;
  label.at.depth_mm = label.is_visible ? settled_depth_mm(label.at.depth_mm, fitted_mm) : fitted_mm;
}

/// The frame as it would stand after the change.
LabelledFrame LabelSession::preview(const LabelRequest& request, const std::shared_ptr<const Frame>& frame,
                                    const LabelChange& change, const std::optional<LabelFit>& fit) {
  LabelledFrame shown = labelled(request.hand.frame, frame);
  auto hand = std::ranges::find(shown.hands, request.hand.side, &LabelledHand::side);
  if (hand == shown.hands.end())
    hand = shown.hands.insert(shown.hands.end(), LabelledHand{.side = request.hand.side});
  hand->landmarks = change.landmarks;
  hand->fit = fit;
  return shown;
}

/// Bones are learned from a hand that is verified, or forgotten where it was; its neighbours follow it.
void LabelSession::commit_landmarks(const Frame& frame, LabelChange change,
                                    const std::optional<LabelFit>& fit) {
  const HandKey hand{change.frame, change.side};
  if (fit) fits_.keep(hand, change.revision, *fit);
  const HandHistory* const history = journal_.book().find(hand);
  const bool was_verified = history != nullptr && history->state() == LabelState::verified;
  const bool is_verify = change.act == LabelAct::verify;
  commit(std::move(change));
  if (is_verify || was_verified) fits_.learn_bones(hand, frame);
  if (is_verify) to_propagate_.add_neighbours(hand, journal_.book());
}

LabelAnswer LabelSession::step_back(LabelAct act) {
  LabelAnswer answer;
  std::optional<LabelChange> change;
  {
    const std::lock_guard lock(mutex_);
    change = change_back(act);
  }
  if (!change) {
    answer.is_refused = true;
    answer.remark = act == LabelAct::undo ? "There is nothing to undo." : "There is nothing to redo.";
    return answer;
  }
  const HandKey hand{change->frame, change->side};
  const auto frame = frames_.read(hand.frame);
  const std::lock_guard lock(mutex_);
  change = change_back(act);
  if (!change || HandKey{change->frame, change->side} != hand) {
    answer.is_refused = true;
    answer.remark = "The labels were changed elsewhere meanwhile; try again.";
    answer.labelled = labelled(hand.frame, frame);
    return answer;
  }
  change->author = options_.author;
  change->time = now();
  commit(std::move(*change));
  fits_.learn_bones(hand, *frame);
  answer.labelled = labelled(hand.frame, frame);
  return answer;
}

std::optional<LabelChange> LabelSession::change_back(LabelAct act) const {
  return act == LabelAct::undo ? journal_.book().undone() : journal_.book().redone();
}

void LabelSession::commit(LabelChange change) {
  const HandKey hand{change.frame, change.side};
  const std::int64_t revision = change.revision;
  journal_.add(std::move(change));
  earlier_.take(hand);
  looked_at_.insert(hand.frame);
  if (changed) changed(hand, revision);
}

}  // namespace knuckle
