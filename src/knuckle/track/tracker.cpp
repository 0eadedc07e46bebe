// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/pipeline/calibrated_confidence.h"
#include "knuckle/refine/skeleton_pose.h"
#include "knuckle/track/hand_track.h"
#include "knuckle/track/hand_track_fit.h"
#include "knuckle/track/hands_apart.h"

namespace knuckle {
namespace {

constexpr double kLongestStepSeconds = 1.0;  // after a longer pause a hand may be anywhere
constexpr double kReachMm = 150.0;           // of what was predicted: what is farther away is another thing
constexpr double kLostReachMm = 300.0;       // of where a hand was lost for a moment
constexpr double kSameHandMm = 40.0;         // no two hands' middles are nearer
constexpr double kNeighbourMm = 250.0;       // a hand that is nearer is in the other one's patch
constexpr double kNeighbourSeconds = 0.1;    // one that was lost for longer is not taken away
constexpr double kSkinReachMm = 15.0;        // what is seen of a hand is no farther from its fitted skin
constexpr int kMostTrust = 4;  // searches of all of a frame that found a hand where one is followed

/// The hand as it was smoothed.
TrackedHand tracked(const HandTrack& track, const Projection& projection, const HandOptions& options) {
  TrackedHand hand;
  hand.id = track.id;
  hand.side = track.side();
  hand.score = track.score;
  hand.angles = track.smoothed.angles;
  hand.camera_from_hand = track.smoothed.camera_from_hand;
  hand.size = track.smoothed.size;
  hand.lengths = track.smoothed.lengths;
  hand.pose = HandPose::missing(superset_convention());
  hand.pose.confidence = track.confidence;
  calibrate(hand.pose.confidence, options);
  const auto points = landmarks(adult_skeleton(), track.smoothed);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].z() > 0.0) hand.pose.joints[i] = projection.to_image(in_mirror(points[i], hand.side));
  }
  return hand;
}

/// In the camera; not finite where no joint is known.
Point3 middle_of(const HandEstimate& hand, const Frame& frame) {
  return Projection(frame.camera).to_camera(mean_joint(hand.pose));
}

/// Lets one thread in at a time, and that once.
class Turnstile {
 public:
  explicit Turnstile(std::atomic<std::thread::id>& user) : user_(user) {
    std::thread::id before;
    if (user_.compare_exchange_strong(before, std::this_thread::get_id())) return;
    if (before == std::this_thread::get_id())
      fail("tracker: is called by its own pipeline's estimator, before it has done with the last frame");
    fail("tracker: two threads use it at once; each needs its own");
  }
  ~Turnstile() { user_ = std::thread::id(); }
  Turnstile(const Turnstile&) = delete;
  Turnstile& operator=(const Turnstile&) = delete;

 private:
  std::atomic<std::thread::id>& user_;
};

std::string words_for(const Frame& frame) {
  return frame.name.empty() ? "a frame" : "frame " + frame.name;
}

}  // namespace

Tracker::Tracker(const Pipeline& pipeline, const TrackerOptions& options)
    : pipeline_(pipeline), options_(options) {
  check_options(options_, "tracker");
}

Tracker::~Tracker() = default;

std::vector<TrackedHand> Tracker::update(const Frame& frame) {
  const Turnstile turnstile(user_);
  step_to(frame);
  follow(frame);
  look_for_more(frame);
  forget_and_part();
  return hands_seen(frame);
}

void Tracker::reset() {
  const Turnstile turnstile(user_);
  tracks_.clear();
  next_id_ = 1;
  now_s_.reset();
  searched_s_.reset();
}

/// Takes the frame's time; forgets all hands where it does not follow the last one's.
void Tracker::step_to(const Frame& frame) {
  if (frame.time_s && !std::isfinite(*frame.time_s)) {
    fail("tracker: {} has a time that is not finite", words_for(frame));
  }
  const double time_s = frame.time_s.value_or(now_s_.value_or(0.0) + kDefaultStepSeconds);
  const double step_s = now_s_ ? time_s - *now_s_ : 0.0;
  if (frame.sequence != sequence_ || !(step_s > 0.0) || step_s > kLongestStepSeconds) {
    tracks_.clear();
    searched_s_.reset();
  }
  now_s_ = time_s;
  sequence_ = frame.sequence;
}

void Tracker::follow(const Frame& frame) {
  for (HandTrack& track : tracks_) {
    const Point3 predicted = track.middle + track.shift_until(*now_s_);
    if (!(predicted.z() > 0.0)) continue;
    const std::vector<HandSkin> neighbours = skins_near(predicted, &track);
    std::optional<Frame> alone;
    if (!neighbours.empty()) alone = without_hands(frame, neighbours, track.skin_at(*now_s_), kSkinReachMm);
    const Frame& seen = alone ? *alone : frame;
    Search search{.start = predicted, .elsewhere = false, .max_hands = 1, .calibrate = false};
    FrameEstimate found = pipeline_.estimate(seen, search);
    if (!found.hands.empty() && !track.agree_on_side(found.hands.front().side, *now_s_)) {
      search.side = track.side();
      found = pipeline_.estimate(seen, search);
    }
    if (found.hands.empty() || !found.status.empty()) continue;
    const HandEstimate& hand = found.hands.front();
    if ((middle_of(hand, frame) - predicted).norm() <= kReachMm) take(seen, hand, track);
  }
}

/// Of the hands that are followed around `place`, but for `own`.
std::vector<HandSkin> Tracker::skins_near(const Point3& place, const HandTrack* own) const {
  std::vector<HandSkin> skins;
  for (const HandTrack& track : tracks_) {
    if (&track == own || *now_s_ - track.seen_s > kNeighbourSeconds) continue;
    if ((track.middle + track.shift_until(*now_s_) - place).norm() < kNeighbourMm)
      skins.push_back(track.skin_at(*now_s_));
  }
  return skins;
}

std::ptrdiff_t Tracker::seen_count() const {
  return std::ranges::count_if(tracks_, [&](const HandTrack& track) { return track.is_seen_at(*now_s_); });
}

/// Whether all of the frame is to be searched: where a hand is missing, and now and then for more; the less
/// often, the more searches found those that are followed.
bool Tracker::is_search_due() const {
  if (tracks_.empty() || !searched_s_ || seen_count() < std::ssize(tracks_)) return true;
  const int trust = std::ranges::min_element(tracks_, {}, &HandTrack::trust)->trust;
  return *now_s_ - *searched_s_ >= options_.search_every_s * trust / kMostTrust;
}

void Tracker::look_for_more(const Frame& frame) {
  if (!is_search_due()) return;
  searched_s_ = now_s_;
  FrameEstimate found = pipeline_.estimate(
      frame, {.max_hands = pipeline_.hand().max_hands, .known = middles_seen(), .calibrate = false});
  for (const HandRegion& region : found.known) {
    if (HandTrack* const track = seen_near(region.centre)) track->is_found_again = true;
  }
  std::vector<HandEstimate> others;
  for (HandEstimate& hand : found.hands) {
    const Point3 middle = middle_of(hand, frame);
    if (!middle.allFinite()) continue;
    if (HandTrack* const track = seen_near(middle)) {
      track->is_found_again = true;
    } else {
      others.push_back(std::move(hand));
    }
  }
  for (HandTrack& track : tracks_) {
    if (std::exchange(track.is_found_again, false)) track.trust = std::min(track.trust + 1, kMostTrust);
  }
  for (const HandEstimate& hand : others) take_up(frame, hand);
  if (others.empty() && seen_count() < std::ssize(tracks_)) look_beside_hands(frame);
}

/// A hand close to one that is followed is often taken for a part of it. One that was lost there is looked
/// for without that one; a new one is not: an arm without its hand looks too much like one.
void Tracker::look_beside_hands(const Frame& frame) {
  const int missing = pipeline_.hand().max_hands - static_cast<int>(seen_count());
  std::vector<HandSkin> skins;
  for (const HandTrack& track : tracks_) {
    if (track.is_seen_at(*now_s_)) skins.push_back(track.skin_at(*now_s_));
  }
  if (missing <= 0 || skins.empty()) return;
  const Frame rest = without_hands(frame, skins, {}, kSkinReachMm);
  for (const HandEstimate& hand :
       pipeline_.estimate(rest, {.max_hands = missing, .calibrate = false}).hands) {
    const Point3 middle = middle_of(hand, frame);
    if (!middle.allFinite() || seen_near(middle) != nullptr || is_on_forearm(middle)) continue;
    const HandTrack* const lost = lost_near(middle);
    if (lost != nullptr && (lost->middle - middle).norm() <= kReachMm) take_up(rest, hand);
  }
}

/// Of a hand that is seen in this frame.
bool Tracker::is_on_forearm(const Point3& place) const {
  return std::ranges::any_of(tracks_, [&](const HandTrack& track) {
    return track.is_seen_at(*now_s_) && distance_to_skin_mm(place, track.forearm()) < 0.0;
  });
}

/// Follows what was found where no hand is followed: a hand that was lost for a moment, or a new one, where
/// there is room for it. Where there is none, the hand that is trusted least loses trust, and its place once
/// it has none left.
void Tracker::take_up(const Frame& frame, const HandEstimate& hand) {
  HandTrack* const lost = lost_near(middle_of(hand, frame));
  if (lost != nullptr && lost->agree_on_side(hand.side, *now_s_) && take(frame, hand, *lost)) return;
  HandTrack track(next_id_, *now_s_, options_);
  if (!track.agree_on_side(hand.side, *now_s_) || !take(frame, hand, track)) return;
  if (seen_count() < pipeline_.hand().max_hands) {
    tracks_.push_back(std::move(track));
  } else {
    HandTrack& doubted = *least_trusted();
    if (--doubted.trust >= 0) return;
    doubted = std::move(track);
  }
  ++next_id_;
}

/// Of the hands seen in this frame; there is one.
HandTrack* Tracker::least_trusted() {
  HandTrack* least = nullptr;
  for (HandTrack& track : tracks_) {
    if (track.is_seen_at(*now_s_) && (least == nullptr || track.trust < least->trust)) least = &track;
  }
  return least;
}

/// The nearest of the hands that are lost for a moment, or null.
HandTrack* Tracker::lost_near(const Point3& middle) {
  HandTrack* nearest = nullptr;
  for (HandTrack& track : tracks_) {
    const double distance = (track.middle - middle).norm();
    if (track.is_seen_at(*now_s_) || distance > kLostReachMm) continue;
    if (nearest == nullptr || distance < (nearest->middle - middle).norm()) nearest = &track;
  }
  return nearest;
}

std::vector<Point3> Tracker::middles_seen() const {
  std::vector<Point3> middles;
  for (const HandTrack& track : tracks_) {
    if (track.is_seen_at(*now_s_)) middles.push_back(track.middle);
  }
  return middles;
}

/// The hand that is seen there in this frame, or null.
HandTrack* Tracker::seen_near(const Point3& middle) {
  const auto found = std::ranges::find_if(tracks_, [&](const HandTrack& track) {
    return track.is_seen_at(*now_s_) && (track.middle - middle).norm() < 2.0 * kSameHandMm;
  });
  return found == tracks_.end() ? nullptr : &*found;
}

/// Moves a track on to an estimate of its side, or, where that would have the hand turned faster than hands
/// turn, to what the frame shows where the hand was. False where that says nothing of the hand: too few
/// landmarks, or a hand that is not plausible.
bool Tracker::take(const Frame& frame, const HandEstimate& estimate, HandTrack& track) const {
  const RightHandSight sight = right_hand_sight(frame, estimate);
  PersonHand person = track.person;
  auto fit = fit_track(track, sight, *now_s_, options_.learn_s, person);
  if (!fit) return false;
  const bool agrees = !turns_too_fast(track, fit->pose, *now_s_);
  if (!agrees) {
    if (const auto held = fit_where_it_was(track, *fit, frame, *now_s_)) {
      fit = held;
      person = track.person;
    }
  }
  const double score = estimate.score * plausibility_of(*fit);
  if (score < pipeline_.hand().sure_confidence) return false;
  track.move_to(fit->pose, *now_s_);
  track.person = person;
  if (agrees) {
    track.agreed_s = *now_s_;
    track.agreed_turn = fit->pose.camera_from_hand.linear();
  }
  track.score = score;
  track.confidence.assign(sight.targets.size(), 0.0f);
  for (std::size_t i = 0; i < sight.targets.size(); ++i) {
    const LandmarkTarget& target = sight.targets[i];
    if (target.point.allFinite()) track.confidence[i] = static_cast<float>(target.weight);
  }
  return true;
}

/// Two tracks that end at one hand have been taken to it by one hand passing the other: the one that leapt
/// there goes back, and is lost.
void Tracker::forget_and_part() {
  const auto leapt = [](const HandTrack& one, const HandTrack& other) {
    return std::pair(one.leapt_mm, one.id) > std::pair(other.leapt_mm, other.id);
  };
  for (HandTrack& one : tracks_) {
    for (const HandTrack& other : tracks_) {
      if (!one.is_seen_at(*now_s_) || !other.is_seen_at(*now_s_) || !leapt(one, other)) continue;
      if ((one.middle - other.middle).norm() < kSameHandMm) one.take_back();
    }
  }
  std::erase_if(tracks_,
                [&](const HandTrack& track) { return *now_s_ - track.seen_s > options_.lost_after_s; });
}

std::vector<TrackedHand> Tracker::hands_seen(const Frame& frame) const {
  std::vector<TrackedHand> hands;
  const Projection projection(frame.camera);
  for (const HandTrack& track : tracks_) {
    if (track.is_seen_at(*now_s_)) hands.push_back(tracked(track, projection, pipeline_.hand()));
  }
  return hands;
}

}  // namespace knuckle
