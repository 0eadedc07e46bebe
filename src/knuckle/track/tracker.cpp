// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/tracker.h"

#include <algorithm>
#include <cmath>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/data/defined_pose.h"
#include "knuckle/hand/adult_skeleton.h"

namespace knuckle {
namespace {

constexpr double kDefaultStep_s = 1.0 / 30.0;
constexpr double kLongestStep_s = 1.0;   // after a longer pause a hand may be anywhere
constexpr double kFastestMm_s = 4000.0;  // hands hardly move faster
constexpr double kVelocityCutoffHz = 5.0;
constexpr double kReachMm = 150.0;    // of what was predicted: what is farther away is another thing
constexpr double kSameHandMm = 40.0;  // no two hands' middles are nearer
constexpr double kPoorFitMm = 10.0;   // a fit from the last pose that is worse is compared with a fresh one
constexpr int kMostSideVotes = 10;

Point3 in_mirror(const Point3& point, HandSide side) {
  return side == HandSide::left ? Point3(-point.x(), point.y(), point.z()) : point;
}

/// The estimated landmarks as targets for a right hand: a left one's in a mirror.
LandmarkTargets right_targets(const HandEstimate& estimate, const Projection& projection) {
  const SupersetPoints points = superset_points(estimate.pose, projection);
  const std::vector<float>& confidence = estimate.pose.confidence;
  LandmarkTargets targets;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    const int place = estimate.pose.convention.index_of(static_cast<Landmark>(i));
    targets[i].point = in_mirror(points[i], estimate.side);
    targets[i].weight =
        confidence.empty() ? 1.0 : static_cast<double>(confidence[static_cast<std::size_t>(place)]);
  }
  return targets;
}

Point3 middle_of(const SupersetPoints& points) {
  Point3 sum = Point3::Zero();
  for (const Point3& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

PoseSmoothing smoothing_of(const TrackerOptions& options) {
  PoseSmoothing smoothing;
  for (OneEuroOptions* const part : {&smoothing.place, &smoothing.turn, &smoothing.angles}) {
    part->rest_cutoff_hz /= options.strength;
    part->cutoff_per_speed /= options.strength;
  }
  return smoothing;
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

/// A hand that is followed, as a right one: a left one in a mirror.
struct Tracker::Track {
  Track(int number, double now_s, const TrackerOptions& options)
      : id(number), begun_s(now_s), seen_s(now_s), smoother(smoothing_of(options)) {}

  bool is_seen_at(double now_s) const { return seen_s == now_s && fit.has_value(); }
  HandSide side() const { return side_votes < 0 ? HandSide::left : HandSide::right; }
  /// The size that was learned, as a mean of logarithms.
  double learned_size() const { return size_weight == 0.0 ? 1.0 : std::exp(log_size / size_weight); }

  int id;
  double begun_s;
  double seen_s;
  int side_votes = 0;  // above 0: right
  double score = 0.0;
  std::vector<float> confidence;  // one per landmark of the 22
  std::optional<SkeletonPose> fit;
  SkeletonPose smoothed;
  PoseSmoother smoother;
  Point3 middle = Point3::Zero();                      // of its landmarks, in the camera
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // mm/s
  double log_size = 0.0;
  double size_weight = 0.0;
};

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
  const double time_s = frame.time_s.value_or(now_s_.value_or(0.0) + kDefaultStep_s);
  const double step_s = now_s_ ? time_s - *now_s_ : 0.0;
  if (frame.sequence != sequence_ || !(step_s > 0.0) || step_s > kLongestStep_s) {
    tracks_.clear();
    searched_s_.reset();
  }
  now_s_ = time_s;
  sequence_ = frame.sequence;
}

void Tracker::follow(const Frame& frame) {
  for (Track& track : tracks_) {
    const Point3 predicted = track.middle + track.velocity * (*now_s_ - track.seen_s);
    if (!(predicted.z() > 0.0)) continue;
    const FrameEstimate found =
        pipeline_.estimate(frame, {.start = predicted, .elsewhere = false, .max_hands = 1});
    if (found.hands.empty() || !found.status.empty()) continue;
    const HandEstimate& hand = found.hands.front();
    const Point3 middle = Projection(frame.camera).to_camera(mean_joint(hand.pose));
    if ((middle - predicted).norm() <= kReachMm) take(frame, hand, track);
  }
}

void Tracker::look_for_more(const Frame& frame) {
  const int most = pipeline_.hand().max_hands;
  const auto seen =
      std::ranges::count_if(tracks_, [&](const Track& track) { return track.is_seen_at(*now_s_); });
  const bool is_lost = std::ssize(tracks_) > seen || tracks_.empty();
  const bool is_due = !searched_s_ || *now_s_ - *searched_s_ >= options_.search_every_s;
  if (seen >= most || !(is_lost || is_due)) return;
  searched_s_ = now_s_;
  const FrameEstimate found = pipeline_.estimate(frame, {.max_hands = most});
  for (const HandEstimate& hand : found.hands) {
    const Point3 middle = Projection(frame.camera).to_camera(mean_joint(hand.pose));
    if (!middle.allFinite() || is_taken(middle)) continue;
    // One that is lost for a moment is taken up again where it is the nearest.
    Track* nearest = nullptr;
    for (Track& track : tracks_) {
      if (track.is_seen_at(*now_s_)) continue;
      if (nearest == nullptr || (track.middle - middle).norm() < (nearest->middle - middle).norm())
        nearest = &track;
    }
    if (nearest != nullptr && (nearest->middle - middle).norm() <= 2.0 * kReachMm &&
        take(frame, hand, *nearest))
      continue;
    const auto now_seen =
        std::ranges::count_if(tracks_, [&](const Track& track) { return track.is_seen_at(*now_s_); });
    if (now_seen >= most) return;
    Track track(next_id_, *now_s_, options_);
    if (!take(frame, hand, track)) continue;
    ++next_id_;
    tracks_.push_back(std::move(track));
  }
}

/// Whether a hand that is seen in this frame is there.
bool Tracker::is_taken(const Point3& centre) const {
  return std::ranges::any_of(tracks_, [&](const Track& track) {
    return track.is_seen_at(*now_s_) && (track.middle - centre).norm() < 2.0 * kSameHandMm;
  });
}

/// Fits the track's skeleton to an estimate. False where that says nothing of the hand: too few landmarks, or
/// the other side than most estimates before.
bool Tracker::take(const Frame& frame, const HandEstimate& estimate, Track& track) const {
  const int vote = estimate.side == HandSide::right ? 1 : -1;
  const HandSide before = track.side();
  track.side_votes = std::clamp(track.side_votes + vote, -kMostSideVotes, kMostSideVotes);
  const bool is_first = !track.fit;
  if (estimate.side != track.side()) return false;
  if (!is_first && before != track.side()) {  // it was the other hand all the time
    track.fit.reset();
    track.smoother.reset();
  }
  const Projection projection(frame.camera);
  const LandmarkTargets targets = right_targets(estimate, projection);
  const bool is_learning = *now_s_ - track.begun_s <= options_.learn_s;
  const HandSkeleton skeleton =
      is_learning ? adult_skeleton() : scaled(adult_skeleton(), track.learned_size());
  SkeletonFitOptions options;
  if (!is_learning) options.size_spread = 0.0;
  std::optional<SkeletonPose> start = track.fit;
  if (start && !is_learning) start->size = 1.0;
  auto fit = fit_skeleton(skeleton, targets, options, start);
  if (start && (!fit || fit->rms_mm > kPoorFitMm)) {
    const auto fresh = fit_skeleton(skeleton, targets, options);
    if (fresh && (!fit || fresh->energy < fit->energy)) fit = fresh;
  }
  if (!fit) return false;
  SkeletonPose pose = fit->pose;
  if (is_learning) {
    track.log_size += std::log(pose.size);
    track.size_weight += 1.0;
  }
  pose.size = is_learning ? pose.size : track.learned_size();
  const double seconds = is_first ? kDefaultStep_s : *now_s_ - track.seen_s;
  track.smoothed = options_.smoothing == "none" ? pose : track.smoother.smooth(pose, std::max(seconds, 1e-6));
  const Point3 middle = in_mirror(middle_of(landmarks(adult_skeleton(), pose)), track.side());
  if (!is_first && seconds > 0.0) {
    Eigen::Vector3d velocity = (middle - track.middle) / seconds;
    if (velocity.norm() > kFastestMm_s) velocity *= kFastestMm_s / velocity.norm();
    track.velocity += low_pass_share(kVelocityCutoffHz, seconds) * (velocity - track.velocity);
  }
  track.middle = middle;
  track.fit = pose;
  track.seen_s = *now_s_;
  track.score = estimate.score;
  track.confidence.assign(targets.size(), 0.0f);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (targets[i].point.allFinite()) track.confidence[i] = static_cast<float>(targets[i].weight);
  }
  return true;
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
