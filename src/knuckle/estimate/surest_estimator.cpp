// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/surest_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "knuckle/core/angle.h"
#include "knuckle/core/error.h"
#include "knuckle/core/likelihood.h"
#include "knuckle/patch/cube_patch.h"
#include "knuckle/patch/turned_patch.h"

namespace knuckle {
namespace {

/// Quarter turns of the views after the first: upside down first, where most is to be gained.
constexpr std::array<int, 3> kTurns = {2, 1, 3};
/// What is a hand with a lower likelihood is none from any side.
constexpr double kNoHand = 0.05;

/// What the network that judges the side is shown [degrees].
constexpr std::array<double, 3> kTurnsForTheSide = {0.0, -30.0, 30.0};

/// Beyond a half: what the straight look says so clearly needs no other look.
constexpr double kClear = 0.495;

HandPatch turned_by(const HandPatch& patch, double angle_deg) {
  return {turned_by(patch.pixels, angle_deg * kDegree, kCubeBackground), patch.geometry, patch.camera};
}

double mean_confidence(const PatchPose& pose) {
  double sum = 0.0;
  for (const float confidence : pose.confidence) sum += confidence;
  return pose.confidence.empty() ? 0.0 : sum / static_cast<double>(pose.confidence.size());
}

/// The mean of two places of a joint, of which the first has the weight `share`, [0, 1].
PatchPoint mean_of(const PatchPoint& one, const PatchPoint& other, double share) {
  const auto mix = [&](double a, double b) { return share * a + (1.0 - share) * b; };
  return {mix(one.u, other.u), mix(one.v, other.v), mix(one.d, other.d)};
}

}  // namespace

void SurestEstimatorOptions::visit(OptionVisitor& visitor) {
  visitor.texts("models", models, {});
  visitor.integer("passes", passes, closed(1, 5));
  visitor.real("enough", enough, closed(0, 1));
  visitor.real("lead", lead, closed(0, 1));
  visitor.integer("views", views, closed(1, 4));
  visitor.real("second_look_deg", second_look_deg, closed(-90, 90));
  visitor.text("judge", judge);
}

SurestEstimator::SurestEstimator(std::vector<std::unique_ptr<Estimator>> estimators,
                                 const SurestEstimatorOptions& options, std::unique_ptr<Estimator> judge)
    : estimators_(std::move(estimators)), judge_(std::move(judge)), options_(options) {
  check_options(options_, "the surest of several estimators");
  if (estimators_.size() < 2)
    fail("the surest of several estimators: {} given, expected two or more", estimators_.size());
  for (const auto& estimator : estimators_) {
    if (estimator->convention().name != convention().name) {
      fail("the surest of several estimators: one predicts \"{}\", another one \"{}\"", convention().name,
           estimator->convention().name);
    }
    if (!(estimator->patches().options() == patches().options())) {
      fail("the surest of several estimators: they were trained on patches of different kinds");
    }
    if (!(estimator->sure_confidence() > 0.0)) {
      fail("the surest of several estimators: the confidences of one do not tell hands from other things");
    }
  }
  if (judge_ && !(judge_->patches().options() == patches().options()))
    fail("the surest of several estimators: the judge was trained on patches of another kind");
}

double SurestEstimator::sure_confidence() const {
  const auto least = std::ranges::min_element(
      estimators_, {}, [](const auto& estimator) { return estimator->sure_confidence(); });
  return (*least)->sure_confidence();
}

PatchPose SurestEstimator::estimate(const HandPatch& patch) const {
  Choice choice;
  for (int i = 0; i < std::ssize(estimators_); ++i) {
    if (i > 0 && choice.confidence >= options_.enough) break;  // the first is asked whatever is enough
    PatchPose pose = estimators_[i]->estimate(patch);
    pose.seen_by = i;
    consider(std::move(pose), choice);
  }
  if (choice.pose.hand.value_or(1.0) < kNoHand) return std::move(choice.pose);
  for (const int quarters : std::span(kTurns).first(static_cast<std::size_t>(options_.views - 1))) {
    if (choice.confidence >= options_.enough) break;
    PatchPose pose =
        estimators_.back()->estimate({turned(patch.pixels, quarters), patch.geometry, patch.camera});
    for (PatchPoint& joint : pose.joints) joint = turned(joint, 4 - quarters);
    pose.seen_by = static_cast<int>(estimators_.size()) - 1;
    pose.quarter_turns = quarters;
    consider(std::move(pose), choice);
  }
  return std::move(choice.pose);
}

PatchPose SurestEstimator::judged(const HandPatch& patch, PatchPose seen) const {
  if (seen.hand && !judge_) return seen;
  const PatchPose other = (judge_ ? judge_ : estimators_.back())->estimate(patch);
  seen.hand = other.hand;
  if (!seen.right_hand) seen.right_hand = other.right_hand;
  return seen;
}

PatchPose SurestEstimator::sided(const HandPatch& patch, PatchPose seen) const {
  double odds = 0.0;
  for (const double turn_deg : kTurnsForTheSide) {
    const PatchPose look =
        estimators_.back()->estimate(turned_by(patch, 90.0 * seen.quarter_turns + turn_deg));
    if (!look.right_hand) return seen;
    if (turn_deg == 0.0 && std::abs(*look.right_hand - 0.5) > kClear) {
      seen.right_hand = look.right_hand;
      return seen;
    }
    odds += log_odds(*look.right_hand) / std::ssize(kTurnsForTheSide);
  }
  seen.right_hand = logistic(odds);
  return seen;
}

PatchPose SurestEstimator::ascertained(const HandPatch& patch, PatchPose seen) const {
  if (options_.second_look_deg == 0.0) return seen;
  const double turn_deg = 90.0 * seen.quarter_turns + options_.second_look_deg;
  const PatchPose other = estimators_[seen.seen_by]->estimate(turned_by(patch, turn_deg));
  for (std::size_t i = 0; i < seen.joints.size(); ++i) {
    const double sum = double{seen.confidence[i]} + other.confidence[i];
    const double share = sum > 0.0 ? seen.confidence[i] / sum : 0.5;
    seen.joints[i] = mean_of(seen.joints[i], turned_by(other.joints[i], -turn_deg * kDegree), share);
    seen.confidence[i] = static_cast<float>(0.5 * sum);
  }
  return seen;
}

void SurestEstimator::consider(PatchPose other, Choice& choice) const {
  const double confidence = mean_confidence(other);
  if (choice.pose.joints.empty()) {
    choice = {std::move(other), confidence};
    return;
  }
  PatchPose& surest = choice.pose;
  if (!other.right_hand) other.right_hand = surest.right_hand;
  if (!surest.right_hand) surest.right_hand = other.right_hand;
  if (!other.hand) other.hand = surest.hand;
  if (!surest.hand) surest.hand = other.hand;
  if (confidence > choice.confidence + options_.lead) choice = {std::move(other), confidence};
}

}  // namespace knuckle
