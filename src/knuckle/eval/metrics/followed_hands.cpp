// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/followed_hands.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/statistics.h"
#include "knuckle/data/readers/line_index.h"
#include "knuckle/eval/metrics/occlusion_count.h"

namespace knuckle {
namespace {

/// A true hand's landmarks and an estimate's, where both know them.
struct Comparison {
  double apart_mm = kNaN;  ///< of the means
  RunningMean error_mm;
};

Comparison compared(const TrueHand& truth, const HandRecord& estimate, std::span<const int> places) {
  Comparison comparison;
  Point3 sum = Point3::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i] < 0) continue;
    const Eigen::Vector3d error = estimate.landmarks_mm[places[i]] - truth.landmarks_mm[i];
    if (!error.allFinite()) continue;
    sum += error;
    comparison.error_mm.add(error.norm());
  }
  if (comparison.error_mm.count > 0) comparison.apart_mm = sum.norm() / comparison.error_mm.count;
  return comparison;
}

struct Match {
  std::size_t hand = 0;
  std::size_t estimate = 0;
  Comparison comparison;
};

/// Pairs that are near enough, each hand and estimate in one at most, nearest first.
std::vector<Match> matches_of(const TrueHands& truth, const FrameRecord& record,
                              const Convention& convention) {
  std::vector<Match> near;
  for (std::size_t j = 0; j < record.hands.size(); ++j) {
    const auto mapping = map_convention(record.hands[j].convention, convention);
    for (std::size_t i = 0; i < truth.hands.size(); ++i) {
      const Comparison comparison = compared(truth.hands[i], record.hands[j], mapping.source_index);
      if (comparison.apart_mm <= kFoundMm) near.push_back({i, j, comparison});
    }
  }
  std::ranges::stable_sort(near, {}, [](const Match& match) { return match.comparison.apart_mm; });
  std::vector<Match> matches;
  for (const Match& match : near) {
    const bool is_taken = std::ranges::any_of(matches, [&](const Match& other) {
      return other.hand == match.hand || other.estimate == match.estimate;
    });
    if (!is_taken) matches.push_back(match);
  }
  return matches;
}

/// A hand of a sequence: its side, and how many of that side come before it in the frame's list.
using HandKey = std::pair<HandSide, int>;

std::vector<HandKey> keys_of(const TrueHands& truth) {
  std::map<HandSide, int> counts;
  std::vector<HandKey> keys;
  for (const TrueHand& hand : truth.hands) keys.emplace_back(hand.side, counts[hand.side]++);
  return keys;
}

/// What is known of a hand from the frames before.
struct FollowedHand {
  std::optional<int> id;  ///< that it was found with last
  std::int64_t lost = 0;  ///< frames since it should have been found
};

class FollowedCount {
 public:
  explicit FollowedCount(FollowedScore& score) : score_(score) {}

  void add(const TrueHands& truth, const FrameRecord& record, const Convention& convention) {
    if (truth.sequence != sequence_) hands_.clear();
    sequence_ = truth.sequence;
    ++score_.frames;
    const std::vector<Match> matches = matches_of(truth, record, convention);
    score_.invented += std::ssize(record.hands) - std::ssize(matches);
    const std::vector<HandKey> keys = keys_of(truth);
    for (std::size_t i = 0; i < truth.hands.size(); ++i) {
      const auto match = std::ranges::find(matches, i, &Match::hand);
      const bool counts = truth.hands[i].visible_share >= kLeastVisible;
      if (counts) ++score_.hands;
      if (match == matches.end()) {
        if (counts) ++hands_[keys[i]].lost;
      } else {
        see(hands_[keys[i]], truth.hands[i], record.hands[match->estimate], counts ? &*match : nullptr);
        if (counts) add_landmarks(truth.hands[i], record.hands[match->estimate], convention);
      }
    }
  }

  double mean_3d_mm() const { return error_mm_.count > 0 ? error_mm_.value() : kNaN; }
  OcclusionScores occlusion() const { return occlusion_.scores(); }

 private:
  void see(FollowedHand& hand, const TrueHand& truth, const HandRecord& estimate, const Match* counted) {
    if (hand.id && *hand.id != estimate.id) ++score_.switches;
    hand.id = estimate.id;
    if (hand.lost > 0) {
      ++score_.losses;
      score_.longest_loss = std::max(score_.longest_loss, hand.lost);
      hand.lost = 0;
    }
    if (counted == nullptr) return;
    ++score_.found;
    score_.right_side += estimate.side == truth.side ? 1 : 0;
    error_mm_.add(counted->comparison.error_mm.value());
  }

  void add_landmarks(const TrueHand& truth, const HandRecord& estimate, const Convention& convention) {
    occlusion_.add(truth, estimate, map_convention(estimate.convention, convention).source_index);
  }

  FollowedScore& score_;
  RunningMean error_mm_;
  OcclusionCount occlusion_;
  std::map<HandKey, FollowedHand> hands_;
  int sequence_ = 0;
};

/// Whether the middle of a hand's landmarks lies in the image.
bool is_in_image(const HandPose& pose, const Camera& camera) {
  const ImagePoint middle = mean_joint(pose);
  return middle.u >= -0.5 && middle.u < camera.width - 0.5 && middle.v >= -0.5 &&
         middle.v < camera.height - 0.5;
}

std::vector<Point3> in_camera(const HandPose& pose, const Projection& projection) {
  std::vector<Point3> points;
  points.reserve(pose.joints.size());
  for (const ImagePoint& joint : pose.joints) points.push_back(projection.to_camera(joint));
  return points;
}

}  // namespace

FollowedScore followed_score(const std::string& name, const Convention& convention,
                             std::span<const TrueHands> truth, std::span<const FrameRecord> records) {
  if (truth.size() != records.size()) {
    fail("{}: {} records, expected one for each of {} frames", name, records.size(), truth.size());
  }
  FollowedScore score;
  score.name = name;
  FollowedCount count(score);
  for (std::size_t i = 0; i < truth.size(); ++i) count.add(truth[i], records[i], convention);
  score.mean_3d_mm = count.mean_3d_mm();
  score.occlusion = count.occlusion();
  score.reliability = reliability_of(convention, truth, records);
  return score;
}

std::vector<TrueHands> true_hands(const FrameSource& source) {
  if (!source.convention()) fail("the source has no truth to score hands against");
  std::vector<TrueHands> all(static_cast<std::size_t>(source.size()));
  parallel_for(source.size(), [&](std::int64_t i) {
    const Frame frame = source.read(i);
    const Projection projection(frame.camera);
    TrueHands& truth = all[static_cast<std::size_t>(i)];
    truth.sequence = frame.sequence;
    const auto add = [&](const HandTruth& hand) {
      const double share = is_in_image(hand.pose, frame.camera) ? hand.visible_share : 0.0;
      truth.hands.push_back({hand.side, in_camera(hand.pose, projection), share, hand.occluders});
    };
    for (const HandTruth& hand : frame.hands) add(hand);
    if (frame.hands.empty() && frame.truth)
      add({frame.side.value_or(HandSide::right), *frame.truth, {}, 1.0});
    std::erase_if(truth.hands, [](const TrueHand& hand) {
      return std::ranges::none_of(hand.landmarks_mm, [](const Point3& point) { return point.allFinite(); });
    });
  });
  return all;
}

std::vector<FrameRecord> records_from_file(const std::filesystem::path& path, std::int64_t frames) {
  const LineIndex lines(path);
  std::vector<FrameRecord> records(static_cast<std::size_t>(frames));
  std::int64_t next = 0;
  for (std::int64_t i = 0; i < lines.size(); ++i) {
    FrameRecord record = parse_frame_record(lines.line(i), lines.where(i));
    if (record.frame < next || record.frame >= frames) {
      fail("{}: is of frame {}, expected one of {} to {}", lines.where(i), record.frame, next, frames - 1);
    }
    next = record.frame + 1;
    records[static_cast<std::size_t>(record.frame)] = std::move(record);
  }
  return records;
}

}  // namespace knuckle
