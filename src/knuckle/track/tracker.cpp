// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/statistics.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/refine/skeleton_pose.h"
#include "knuckle/refine/surface_near.h"
#include "knuckle/track/hands_apart.h"
#include "knuckle/track/one_euro_filter.h"
#include "knuckle/track/pose_smoother.h"

namespace knuckle {
namespace {

constexpr double kDefaultStepSeconds = 1.0 / 30.0;
constexpr double kLongestStepSeconds = 1.0;     // after a longer pause a hand may be anywhere
constexpr double kFastestMmPerSecond = 4000.0;  // hands hardly move faster
constexpr double kVelocityCutoffHz = 5.0;
constexpr double kReachMm = 150.0;         // of what was predicted: what is farther away is another thing
constexpr double kLostReachMm = 300.0;     // of where a hand was lost for a moment
constexpr double kSameHandMm = 40.0;       // no two hands' middles are nearer
constexpr double kNeighbourMm = 250.0;     // a hand that is nearer is in the other one's patch
constexpr double kNeighbourSeconds = 0.1;  // one that was lost for longer is not taken away
constexpr double kSkinReachMm = 15.0;      // what is seen of a hand is no farther from its fitted skin
constexpr double kPoorFitMm = 10.0;  // a fit from the last pose that is worse is compared with a fresh one
constexpr double kFingerRadPerSecond = 5.0;  // deviation of an angle's speed
constexpr int kMostSideVotes = 10;
constexpr int kMostTrust = 4;  // searches of all of a frame that found a hand where one is followed

Point3 in_mirror(const Point3& point, HandSide side) {
  return side == HandSide::left ? Point3(-point.x(), point.y(), point.z()) : point;
}

/// The estimated landmarks as targets for a right hand: a left one's in a mirror.
LandmarkTargets right_targets(const HandEstimate& estimate, const Camera& camera) {
  LandmarkTargets targets = targets_of(estimate.pose, camera);
  for (LandmarkTarget& target : targets) target.point = in_mirror(target.point, estimate.side);
  return targets;
}

/// What the frame shows near the hand, as that of a right one.
HandSurface right_surface(const Frame& frame, const HandEstimate& estimate) {
  HandSurface surface = surface_near(frame, targets_of(estimate.pose, frame.camera));
  if (estimate.side == HandSide::right) return surface;
  for (Point3& point : surface.points) point = in_mirror(point, HandSide::left);
  surface.depth_mm = [depth = std::move(surface.depth_mm)](const Point3& point) {
    return depth(in_mirror(point, HandSide::left));
  };
  return surface;
}

/// The skeleton fitted from `start` on, and from a fresh one where that ends poorly.
std::optional<SkeletonFit> fit_from(const std::optional<SkeletonPose>& start, const LandmarkTargets& targets,
                                    const SkeletonFitOptions& options, const HandSurface& surface) {
  auto fit = fit_skeleton(adult_skeleton(), targets, options, start, surface);
  if (!start || (fit && fit->rms_mm <= kPoorFitMm)) return fit;
  const auto fresh = fit_skeleton(adult_skeleton(), targets, options, std::nullopt, surface);
  return fresh && (!fit || fresh->energy < fit->energy) ? fresh : fit;
}

Point3 middle_of(const SupersetPoints& points) {
  Point3 sum = Point3::Zero();
  for (const Point3& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

/// In the camera; not finite where no joint is known.
Point3 middle_of(const HandEstimate& hand, const Frame& frame) {
  return Projection(frame.camera).to_camera(mean_joint(hand.pose));
}

/// Lets one thread in at a time.
class Turnstile {
 public:
  explicit Turnstile(std::atomic_flag& is_busy) : is_busy_(is_busy) {
    if (is_busy_.test_and_set()) fail("tracker: two threads use it at once; each needs its own");
  }
  ~Turnstile() { is_busy_.clear(); }
  Turnstile(const Turnstile&) = delete;
  Turnstile& operator=(const Turnstile&) = delete;

 private:
  std::atomic_flag& is_busy_;
};

}  // namespace

/// A person's hand as frames showed it: means of logarithms.
class Tracker::Person {
 public:
  void learn(const SkeletonPose& pose) {
    size_.add(std::log(pose.size));
    for (std::size_t i = 0; i < lengths_.size(); ++i) lengths_[i].add(std::log(pose.lengths[i / 3][i % 3]));
  }
  /// Makes what was learned known to a fit.
  void tell(SkeletonFitOptions& options) const {
    if (size_.count == 0) return;
    options.size_spread = options.length_spread = 0.0;
    options.size = std::exp(size_.value());
    for (std::size_t i = 0; i < lengths_.size(); ++i)
      options.lengths[i / 3][i % 3] = std::exp(lengths_[i].value());
  }

 private:
  RunningMean size_;
  std::array<RunningMean, 15> lengths_;
};

/// A hand that is followed, as a right one: a left one in a mirror.
struct Tracker::Track {
  Track(int number, double now_s, const TrackerOptions& options)
      : id(number), begun_s(now_s), seen_s(now_s), smoother(options) {}

  bool is_seen_at(double now_s) const { return seen_s == now_s && pose.has_value(); }
  HandSide side() const { return side_votes < 0 ? HandSide::left : HandSide::right; }
  void begin_anew(double now_s) {
    begun_s = now_s;
    pose.reset();
    smoother.reset();
    velocity.setZero();
    person = {};
  }
  void move_to(const SkeletonPose& next, double now_s);
  /// Where it was, moved by its velocity.
  Eigen::Vector3d shift_until(double now_s) const { return velocity * (now_s - seen_s); }
  HandSkin skin_at(double now_s) const;
  HandSkin forearm() const;

  int id;
  double begun_s;
  double seen_s;
  int side_votes = 0;           // above 0: right
  int trust = 0;                // how often searches of all of the frame found it, at most kMostTrust
  bool is_found_again = false;  // by the search under way
  double score = 0.0;
  std::vector<float> confidence;     // one per landmark of the 22
  std::optional<SkeletonPose> pose;  // as it was fitted
  SkeletonPose smoothed;
  PoseSmoother smoother;
  Point3 middle = Point3::Zero();                      // of its landmarks, in the camera
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // of the middle [mm/s]
  Person person;
};

void Tracker::Track::move_to(const SkeletonPose& next, double now_s) {
  const bool is_first = !pose;
  const double seconds = is_first ? kDefaultStepSeconds : now_s - seen_s;
  const Point3 next_middle = in_mirror(middle_of(landmarks(adult_skeleton(), next)), side());
  if (!is_first) {
    Eigen::Vector3d now = (next_middle - middle) / seconds;
    if (now.norm() > kFastestMmPerSecond) now *= kFastestMmPerSecond / now.norm();
    velocity += low_pass_share(kVelocityCutoffHz, seconds) * (now - velocity);
  }
  smoothed = smoother.smooth(next, seconds);
  middle = next_middle;
  pose = next;
  seen_s = now_s;
}

/// In the camera; empty where it was never fitted.
HandSkin Tracker::Track::skin_at(double now_s) const {
  if (!pose) return {};
  auto points = landmarks(adult_skeleton(), *pose);
  for (Point3& point : points) point = in_mirror(point, side()) + shift_until(now_s);
  return hand_capsules(points);
}

/// About where the forearm begins: it goes on behind the wrist, where that is not bent.
HandSkin Tracker::Track::forearm() const {
  const auto points = landmarks(adult_skeleton(), *pose);
  const Point3 wrist = in_mirror(points[static_cast<int>(Landmark::wrist)], side());
  const Point3 middle_mcp = in_mirror(points[static_cast<int>(Landmark::middle_mcp)], side());
  const Eigen::Vector3d palm = middle_mcp - wrist;
  return {{wrist, wrist - 2.0 * palm, 0.4 * palm.norm(), HandCapsule::kPalmCapsule, 0}};
}

Tracker::Tracker(const Pipeline& pipeline, const TrackerOptions& options)
    : pipeline_(pipeline), options_(options) {
  check_options(options_, "tracker");
}

Tracker::~Tracker() = default;

std::vector<TrackedHand> Tracker::update(const Frame& frame) {
  const Turnstile turnstile(is_busy_);
  step_to(frame);
  follow(frame);
  look_for_more(frame);
  forget_lost_and_doubled();
  return hands_seen(frame);
}

void Tracker::reset() {
  const Turnstile turnstile(is_busy_);
  tracks_.clear();
  next_id_ = 1;
  now_s_.reset();
  searched_s_.reset();
}

/// Takes the frame's time; forgets all hands where it does not follow the last one's.
void Tracker::step_to(const Frame& frame) {
  if (frame.time_s && !std::isfinite(*frame.time_s)) {
    fail("tracker: frame {} has a time that is not finite", frame.name);
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
  for (Track& track : tracks_) {
    const Point3 predicted = track.middle + track.shift_until(*now_s_);
    if (!(predicted.z() > 0.0)) continue;
    const std::vector<HandSkin> neighbours = skins_near(predicted, &track);
    std::optional<Frame> alone;
    if (!neighbours.empty()) alone = without_hands(frame, neighbours, track.skin_at(*now_s_), kSkinReachMm);
    const Frame& seen = alone ? *alone : frame;
    Search search{.start = predicted, .elsewhere = false, .max_hands = 1};
    FrameEstimate found = pipeline_.estimate(seen, search);
    if (!found.hands.empty() && !agree_on_side(track, found.hands.front().side)) {
      search.side = track.side();
      found = pipeline_.estimate(seen, search);
    }
    if (found.hands.empty() || !found.status.empty()) continue;
    const HandEstimate& hand = found.hands.front();
    if ((middle_of(hand, frame) - predicted).norm() <= kReachMm) take(seen, hand, track);
  }
}

/// Of the hands that are followed around `place`, but for `own`.
std::vector<HandSkin> Tracker::skins_near(const Point3& place, const Track* own) const {
  std::vector<HandSkin> skins;
  for (const Track& track : tracks_) {
    if (&track == own || *now_s_ - track.seen_s > kNeighbourSeconds) continue;
    if ((track.middle + track.shift_until(*now_s_) - place).norm() < kNeighbourMm)
      skins.push_back(track.skin_at(*now_s_));
  }
  return skins;
}

std::ptrdiff_t Tracker::seen_count() const {
  return std::ranges::count_if(tracks_, [&](const Track& track) { return track.is_seen_at(*now_s_); });
}

/// Whether all of the frame is to be searched: where a hand is missing, and now and then for more; the less
/// often, the more searches found those that are followed.
bool Tracker::is_search_due() const {
  if (tracks_.empty() || !searched_s_ || seen_count() < std::ssize(tracks_)) return true;
  const int trust = std::ranges::min_element(tracks_, {}, &Track::trust)->trust;
  return *now_s_ - *searched_s_ >= options_.search_every_s * trust / kMostTrust;
}

void Tracker::look_for_more(const Frame& frame) {
  if (!is_search_due()) return;
  searched_s_ = now_s_;
  std::vector<HandEstimate> others;
  for (HandEstimate& hand : pipeline_.estimate(frame, {.max_hands = pipeline_.hand().max_hands}).hands) {
    if (!middle_of(hand, frame).allFinite()) continue;
    if (Track* const track = seen_near(middle_of(hand, frame))) {
      track->is_found_again = true;
    } else {
      others.push_back(std::move(hand));
    }
  }
  for (Track& track : tracks_) {
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
  for (const Track& track : tracks_) {
    if (track.is_seen_at(*now_s_)) skins.push_back(track.skin_at(*now_s_));
  }
  if (missing <= 0 || skins.empty()) return;
  const Frame rest = without_hands(frame, skins, {}, kSkinReachMm);
  for (const HandEstimate& hand : pipeline_.estimate(rest, {.max_hands = missing}).hands) {
    const Point3 middle = middle_of(hand, frame);
    if (!middle.allFinite() || seen_near(middle) != nullptr || is_on_forearm(middle)) continue;
    const Track* const lost = lost_near(middle);
    if (lost != nullptr && (lost->middle - middle).norm() <= kReachMm) take_up(rest, hand);
  }
}

/// Of a hand that is seen in this frame.
bool Tracker::is_on_forearm(const Point3& place) const {
  return std::ranges::any_of(tracks_, [&](const Track& track) {
    return track.is_seen_at(*now_s_) && distance_to_skin_mm(place, track.forearm()) < 0.0;
  });
}

/// Follows what was found where no hand is followed: a hand that was lost for a moment, or a new one, where
/// there is room for it. Where there is none, the hand that is trusted least loses trust, and its place once
/// it has none left.
void Tracker::take_up(const Frame& frame, const HandEstimate& hand) {
  Track* const lost = lost_near(middle_of(hand, frame));
  if (lost != nullptr && agree_on_side(*lost, hand.side) && take(frame, hand, *lost)) return;
  Track track(next_id_, *now_s_, options_);
  if (!agree_on_side(track, hand.side) || !take(frame, hand, track)) return;
  if (seen_count() < pipeline_.hand().max_hands) {
    tracks_.push_back(std::move(track));
  } else {
    Track& doubted = *least_trusted();
    if (--doubted.trust >= 0) return;
    doubted = std::move(track);
  }
  ++next_id_;
}

/// Of the hands seen in this frame; there is one.
Tracker::Track* Tracker::least_trusted() {
  Track* least = nullptr;
  for (Track& track : tracks_) {
    if (track.is_seen_at(*now_s_) && (least == nullptr || track.trust < least->trust)) least = &track;
  }
  return least;
}

/// The nearest of the hands that are lost for a moment, or null.
Tracker::Track* Tracker::lost_near(const Point3& middle) {
  Track* nearest = nullptr;
  for (Track& track : tracks_) {
    const double distance = (track.middle - middle).norm();
    if (track.is_seen_at(*now_s_) || distance > kLostReachMm) continue;
    if (nearest == nullptr || distance < (nearest->middle - middle).norm()) nearest = &track;
  }
  return nearest;
}

/// The hand that is seen there in this frame, or null.
Tracker::Track* Tracker::seen_near(const Point3& middle) {
  const auto found = std::ranges::find_if(tracks_, [&](const Track& track) {
    return track.is_seen_at(*now_s_) && (track.middle - middle).norm() < 2.0 * kSameHandMm;
  });
  return found == tracks_.end() ? nullptr : &*found;
}

/// Counts an estimate's side. False where most estimates before saw the other one.
bool Tracker::agree_on_side(Track& track, HandSide side) const {
  const HandSide before = track.side();
  track.side_votes =
      std::clamp(track.side_votes + (side == HandSide::right ? 1 : -1), -kMostSideVotes, kMostSideVotes);
  if (side != track.side()) return false;
  if (before != side) track.begin_anew(*now_s_);  // it was the other hand all the time
  return true;
}

/// Moves a track on to an estimate of its side. False where that says nothing of the hand: too few
/// landmarks, or a hand that is not plausible.
bool Tracker::take(const Frame& frame, const HandEstimate& estimate, Track& track) const {
  const LandmarkTargets targets = right_targets(estimate, frame.camera);
  Person person = track.person;
  const std::optional<SkeletonFit> fit = fit_of(targets, right_surface(frame, estimate), track, person);
  if (!fit) return false;
  const double score = estimate.score * plausibility_of(*fit);
  if (score < pipeline_.hand().sure_confidence) return false;
  track.person = person;
  track.move_to(fit->pose, *now_s_);
  track.score = score;
  track.confidence.assign(targets.size(), 0.0f);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (targets[i].point.allFinite()) track.confidence[i] = static_cast<float>(targets[i].weight);
  }
  return true;
}

/// The skeleton fitted to the frame from the track's last pose on, of the size and proportions that were
/// learned. While they are, each frame is asked for its own first, so that none is taken for what the first
/// ones said.
std::optional<SkeletonFit> Tracker::fit_of(const LandmarkTargets& targets, const HandSurface& surface,
                                           const Track& track, Person& person) const {
  SkeletonFitOptions options;
  if (track.pose) {
    options.expected = track.pose->angles;
    options.expected_rad = kFingerRadPerSecond * (*now_s_ - track.seen_s);
  }
  std::optional<SkeletonPose> start = track.pose;
  if (*now_s_ - track.begun_s <= options_.learn_s) {
    const auto fit = fit_from(start, targets, options, surface);
    if (!fit) return std::nullopt;
    person.learn(fit->pose);
    start = fit->pose;
  }
  person.tell(options);
  return fit_from(start, targets, options, surface);
}

void Tracker::forget_lost_and_doubled() {
  std::erase_if(tracks_, [&](const Track& track) { return *now_s_ - track.seen_s > options_.lost_after_s; });
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    for (std::size_t j = tracks_.size() - 1; j > i; --j) {  // the older one stays
      if ((tracks_[i].middle - tracks_[j].middle).norm() < kSameHandMm) {
        tracks_.erase(tracks_.begin() + static_cast<std::ptrdiff_t>(j));
      }
    }
  }
}

std::vector<TrackedHand> Tracker::hands_seen(const Frame& frame) const {
  std::vector<TrackedHand> hands;
  const Projection projection(frame.camera);
  for (const Track& track : tracks_) {
    if (!track.is_seen_at(*now_s_)) continue;
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
    const auto points = landmarks(adult_skeleton(), track.smoothed);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (points[i].z() > 0.0) hand.pose.joints[i] = projection.to_image(in_mirror(points[i], hand.side));
    }
    hands.push_back(std::move(hand));
  }
  return hands;
}

}  // namespace knuckle
