// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "knuckle/data/frame_source.h"
#include "knuckle/label/earlier_hands.h"
#include "knuckle/label/fitted_hands.h"
#include "knuckle/label/frame_cache.h"
#include "knuckle/label/frame_standing.h"
#include "knuckle/label/label_estimate.h"
#include "knuckle/label/label_journal.h"
#include "knuckle/label/label_request.h"
#include "knuckle/label/propagation_queue.h"

namespace knuckle {

/// One hand of a frame as it stands.
struct LabelledHand {
  HandSide side = HandSide::right;
  std::int64_t revision = 0;
  LabelState state = LabelState::estimated;
  std::vector<LandmarkLabel> landmarks = {};   ///< one per landmark of the convention
  std::optional<LabelFit> fit = {};            ///< of the hand model, where it was fitted
  std::shared_ptr<const LabelMask> mask = {};  ///< null: nobody has painted it
  double seconds = 0.0;                        ///< that persons have worked on it
  std::string author = {};                     ///< of the newest change
  std::string time = {};
};

/// A frame with its labels.
struct LabelledFrame {
  std::int64_t index = 0;
  std::shared_ptr<const Frame> frame;
  std::vector<LabelledHand> hands;  ///< right before left
};

/// What came of a request.
struct LabelAnswer {
  LabelledFrame labelled;   ///< the request's frame as it stands, or, of a preview, as it would
  bool is_refused = false;  ///< another page or program has changed the hand meanwhile: nothing was done
  std::string remark;       ///< why nothing was done, in a sentence; empty where it was
  double fit_ms = 0.0;      ///< that the hand model took
};

/// What a session is begun with.
struct LabelSessionOptions {
  std::string author = "someone";      ///< who works in the page
  std::string estimator = "pipeline";  ///< who `estimate` is, for the file
  EstimateHands estimate = nullptr;    ///< nothing: labelling begins from nothing
  LabelFitOptions fit = {};
  int reach = 20;                    ///< frames to both sides that a verified one pulls, [0, 100]
  std::function<std::string()> now;  ///< the time of day for the file; not set: the clock's
};

/// Labelling of one source by one author: frames at random access, changes with the hand model's help, labels
/// that follow from verified neighbours, what to look at next. All that changes goes through the journal.
/// Safe to call from many threads; `follow`, `prepare` and `work` are meant for one that has time.
class LabelSession {
 public:
  /// The source and the journal have to live as long.
  LabelSession(const FrameSource& source, LabelJournal& journal, LabelSessionOptions options);
  ~LabelSession();
  LabelSession(const LabelSession&) = delete;
  LabelSession& operator=(const LabelSession&) = delete;

  const LabelHead& head() const { return journal_.book().head(); }

  /// A frame with its labels; the first time it is estimated, where there is an estimator, or waited for
  /// where another thread is at it. Throws an Error where there is no such frame or it cannot be read.
  LabelledFrame frame(std::int64_t index);
  /// The images alone. Throws an Error as `frame` does.
  std::shared_ptr<const Frame> image(std::int64_t index) { return frames_.read(index); }
  /// Does what a person asks for. Throws an Error where the frame cannot be read.
  LabelAnswer apply(const LabelRequest& request);

  /// One per frame of the source.
  std::vector<FrameStanding> standings() const;
  /// As `proposed_frame` says.
  std::optional<std::int64_t> proposed(std::int64_t after) const;
  /// Hands that were verified, and the seconds that persons worked on them, one per hand.
  std::vector<double> seconds_of_verified() const;

  /// Does a piece of what follows from changes: writes what waits for the disk, or lets a frame follow its
  /// verified neighbours. Whether a frame was there to follow. Changed frames are told to `changed`.
  bool follow();
  /// Does a piece of what nobody has asked for yet: fits the hand model to a hand of an earlier session, or
  /// estimates a frame. Whether there was anything to do. Changed frames are told to `changed`.
  bool prepare();
  /// Does a piece of any of it. Whether there was anything to do.
  bool work() { return follow() || prepare(); }
  /// Called after each change, and once it is known how doubtful a hand of an earlier session is, by the
  /// thread that made it, which holds the session: it may not ask it.
  std::function<void(HandKey, std::int64_t)> changed;
  /// Why labels are not on the disk; empty where they are. `waiting` says how many changes.
  std::string fault() const;
  std::size_t waiting() const;

 private:
  LabelledFrame labelled(std::int64_t index, std::shared_ptr<const Frame> frame);
  LabelledHand labelled_hand(HandKey hand, const HandHistory& history, const Frame& frame);
  LabelAnswer as_it_stands(const LabelRequest& request, std::shared_ptr<const Frame> frame,
                           std::string remark);

  LabelAnswer change_hand(const LabelRequest& request, const std::shared_ptr<const Frame>& frame);
  LabelChange begun_change(const LabelRequest& request) const;
  LabelAnswer change_mask(const LabelRequest& request, const std::shared_ptr<const Frame>& frame,
                          LabelChange change);
  LabelAnswer change_landmarks(const LabelRequest& request, const std::shared_ptr<const Frame>& frame,
                               LabelChange change);
  void settle_depth(const LabelRequest& request, const Frame& frame,
                    std::vector<LandmarkLabel>& labels) const;
  LabelledFrame preview(const LabelRequest& request, const std::shared_ptr<const Frame>& frame,
                        const LabelChange& change, const std::optional<LabelFit>& fit);
  void commit_landmarks(const Frame& frame, LabelChange change, const std::optional<LabelFit>& fit);
  LabelAnswer step_back(LabelAct act);
  std::optional<LabelChange> change_back(LabelAct act) const;
  void commit(LabelChange change);

  void estimate(std::int64_t index, const Frame& frame);
  bool begins_to_estimate(std::int64_t index);
  void end_of_estimate(std::int64_t index);
  void keep_estimate(std::int64_t index, const Frame& frame);
  bool estimate_one();
  bool propagate_one();
  bool recall_one();
  void recall(HandKey hand);
  bool follows(HandKey hand) const;
  void recall_verified_around(HandKey hand);
  void take_back(HandKey hand, const Frame& frame);
  void propagate(HandKey hand, const Frame& frame);
  std::string now() const;

  LabelJournal& journal_;
  LabelSessionOptions options_;
  mutable std::mutex mutex_;
  FrameCache frames_;
  FittedHands fits_;
  PropagationQueue to_propagate_;
  EarlierHands earlier_;
  bool has_interrupted_ = true;       ///< what waited in an earlier session was not looked for yet
  std::set<std::int64_t> looked_at_;  ///< frames that were estimated, also in vain
  std::set<std::int64_t> being_estimated_;
  std::condition_variable estimated_;  ///< a frame was
  std::int64_t next_estimate_ = 0;
};

}  // namespace knuckle
