// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/pipeline.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/likelihood.h"
#include "knuckle/data/defined_pose.h"
#include "knuckle/estimate/create_estimator.h"
#include "knuckle/pipeline/calibrated_confidence.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/refine/refiner_factory.h"
#include "knuckle/segment/hand_region.h"

namespace knuckle {
namespace {

HandPose pose_in_image(const PatchPose& pose, const Convention& convention, const PatchGeometry& geometry) {
  HandPose result{convention, {}, pose.confidence};
  for (const PatchPoint& joint : pose.joints) result.joints.push_back(geometry.to_image(joint));
  return result;
}

/// Calls `work`, adds the time it took to `total_ms`, and returns what it returned.
template <class Work>
auto timed(double& total_ms, const Work& work) {
  const Stopwatch watch;
  auto result = work();
  total_ms += watch.milliseconds();
  return result;
}

/// What the file says of patches must be what the model was trained on.
void check_patch_options(const OptionTable& document, const Estimator& estimator) {
  const PatchOptions& trained = estimator.patches().options();
  PatchOptions options = trained;
  const OptionTable table = document.table("patch");
  table.read(options);
  if (options.size_px != trained.size_px) {
    table.fail_at("size_px", fmt::format("is {}, but the model was trained on patches of {} px",
                                         options.size_px, trained.size_px));
  }
  if (options.mode != trained.mode) {
    table.fail_at("mode", fmt::format("is \"{}\", but the model was trained on patches of the mode \"{}\"",
                                      options.mode, trained.mode));
  }
  if (options.cube_mm != trained.cube_mm) {
    table.fail_at("cube_mm", fmt::format("is {}, but the model was trained on cubes of {} mm",
                                         options.cube_mm, trained.cube_mm));
  }
}

/// What the file asks for, unless the program brings its own, which says itself what patches it wants.
std::unique_ptr<Estimator> estimator_of(const OptionTable& document, std::unique_ptr<Estimator> own) {
  if (own) {
    document.leave("estimator");
    document.leave("patch");
    return own;
  }
  auto estimator = create_estimator(document.table("estimator"));
  check_patch_options(document, *estimator);
  return estimator;
}

PipelineParts parts_from(const OptionTable& document, std::unique_ptr<Estimator> own) {
  auto estimator = estimator_of(document, std::move(own));
  const HandOptions defaults{.sure_confidence = estimator->sure_confidence()};
  PipelineParts parts{HandFinder(document, defaults), std::move(estimator)};
  for (const OptionTable& table : document.tables("refine")) parts.refiners.push_back(create_refiner(table));
  if (document.has("tracker")) document.table("tracker").read(parts.tracker.emplace());
  return parts;
}

/// 1 where the method gives none, and so no reason to doubt.
double mean_confidence(const std::vector<float>& confidences) {
  if (confidences.empty()) return 1.0;
  double sum = 0.0;
  for (const float confidence : confidences) sum += confidence;
  return sum / static_cast<double>(confidences.size());
}

/// Two regions whose centres are nearer than that are the same thing: no two palms can be.
constexpr double kSamePlaceMm = 50.0;
/// Of a known hand's middle: what is nearer is that hand.
constexpr double kKnownHandMm = 80.0;
/// A patch whose centre is nearer to the middle of the joints found in it is not cut again: another look
/// would see the same.
constexpr double kSettledMm = 10.0;
/// Of `sure_confidence`: what a search found and what scores less at first sight is no hand at second sight.
constexpr double kHopeless = 0.3;

bool is_near_one_of(const std::vector<Point3>& places, const Point3& centre, double near_mm = kSamePlaceMm) {
  return std::ranges::any_of(places, [&](const Point3& place) { return (place - centre).norm() < near_mm; });
}

/// Sorts the hands, the surest first, leaves out those in the place of a surer one, and keeps `most`.
void keep_surest(std::vector<HandEstimate>& hands, int most) {
  std::ranges::stable_sort(hands, std::ranges::greater{}, &HandEstimate::score);
  std::vector<HandEstimate> kept;
  std::vector<Point3> places;
  for (HandEstimate& hand : hands) {
    if (std::ssize(kept) == most || is_near_one_of(places, hand.region.centre)) continue;
    places.push_back(hand.region.centre);
    kept.push_back(std::move(hand));
  }
  hands = std::move(kept);
}

/// Moves regions of hands that are known from `found` to `known`.
void set_known_aside(std::vector<HandRegion>& found, const std::vector<Point3>& places,
                     std::vector<HandRegion>& known) {
  const auto aside = std::stable_partition(found.begin(), found.end(), [&](const HandRegion& region) {
    return !is_near_one_of(places, region.centre, kKnownHandMm);
  });
  known.insert(known.end(), std::make_move_iterator(aside), std::make_move_iterator(found.end()));
  found.erase(aside, found.end());
}

Search in_mirror(Search search) {
  search.start = mirrored(search.start);
  search.side.reset();
  for (Point3& place : search.known) place.x() = -place.x();
  return search;
}

constexpr double kSureOfSide = 0.9;
constexpr double kClearByTheArm = 0.75;  ///< where the hand as it is first seen does not contradict
constexpr double kOddsOfScore = 5.0;     ///< of the side whose pose is surer by 1

/// Whether two witnesses agree that it is a right hand: arm and body, and the first look at the hand.
bool is_clear_by_the_arm(const HandRegion& region, const PatchPose& seen) {
  return region.right_hand.value_or(0.0) >= kClearByTheArm && seen.right_hand.value_or(1.0) >= 0.5;
}

HandSide opposite(HandSide side) {
  return side == HandSide::right ? HandSide::left : HandSide::right;
}

/// What was found as a right hand in the mirrored frame is a left one in the frame, `width` pixels wide.
HandEstimate mirrored_back(HandEstimate hand, int width) {
  hand.region = mirrored(std::move(hand.region), width);
  hand.pose = mirrored(hand.pose, width);
  hand.side = HandSide::left;
  return hand;
}

}  // namespace

Pipeline::Pipeline(PipelineParts parts)
    : finder_(std::move(parts.finder)),
      estimator_(std::move(parts.estimator)),
      refiners_(std::move(parts.refiners)),
      tracker_(std::move(parts.tracker)) {
  if (!estimator_) fail("a pipeline was to be made without an estimator");
  if (!std::ranges::all_of(refiners_, [](const auto& refiner) { return refiner != nullptr; })) {
    fail("one of the pipeline's refiners is missing");
  }
  if (tracker_) check_options(*tracker_, "tracker");
}

Pipeline Pipeline::load(const std::filesystem::path& path, std::unique_ptr<Estimator> own) {
  return from_table(OptionTable::load(path), std::move(own));
}

Pipeline Pipeline::from_toml(std::string_view toml, const std::filesystem::path& folder,
                             std::unique_ptr<Estimator> own) {
  return from_table(OptionTable::parse(toml, "pipeline", folder), std::move(own));
}

Pipeline Pipeline::from_table(const OptionTable& document, std::unique_ptr<Estimator> own) {
  Pipeline pipeline(parts_from(document, std::move(own)));
  document.finish();
  pipeline.resolved_options_ = document.resolved_toml();
  return pipeline;
}

void Pipeline::use_landmarks(const LandmarkDefinition& definition) {
  require_all_landmarks(estimator_->convention(), "the pipeline's model");
  if (tracker_) fail("a tracker gives the landmarks of its skeleton; move them with `evaluate --landmarks`");
  landmarks_ = definition;
}

FrameEstimate Pipeline::estimate(const Frame& frame) const {
  return estimate(frame, {.max_hands = finder_.hand().max_hands});
}

FrameEstimate Pipeline::estimate(const Frame& frame, const Search& search) const {
  FrameEstimate result =
      finder_.hand().is_left() ? estimate_left(frame, search) : estimate_right(frame, search);
  if (search.calibrate) {
    for (HandEstimate& hand : result.hands) calibrate(hand.pose.confidence, finder_.hand());
  }
  return result;
}

FrameEstimate Pipeline::estimate_left(const Frame& frame, const Search& search) const {
  const int width = frame.camera.width;
  FrameEstimate result = estimate_right(mirrored(frame), in_mirror(search));
  for (HandEstimate& hand : result.hands) hand = mirrored_back(std::move(hand), width);
  for (HandRegion& region : result.known) region = mirrored(std::move(region), width);
  return result;
}

FrameEstimate Pipeline::estimate_right(const Frame& frame, const Search& search) const {
  check_max_hands(search.max_hands);
  FrameEstimate result;
  if (search.start) {
    Segmentation found = found_in(frame, search.start, search, 1, result.times);
    result.status = std::move(found.reason);
    add_hands(frame, std::move(found.hands), {.side = search.side}, result);
    if (!result.hands.empty()) look_at_start(frame, search, result.hands.front(), result.times);
  }
  const std::size_t at_start = result.hands.size();
  if (search.elsewhere.value_or(!search.start)) look_elsewhere(frame, search, result);
  double surest = 0.0;
  for (const HandEstimate& hand : result.hands) surest = std::max(surest, hand.score);
  result.hands.erase(
      std::remove_if(result.hands.begin() + static_cast<std::ptrdiff_t>(at_start), result.hands.end(),
                     [&](const auto& hand) { return !is_sure(hand.score); }),
      result.hands.end());
  keep_surest(result.hands, search.max_hands);
  if (!result.hands.empty()) {
    result.status = is_sure(result.hands.front().score) ? "" : kUnsure;
  } else if (surest > 0.0) {
    result.status = fmt::format(
        "nothing looks like a hand: the surest place has a score of {:.2f}, a hand at least {:.2f}", surest,
        finder_.hand().sure_confidence);
  } else if (result.status.empty()) {
    result.status = "the hand has no measured pixel";
  }
  return result;
}

/// Who tells sides is asked where they are open.
Segmentation Pipeline::found_in(const Frame& frame, const std::optional<Point3>& start, const Search& search,
                                int places, StageTimes& times) const {
  return timed(times.segment_ms, [&] {
    Segmentation found = finder_.find_right(frame, start, places);
    if (!search.side) finder_.tell_sides(frame, found.hands);
    return found;
  });
}

bool Pipeline::is_sure(double score) const {
  return score >= finder_.hand().sure_confidence;
}

void Pipeline::add_hands(const Frame& frame, std::vector<HandRegion> regions, const Look& look,
                         FrameEstimate& result) const {
  for (HandRegion& region : regions) {
    if (auto hand = hand_in(frame, std::move(region), look, result.times))
      result.hands.push_back(*std::move(hand));
  }
}

/// Segmentation may leave the start for something larger beside it, an arm. Where the pose there is not sure,
/// the start itself is looked at, and the surer pose is kept.
void Pipeline::look_at_start(const Frame& frame, const Search& search, HandEstimate& hand,
                             StageTimes& times) const {
  const PatchOptions& patches = estimator_->patches().options();
  if (is_sure(hand.score) || !patches.is_cube()) return;
  HandRegion region = region_in_cube(frame, *search.start, patches.cube_mm);
  region.side = hand.region.side;
  region.right_hand = hand.region.right_hand;
  auto other = hand_in(frame, std::move(region), {.side = search.side}, times);
  if (other && other->score > hand.score) hand = *std::move(other);
}

void Pipeline::look_elsewhere(const Frame& frame, const Search& search, FrameEstimate& result) const {
  std::vector<Point3> tried;
  for (const HandEstimate& hand : result.hands) tried.push_back(hand.region.centre);
  for (const int places : {search.max_hands, finder_.hand().candidates}) {
    Segmentation found = found_in(frame, std::nullopt, search, places, result.times);
    if (result.hands.empty()) result.status = std::move(found.reason);
    const bool are_all = std::ssize(found.hands) < places;
    std::erase_if(found.hands,
                  [&](const HandRegion& region) { return is_near_one_of(tried, region.centre); });
    for (const HandRegion& region : found.hands) tried.push_back(region.centre);
    set_known_aside(found.hands, search.known, result.known);
    add_hands(frame, std::move(found.hands), {.side = search.side, .may_give_up = true}, result);
    const auto sure =
        std::ranges::count_if(result.hands, [&](const auto& hand) { return is_sure(hand.score); });
    if (are_all || sure + std::ssize(result.known) >= search.max_hands || places >= finder_.hand().candidates)
      break;
  }
}

/// Estimators know right hands: where each hand has its own side, a left one is looked at in a mirror.
/// Segmentation guesses the side. Unless the arm makes it clear or the estimator is sure of the guess, it is
/// shown the other side as well, and what it says of both sides and how sure it is of both poses decide.
std::optional<HandEstimate> Pipeline::hand_in(const Frame& frame, HandRegion region, const Look& look,
                                              StageTimes& times) const {
  const bool is_auto = finder_.hand().is_auto();
  const bool is_open = is_auto && !look.side;
  Look first = look;
  if (is_auto) first.may_give_up = false;  // as a hand of the other side it may be sure
  const HandSide guess =
      is_auto ? look.side.value_or(region.side.value_or(HandSide::right)) : HandSide::right;
  std::optional<HandRegion> of_other_side;
  if (is_open) of_other_side = region;
  auto sight = sight_of(frame, std::move(region), guess, first, times);
  if (!sight) return std::nullopt;
  if (of_other_side && !sight->is_sure_of_side()) {
    auto other = sight_of(frame, *std::move(of_other_side), opposite(guess), first, times);
    if (other && other->odds_of_side() > sight->odds_of_side()) sight = std::move(other);
  }
  return completed(frame, *std::move(sight), look, times);
}

std::optional<double> Pipeline::Sight::likelihood_of_side() const {
  if (!region.right_hand) return pose.right_hand;
  const double seen = pose.right_hand ? log_odds(*pose.right_hand) : 0.0;
  return logistic(seen + log_odds(*region.right_hand));
}

bool Pipeline::Sight::is_sure_of_side() const {
  return side_is_clear || likelihood_of_side().value_or(0.0) >= kSureOfSide;
}

double Pipeline::Sight::odds_of_side() const {
  const std::optional<double> likelihood = likelihood_of_side();
  return (likelihood ? log_odds(*likelihood) : 0.0) + kOddsOfScore * score;
}

std::optional<Pipeline::Sight> Pipeline::sight_of(const Frame& frame, HandRegion region, HandSide side,
                                                  const Look& look, StageTimes& times) const {
  if (side == HandSide::right) return sight_of_right(frame, std::move(region), look, times);
  auto mirror = std::make_unique<const Frame>(mirrored(frame));
  auto sight = sight_of_right(*mirror, mirrored(std::move(region), frame.camera.width), look, times);
  if (sight) sight->mirror = std::move(mirror);
  return sight;
}

std::optional<Pipeline::Sight> Pipeline::sight_of_right(const Frame& frame, HandRegion region,
                                                        const Look& look, StageTimes& times) const {
  auto patch = timed(times.patch_ms, [&] { return estimator_->patches().extract(frame, region); });
  if (!patch) return std::nullopt;
  PatchPose in_patch = timed(times.estimate_ms, [&] { return estimator_->estimate(*patch); });
  const double hopeless = look.may_give_up ? kHopeless * finder_.hand().sure_confidence : 0.0;
  for (int pass = 1; pass < estimator_->passes(); ++pass) {
    if (score_of(in_patch, region) < hopeless) break;
    const ImagePoint centre = mean_joint(pose_in_image(in_patch, estimator_->convention(), patch->geometry));
    if ((Projection(frame.camera).to_camera(centre) - region.centre).norm() < kSettledMm) break;
    auto nearer = timed(times.patch_ms, [&] { return estimator_->patches().extract_around(frame, centre); });
    if (!nearer) break;
    patch = std::move(nearer);
    in_patch = timed(times.estimate_ms, [&] { return estimator_->estimate(*patch); });
    region = timed(times.patch_ms, [&] { return region_looked_at(frame, centre, region); });
  }
  double score = score_of(in_patch, region);
  if (is_sure(score) && score < finder_.hand().judged_below) {
    in_patch = timed(times.estimate_ms, [&] { return estimator_->judged(*patch, std::move(in_patch)); });
    score = score_of(in_patch, region);
  }
  const bool side_is_clear = is_clear_by_the_arm(region, in_patch);
  if (!side_is_clear && is_sure(score) && finder_.hand().is_auto() && !look.side) {
    in_patch = timed(times.estimate_ms, [&] { return estimator_->sided(*patch, std::move(in_patch)); });
  }
  return Sight{*std::move(patch), std::move(in_patch), std::move(region), score, side_is_clear};
}

HandEstimate Pipeline::completed(const Frame& frame, Sight sight, const Look& look, StageTimes& times) const {
  HandEstimate hand = completed_right(sight.mirror ? *sight.mirror : frame, sight, look, times);
  return sight.mirror ? mirrored_back(std::move(hand), frame.camera.width) : hand;
}

HandEstimate Pipeline::completed_right(const Frame& frame, Sight& sight, const Look& look,
                                       StageTimes& times) const {
  if (is_sure(sight.score)) {
    sight.pose =
        timed(times.estimate_ms, [&] { return estimator_->ascertained(sight.patch, std::move(sight.pose)); });
  }
  HandPose pose = pose_in_image(sight.pose, estimator_->convention(), sight.patch.geometry);
  HandEstimate hand;
  hand.side_confidence = sight.likelihood_of_side();
  hand.score = sight.score;
  if (is_sure(sight.score) || !look.may_give_up) {
    hand.score *= std::sqrt(timed(times.refine_ms, [&] { return refine(frame, sight.region, pose, hand); }));
  }
  hand.region = std::move(sight.region);
  hand.pose = landmarks_ ? defined_pose(*landmarks_, pose, Projection(frame.camera), HandSide::right)
                         : std::move(pose);
  return hand;
}

/// Changes the pose and tells the hand's angles and skeleton; how plausible that is, (0, 1].
double Pipeline::refine(const Frame& frame, const HandRegion& region, HandPose& pose,
                        HandEstimate& hand) const {
  double plausibility = 1.0;
  for (const auto& refiner : refiners_) {
    RefinedHand refined = refiner->refine(frame, region, std::move(pose));
    pose = std::move(refined.pose);
    plausibility *= refined.plausibility;
    if (!refined.angles) continue;
    hand.angles = refined.angles;
    hand.skeleton = std::move(refined.skeleton);
  }
  return plausibility;
}

/// Who sees the pose is one witness; who found the place counts by half, as does how well a hand model fits.
double Pipeline::score_of(const PatchPose& pose, const HandRegion& region) const {
  const double is_hand = std::pow(pose.hand.value_or(1.0), finder_.hand().hand_weight);
  return std::sqrt(region.likelihood.value_or(1.0)) * is_hand * mean_confidence(pose.confidence);
}

HandRegion Pipeline::region_looked_at(const Frame& frame, const ImagePoint& centre,
                                      const HandRegion& before) const {
  const Point3 place = Projection(frame.camera).to_camera(centre);
  HandRegion region = region_in_cube(frame, place, estimator_->patches().options().cube_mm);
  region.score = before.score;
  region.side = before.side;
  region.right_hand = before.right_hand;
  region.likelihood = before.likelihood;
  return region;
}

}  // namespace knuckle
