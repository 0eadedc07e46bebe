// SPDX-License-Identifier: Apache-2.0
// How far labels are from the truth after so many corrections, by the scripted annotator of
// web/tests/annotator.mjs without a browser: seconds in place of minutes, and where the error lies.
//
//     knuckle_labelling synthetic:manifests/test_scenes.toml --turns --guess 10 --out docs/images
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <unistd.h>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/random.h"
#include "knuckle/core/statistics.h"
#include "knuckle/eval/pictures/figures.h"
#include "knuckle/label/label_session.h"
#include "knuckle/label/label_smoothing.h"
#include "knuckle/pipeline/pipeline.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

struct LabellingOptions {
  std::string source;
  std::filesystem::path pipeline = "pipelines/default.toml";
  std::filesystem::path figure_folder;  ///< for the curves of all four ways; empty: that of the options
  std::int64_t first = 0;
  std::int64_t count = 60;
  int most_corrections = 4;
  /// Corrections per frame on average; frames that are left over keep what follows from the others.
  double budget = 100.0;
  double click_mm = 2.0;   ///< deviation of a click, both ways across the screen
  double least_mm = 4.0;   ///< what is nearer is left as it is
  double enough_mm = 0.0;  ///< stops at a frame whose worst landmark that is seen is nearer than that
  bool is_raw = false;     ///< without the hand model
  bool verifies = false;   ///< each frame, before the next, which the program proposes
  /// Places hidden landmarks as well, as a person who knows hands guesses them, with this deviation; 0: not
  double guess_mm = 0.0;
  bool turns = false;  ///< also moves landmarks in the points, seen from the side and from above
};

/// A part of a source, as frames from 0.
class PartOfSource final : public FrameSource {
 public:
  PartOfSource(const FrameSource& source, std::int64_t first, std::int64_t count)
      : source_(source), first_(first), count_(std::min(count, source.size() - first)) {}
  std::int64_t size() const override { return count_; }
  Frame read(std::int64_t index) const override { return source_.read(first_ + index); }
  FrameLabel read_label(std::int64_t index) const override { return source_.read_label(first_ + index); }
  std::optional<Convention> convention() const override { return source_.convention(); }

 private:
  const FrameSource& source_;
  std::int64_t first_;
  std::int64_t count_;
};

/// Where the error lies after some number of corrections.
struct Errors {
  RunningMean all;
  RunningMean along;   ///< the line of sight
  RunningMean across;  ///< it
  RunningMean hidden;
  RunningMean seen;
  RunningMean pinned;
  std::array<RunningMean, kSupersetSize> landmarks;
};

/// From which side the points are looked at.
enum class View : std::uint8_t { front, side, top };

class Annotator {
 public:
  Annotator(const FrameSource& source, LabelSession& session, const LabellingOptions& options)
      : source_(source),
        session_(session),
        options_(options),
        random_(11),
        errors_(static_cast<std::size_t>(options.most_corrections) + 1) {}

  void work() {
    if (options_.verifies) return work_as_proposed();
    for (std::int64_t i = 0; i < source_.size(); ++i) work_on(i);
  }
  void print() const;
  std::vector<double> curve_mm() const;

 private:
  void work_as_proposed() {
    std::int64_t last = 0;
    const double most = options_.budget * static_cast<double>(source_.size());
    for (std::int64_t done = 0; done < source_.size() && corrections_ < most; ++done) {
      const auto next = session_.proposed(last);
      if (!next) return;
      last = *next;
      work_on(last);
      const auto labelled = session_.frame(last);
      if (labelled.hands.empty()) continue;
      LabelRequest verify{.kind = LabelRequest::Kind::verify, .hand = {last, labelled.hands[0].side}};
      verify.revision = labelled.hands[0].revision;
      session_.apply(verify);
      while (session_.work()) {
      }
    }
  }

  void work_on(std::int64_t index) {
    frame_ = source_.read(index);
    LabelledFrame labelled = session_.frame(index);
    ++frames_;
    note(labelled, 0);
    for (int i = 1; i <= options_.most_corrections; ++i) {
      if (!labelled.hands.empty() && !correct(labelled)) {
        for (; i <= options_.most_corrections; ++i) note(labelled, i);
        return;
      }
      note(labelled, i);
    }
  }

  /// Says that a landmark is hidden.
  void hide(std::size_t landmark, LabelledFrame& labelled) {
    LabelRequest look{.kind = LabelRequest::Kind::look, .hand = {index_, labelled.hands[0].side}};
    look.revision = labelled.hands[0].revision;
    look.landmark = landmark;
    look.is_visible = false;
    labelled = session_.apply(look).labelled;
  }

  bool is_seen(std::size_t landmark) const {
    constexpr double kBelowPalmMm = 45.0;
    constexpr double kBelowFingerMm = 20.0;
    const ImagePoint& joint = frame_.truth->joints[landmark];
    const int column = static_cast<int>(std::lround(joint.u));
    const int row = static_cast<int>(std::lround(joint.v));
    if (joint.is_missing() || column < 0 || row < 0 || column >= frame_.depth_mm.width() ||
        row >= frame_.depth_mm.height() || !is_measured(frame_.depth_mm(column, row)))
      return false;
    return joint.depth_mm - frame_.depth_mm(column, row) < (landmark < 3 ? kBelowPalmMm : kBelowFingerMm);
  }

  /// How far a landmark lies from where a person has it; nothing where the person would leave it.
  std::optional<double> to_mend_mm(const LabelledHand& hand, std::size_t landmark,
                                   const Projection& projection) const {
    constexpr double kClearlyOff = 2.0;  // guesses that are nearer than this many deviations are no better
    const LandmarkLabel& label = hand.landmarks[landmark];
    const ImagePoint& joint = frame_.truth->joints[landmark];
    if (label.at.is_missing() || joint.is_missing()) return std::nullopt;
    const double away_mm = (projection.to_camera(joint) - projection.to_camera(label.at)).norm();
    const bool is_corrected = label.state == LabelState::corrected;
    if (is_seen(landmark)) {
      const bool is_left = away_mm <= options_.least_mm || (is_corrected && !options_.turns);
      return is_left ? std::nullopt : std::optional(away_mm);
    }
    const bool is_clear = options_.guess_mm > 0.0 && away_mm > kClearlyOff * options_.guess_mm;
    return is_clear && !is_corrected ? std::optional(away_mm) : std::nullopt;
  }

  /// Corrects the landmark that lies farthest from where the true one appears. Whether there was one.
  bool correct(LabelledFrame& labelled) {
    const Projection projection(frame_.camera);
    std::optional<std::size_t> farthest;
    double most = options_.enough_mm;
    for (std::size_t i = 0; i < kSupersetSize; ++i) {
      const auto away_mm = to_mend_mm(labelled.hands[0], i, projection);
      if (!away_mm || *away_mm <= most) continue;
      most = *away_mm;
      farthest = i;
    }
    if (!farthest) return false;
    const double deviation_mm = is_seen(*farthest) ? options_.click_mm : options_.guess_mm;
    if (!is_seen(*farthest) && labelled.hands[0].landmarks[*farthest].is_visible) hide(*farthest, labelled);
    const LabelAnswer answer =
        session_.apply(correction(labelled.hands[0], *farthest, deviation_mm, projection));
    ++corrections_;
    fits_ms_.push_back(answer.fit_ms);
    labelled = answer.labelled;
    return true;
  }

  /// That in which the landmark is seen to move farthest.
  static View best_view(const Eigen::Vector3d& away) {
    const double front = std::hypot(away.x(), away.y());
    const double side = std::hypot(away.y(), away.z());
    const double top = std::hypot(away.x(), away.z());
    if (front >= side && front >= top) return View::front;
    return side >= top ? View::side : View::top;
  }

  LabelRequest correction(const LabelledHand& hand, std::size_t landmark, double deviation_mm,
                          const Projection& projection) {
    LabelRequest request{.hand = {index_, hand.side}, .revision = hand.revision, .landmark = landmark};
    request.uses_model = !options_.is_raw;
    const ImagePoint& joint = frame_.truth->joints[landmark];
    const Point3 truth = projection.to_camera(joint);
    const Point3 now = projection.to_camera(hand.landmarks[landmark].at);
    const View view = options_.turns ? best_view(truth - now) : View::front;
    if (view == View::front) {
      request.kind = LabelRequest::Kind::place;
      const double px = deviation_mm * projection.pixels_per_mm(joint.depth_mm);
      request.u = joint.u + px * random_.normal();
      request.v = joint.v + px * random_.normal();
      return request;
    }
    request.kind = LabelRequest::Kind::move;
    request.point_mm = truth + deviation_mm * Point3(random_.normal(), random_.normal(), random_.normal());
    const int kept = view == View::side ? 0 : 1;  // what this view does not show
    request.point_mm[kept] = now[kept];
    return request;
  }

  void note(const LabelledFrame& labelled, int corrections) {
    index_ = labelled.index;
    if (labelled.hands.empty()) return;
    const Projection projection(frame_.camera);
    Errors& errors = errors_[static_cast<std::size_t>(corrections)];
    for (std::size_t i = 0; i < labelled.hands[0].landmarks.size(); ++i) {
      const Point3 truth = projection.to_camera(frame_.truth->joints[i]);
      const LandmarkLabel& label = labelled.hands[0].landmarks[i];
      if (!truth.allFinite() || label.at.is_missing()) continue;
      const Eigen::Vector3d away = projection.to_camera(label.at) - truth;
      const double along = std::abs(away.dot(truth.normalized()));
      errors.all.add(away.norm());
      errors.landmarks[i].add(away.norm());
      errors.along.add(along);
      errors.across.add(std::sqrt(std::max(0.0, away.squaredNorm() - along * along)));
      (is_seen(i) ? errors.seen : errors.hidden).add(away.norm());
      if (label.is_pinned()) errors.pinned.add(away.norm());
    }
  }

  const FrameSource& source_;
  LabelSession& session_;
  const LabellingOptions& options_;
  Random random_;
  Frame frame_;
  std::int64_t index_ = 0;
  std::int64_t frames_ = 0;
  int corrections_ = 0;
  std::vector<double> fits_ms_;
  std::vector<Errors> errors_;
};

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return kNaN;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void Annotator::print() const {
  fmt::print("{} frames, {:.2f} corrections per frame; a fit takes {:.1f} ms, 95th percentile {:.1f} ms\n",
             frames_, static_cast<double>(corrections_) / static_cast<double>(source_.size()),
             percentile(fits_ms_, 0.5), percentile(fits_ms_, 0.95));
  for (std::size_t i = 0; i < errors_.size(); ++i) {
    const Errors& errors = errors_[i];
    fmt::print(
        "  after {}: {:5.2f} mm; along sight {:5.2f}, across {:5.2f}; seen {:5.2f} ({:.0f} %), hidden "
        "{:5.2f}; pinned {:5.2f} ({})\n",
        i, errors.all.value(), errors.along.value(), errors.across.value(), errors.seen.value(),
        100.0 * static_cast<double>(errors.seen.count) / static_cast<double>(errors.all.count),
        errors.hidden.value(), errors.pinned.value(), errors.pinned.count);
  }
  fmt::print("  each landmark:");
  for (const RunningMean& landmark : errors_.back().landmarks) fmt::print(" {:.1f}", landmark.value());
  fmt::print("\n");
}

std::vector<double> Annotator::curve_mm() const {
  std::vector<double> curve;
  for (const Errors& errors : errors_) curve.push_back(errors.all.value());
  return curve;
}

/// How far the labels are from the truth as `labels export --smooth` writes them.
void print_smoothed(const FrameSource& source, const LabelBook& book) {
  for (const int reach : {2, 3, 4, 5, 6}) {
    RunningMean error;
    for (const auto& [hand, points] : smoothed_labels(source, book, LabelState::estimated, reach)) {
      const FrameLabel truth = source.read_label(hand.frame);
      const Projection projection(truth.camera);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const ImagePoint& joint = truth.truth->joints[i];
        if (joint.is_missing() || points[i].is_missing()) continue;
        error.add((projection.to_camera(points[i]) - projection.to_camera(joint)).norm());
      }
    }
    fmt::print("  smoothed over {} frames on both sides: {:.2f} mm\n", reach, error.value());
  }
}

/// The mean error after each number of corrections [mm].
std::vector<double> measured(const LabellingOptions& options) {
  std::vector<double> curve;
  const auto whole = open_source(options.source);
  const PartOfSource source(*whole, options.first, options.count);
  const Pipeline pipeline = Pipeline::load(options.pipeline);
  const auto folder =
      std::filesystem::temp_directory_path() / fmt::format("knuckle-labelling-{}", ::getpid());
  {
    LabelJournal journal(folder / "labels.jsonl", {.source = options.source,
                                                   .fingerprint = "0",
                                                   .frames = source.size(),
                                                   .convention = superset_convention(),
                                                   .camera = source.read_label(0).camera});
    LabelSessionOptions session_options;
    session_options.estimate = [&](const Frame& frame) {
      std::vector<EstimatedHand> hands;
      for (HandEstimate& hand : pipeline.estimate(frame, {.max_hands = pipeline.hand().max_hands}).hands)
        hands.push_back({hand.side, std::move(hand.pose)});
      return hands;
    };
    LabelSession session(source, journal, session_options);
    while (session.work()) {
    }
    Annotator annotator(source, session, options);
    annotator.work();
    annotator.print();
    print_smoothed(source, journal.book());
    curve = annotator.curve_mm();
  }
  std::filesystem::remove_all(folder);
  return curve;
}

void draw(LabellingOptions options) {
  struct Way {
    const char* name;
    bool is_raw;
    bool verifies;
  };
  Figure figure;
  figure.name = "labelling";
  figure.title = "Labels of a scripted annotator";
  figure.x_label = "corrections per frame";
  figure.y_label = "mean distance from the truth [mm]";
  figure.y = std::nullopt;
  for (int i = 0; i <= options.most_corrections; ++i) figure.x.push_back(i);
  for (const Way& way : {Way{"raw points", true, false}, Way{"hand model", false, false},
                         Way{"hand model, neighbours follow", false, true}}) {
    fmt::print("{}: ", way.name);
    options.is_raw = way.is_raw;
    options.verifies = way.verifies;
    figure.series.push_back({way.name, measured(options)});
  }
  make_folder(options.figure_folder);
  write_figures(std::vector{figure}, options.figure_folder);
}

}  // namespace
}  // namespace knuckle

int main(int argc, char** argv) {
  knuckle::LabellingOptions options;
  CLI::App app("How far labels are from the truth after so many corrections");
  app.add_option("source", options.source, "frames with the truth")->required();
  app.add_option("--pipeline", options.pipeline, "what finds the hands first");
  app.add_option("--first", options.first, "first frame")->check(CLI::NonNegativeNumber);
  app.add_option("--count", options.count, "frames")->check(CLI::PositiveNumber);
  app.add_option("--corrections", options.most_corrections, "most per frame")->check(CLI::Range(0, 100));
  app.add_option("--click", options.click_mm, "deviation of a click [mm]")->check(CLI::Range(0.0, 100.0));
  app.add_option("--least", options.least_mm, "what is nearer is left [mm]")->check(CLI::Range(0.0, 100.0));
  app.add_option("--enough", options.enough_mm, "a frame whose worst landmark is nearer is left [mm]")
      ->check(CLI::Range(0.0, 100.0));
  app.add_flag("--raw", options.is_raw, "without the hand model");
  CLI::Option* const verify =
      app.add_flag("--verify", options.verifies, "verify each frame; the program proposes the next");
  app.add_option("--budget", options.budget, "most per frame on average, spent where the program proposes it")
      ->check(CLI::PositiveNumber)
      ->needs(verify);
  app.add_option("--guess", options.guess_mm, "place hidden landmarks, too, with this deviation [mm]")
      ->check(CLI::Range(0.0, 100.0));
  app.add_flag("--turns", options.turns, "also move landmarks in the points, turned");
  app.add_option("--out", options.figure_folder,
                 "folder for a figure: raw points, the hand model, and with neighbours that follow");
  CLI11_PARSE(app, argc, argv);
  try {
    if (options.figure_folder.empty()) {
      knuckle::measured(options);
    } else {
      knuckle::draw(options);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
