// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_session.h"

#include <ctime>
#include <utility>

#include <fmt/chrono.h>

#include "knuckle/core/error.h"
#include "knuckle/label/propagated_hand.h"

namespace knuckle {
namespace {

constexpr std::size_t kKeptFrames = 12;
constexpr int kFollowingReach = 4;            // frames on both sides that surely follow a verified one
constexpr double kDoubtBesideVerified = 0.5;  // share that is left where a hand follows

}  // namespace

LabelSession::LabelSession(const FrameSource& source, LabelJournal& journal, LabelSessionOptions options)
    : journal_(journal),
      options_(std::move(options)),
      frames_(source, kKeptFrames),
      fits_(source, journal.book(), options_.fit),
      to_propagate_(options_.reach),
      earlier_(journal.book()) {
  for (const auto& [hand, history] : journal_.book().hands()) looked_at_.insert(hand.frame);
}

LabelSession::~LabelSession() = default;

std::string LabelSession::now() const {
  return options_.now ? options_.now()
                      : fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

// --- how frames stand ---

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
                        .seconds = history.seconds(),
                        .author = newest.author,
                        .time = newest.time};
  if (const LabelFit* const fit = fits_.newest_fit(hand, history, frame)) labelled.fit = *fit;
  return labelled;
}

std::vector<FrameStanding> LabelSession::standings() const {
  const std::lock_guard lock(mutex_);
  return frame_standings(journal_.book(), fits_);
}

std::optional<std::int64_t> LabelSession::proposed(std::int64_t after) const {
  return proposed_frame(standings(), after, kFollowingReach);
}

std::vector<double> LabelSession::seconds_of_verified() const {
  const std::lock_guard lock(mutex_);
  std::vector<double> seconds;
  for (const auto& [hand, history] : journal_.book().hands()) {
    if (history.state() == LabelState::verified) seconds.push_back(history.seconds());
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

// --- what can wait ---

bool LabelSession::follow() {
  {
    const std::lock_guard lock(mutex_);
    if (journal_.waiting() > 0) journal_.flush();
  }
  return propagate_one();
}

bool LabelSession::prepare() {
  return recall_one() || estimate_one();
}

/// Whether it falls to the caller to estimate this frame. Where another thread is at it, waits for that one:
/// who opens a frame wants its labels.
bool LabelSession::begins_to_estimate(std::int64_t index) {
  std::unique_lock lock(mutex_);
  if (looked_at_.insert(index).second) return being_estimated_.insert(index).second;
  estimated_.wait(lock, [&] { return !being_estimated_.contains(index); });
  return false;
}

void LabelSession::end_of_estimate(std::int64_t index) {
  const std::lock_guard lock(mutex_);
  being_estimated_.erase(index);
  estimated_.notify_all();
}

void LabelSession::estimate(std::int64_t index, const Frame& frame) {
  if (!options_.estimate || !begins_to_estimate(index)) return;
  try {
    keep_estimate(index, frame);
  } catch (...) {
    end_of_estimate(index);
    throw;
  }
  end_of_estimate(index);
}

void LabelSession::keep_estimate(std::int64_t index, const Frame& frame) {
  const std::vector<EstimatedHand> hands = options_.estimate(frame);
  std::vector<LabelChange> changes =
      estimated_changes(index, hands, head().convention, options_.estimator, now());
  const std::lock_guard lock(mutex_);
  for (LabelChange& change : changes) {
    if (journal_.book().find({index, change.side}) == nullptr) commit(std::move(change));
  }
  labelled(index, std::make_shared<const Frame>(frame));  // how doubtful it is
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

bool LabelSession::propagate_one() {
  std::optional<HandKey> hand;
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(has_interrupted_, false)) to_propagate_.add_interrupted(journal_.book());
    hand = to_propagate_.take();
  }
  if (!hand) return false;
  try {
    const auto frame = frames_.read(hand->frame);
    estimate(hand->frame, *frame);
    recall_verified_around(*hand);
    const std::lock_guard lock(mutex_);
    propagate(*hand, *frame);
  } catch (const Error&) {  // who opens this frame is told
  }
  return true;
}

void LabelSession::propagate(HandKey hand, const Frame& frame) {
  auto propagated = propagated_hand(hand, frame, journal_.book(), fits_, options_.reach);
  if (!propagated) return;
  const HandHistory* const history = journal_.book().find(hand);
  const std::int64_t revision = history == nullptr ? 1 : history->revision() + 1;
  fits_.keep(hand, revision, propagated->fit, kDoubtBesideVerified);
  commit({.frame = hand.frame,
          .side = hand.side,
          .revision = revision,
          .act = LabelAct::propagate,
          .author = "propagation",
          .time = now(),
          .seconds = 0.0,
          .landmarks = std::move(propagated->labels)});
}

// --- what an earlier session knew ---

bool LabelSession::recall_one() {
  std::optional<HandKey> hand;
  {
    const std::lock_guard lock(mutex_);
    hand = earlier_.take();
  }
  if (hand) recall(*hand);
  return hand.has_value();
}

/// Images are read while nobody waits for them.
void LabelSession::recall(HandKey hand) {
  try {
    if (follows(hand)) recall_verified_around(hand);
    const auto frame = frames_.read(hand.frame);
    const std::lock_guard lock(mutex_);
    take_back(hand, *frame);
  } catch (const Error&) {  // who opens this frame is told
  }
}

bool LabelSession::follows(HandKey hand) const {
  const std::lock_guard lock(mutex_);
  return journal_.book().find(hand)->follows();
}

/// The verified hands that a hand follows have to be fitted before it.
void LabelSession::recall_verified_around(HandKey hand) {
  std::vector<HandKey> around;
  {
    const std::lock_guard lock(mutex_);
    around = verified_around(hand, journal_.book(), fits_, options_.reach);
    std::erase_if(around, [this](HandKey other) { return !earlier_.take(other); });
  }
  for (const HandKey other : around) recall(other);
}

/// Fits the hand model to a hand as it stands; to one that follows as when it followed.
void LabelSession::take_back(HandKey hand, const Frame& frame) {
  const HandHistory& history = *journal_.book().find(hand);
  std::optional<PropagatedHand> following;
  if (history.follows()) following = following_hand(hand, frame, journal_.book(), fits_, options_.reach);
  if (following) {
    fits_.keep(hand, history.revision(), following->fit, kDoubtBesideVerified);
  } else {
    fits_.newest_fit(hand, history, frame);
    if (history.state() == LabelState::verified) fits_.learn_bones(hand, frame);
  }
  if (changed) changed(hand, history.revision());
}

}  // namespace knuckle
