// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/angle_figures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "knuckle/core/angle.h"
#include "knuckle/hand/hand_angles.h"

namespace knuckle {
namespace {

constexpr std::size_t kMostPlaces = 1500;  // on the x axis: more than a figure has pixels
constexpr double kStepDegrees = 30.0;      // of the y axis

/// A hand of a method.
struct FollowedHand {
  const NamedRecords* method = nullptr;
  int id = 0;
  std::int64_t fitted = 0;  ///< frames
};

/// In the order in which they appear.
std::vector<FollowedHand> fitted_hands(std::span<const NamedRecords> records) {
  std::vector<FollowedHand> hands;
  for (const NamedRecords& method : records) {
    std::map<int, std::size_t> place_of;
    for (const FrameRecord& frame : method.frames) {
      for (const HandRecord& hand : frame.hands) {
        if (hand.angles_rad.empty()) continue;
        const auto [known, is_new] = place_of.try_emplace(hand.id, hands.size());
        if (is_new) hands.push_back({&method, hand.id});
        ++hands[known->second].fitted;
      }
    }
  }
  return hands;
}

/// Those with the most fitted frames, still in the order in which they appear.
std::vector<FollowedHand> longest(std::vector<FollowedHand> hands) {
  std::vector<FollowedHand> sorted = hands;
  std::ranges::stable_sort(sorted, std::ranges::greater{}, &FollowedHand::fitted);
  sorted.resize(std::min(sorted.size(), kMostAngleHands));
  std::erase_if(hands, [&](const FollowedHand& hand) {
    return std::ranges::none_of(
        sorted, [&](const FollowedHand& kept) { return kept.method == hand.method && kept.id == hand.id; });
  });
  return hands;
}

/// Where a figure's places lie: in time, or in numbers of frames.
struct TimeAxis {
  std::string label;
  std::vector<double> x;           ///< of the drawn frames
  std::vector<std::size_t> drawn;  ///< which they are
};

/// When a frame was, by the first record that knows.
std::optional<double> time_of(std::span<const NamedRecords> records, std::size_t frame) {
  for (const NamedRecords& method : records) {
    const std::optional<double>& time_s = method.frames[frame].time_s;
    if (time_s && std::isfinite(*time_s)) return time_s;
  }
  return std::nullopt;
}

/// Seconds from the first frame; nothing where a hand has no time, or times do not rise. Frames that no
/// record tells of are left out.
std::optional<TimeAxis> seconds_axis(std::span<const NamedRecords> records) {
  TimeAxis axis{"time (s)", {}, {}};
  double begin = 0.0;
  for (std::size_t frame = 0; frame < records.front().frames.size(); ++frame) {
    const std::optional<double> time_s = time_of(records, frame);
    if (!time_s) {
      const auto has_hands = [&](const NamedRecords& method) { return !method.frames[frame].hands.empty(); };
      if (std::ranges::any_of(records, has_hands)) return std::nullopt;
      continue;
    }
    if (axis.x.empty()) begin = *time_s;
    if (!axis.x.empty() && !(*time_s - begin > axis.x.back())) return std::nullopt;
    axis.x.push_back(*time_s - begin);
    axis.drawn.push_back(frame);
  }
  return axis;
}

TimeAxis frames_axis(std::size_t frames) {
  TimeAxis axis{"frame", {}, {}};
  for (std::size_t frame = 0; frame < frames; ++frame) {
    axis.x.push_back(static_cast<double>(frame));
    axis.drawn.push_back(frame);
  }
  return axis;
}

/// As many places as can be told apart.
TimeAxis thinned(TimeAxis axis) {
  const std::size_t step = (axis.x.size() + kMostPlaces - 1) / kMostPlaces;
  if (step <= 1) return axis;
  TimeAxis kept{fmt::format("{}, one of {} frames", axis.label, step), {}, {}};
  for (std::size_t i = 0; i < axis.x.size(); i += step) {
    kept.x.push_back(axis.x[i]);
    kept.drawn.push_back(axis.drawn[i]);
  }
  return kept;
}

TimeAxis time_axis(std::span<const NamedRecords> records) {
  const std::optional<TimeAxis> seconds = seconds_axis(records);
  return thinned(seconds ? *seconds : frames_axis(records.front().frames.size()));
}

/// An angle of a hand [degrees]; NaN where it was not fitted in this frame.
double degrees_in(const FrameRecord& frame, int id, HandAngle angle) {
  const auto hand = std::ranges::find(frame.hands, id, &HandRecord::id);
  if (hand == frame.hands.end()) return kNaN;
  const auto named =
      std::ranges::find(hand->angles_rad, name_of(angle), &std::pair<std::string, double>::first);
  return named == hand->angles_rad.end() ? kNaN : named->second / kDegree;
}

/// What a healthy hand can do, and what is drawn, in whole steps.
AxisRange degrees_shown(HandAngle angle, const std::vector<Series>& series) {
  AngleRange shown{range_of(angle).low / kDegree, range_of(angle).high / kDegree};
  for (const Series& one : series) {
    for (const double value : one.values) {
      if (!std::isfinite(value)) continue;
      shown.low = std::min(shown.low, value);
      shown.high = std::max(shown.high, value);
    }
  }
  return {std::floor(shown.low / kStepDegrees) * kStepDegrees,
          std::ceil(shown.high / kStepDegrees) * kStepDegrees, kStepDegrees};
}

Figure angle_figure(HandAngle angle, const std::vector<FollowedHand>& hands, const TimeAxis& axis) {
  Figure figure;
  figure.name = fmt::format("angle_{}", name_of(angle));
  figure.title = name_of(angle);
  figure.x_label = axis.label;
  figure.y_label = "angle (degrees)";
  figure.x = axis.x;
  for (const FollowedHand& hand : hands) {
    Series series{fmt::format("{}, hand {}", hand.method->name, hand.id), {}};
    for (const std::size_t frame : axis.drawn)
      series.values.push_back(degrees_in(hand.method->frames[frame], hand.id, angle));
    figure.series.push_back(std::move(series));
  }
  figure.y = degrees_shown(angle, figure.series);
  return figure;
}

}  // namespace

std::vector<Figure> angle_figures(std::span<const NamedRecords> records) {
  const std::vector<FollowedHand> hands = longest(fitted_hands(records));
  if (hands.empty()) return {};
  const TimeAxis axis = time_axis(records);
  if (axis.x.size() < 2) return {};  // no line yet
  std::vector<Figure> figures;
  for (int i = 0; i < kHandAngleCount; ++i)
    figures.push_back(angle_figure(static_cast<HandAngle>(i), hands, axis));
  return figures;
}

}  // namespace knuckle
