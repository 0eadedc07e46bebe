// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/camera_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

namespace knuckle {
namespace {

constexpr std::size_t kSampleStep = 7;           // every so many pixels is looked at
constexpr std::size_t kMostSamples = 4'000'000;  // of all frames together

/// The value below which that share of the others lies; nothing where there is none. Reorders them.
std::optional<double> quantile(std::vector<float>& values, double share) {
  if (values.empty()) return std::nullopt;
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, place);
  return *place;
}

/// Depths, and their changes from frame to frame, of some pixels of all frames.
class DepthSamples {
 public:
  void add(const Image<float>& depth_mm, const Image<float>& before_mm) {
    for (std::size_t i = 0; i < depth_mm.size() && depths_.size() < kMostSamples; i += kSampleStep) {
      const float depth = depth_mm.data()[i];
      if (!is_measured(depth)) continue;
      depths_.push_back(depth);
      if (before_mm.size() == depth_mm.size() && is_measured(before_mm.data()[i])) {
        changes_.push_back(std::abs(depth - before_mm.data()[i]));
      }
    }
  }
  void tell(CameraCheck& check) {
    constexpr double kWithinOneDeviation = 0.683;
    check.nearest_mm = quantile(depths_, 0.01);
    check.median_mm = quantile(depths_, 0.5);
    check.farthest_mm = quantile(depths_, 0.99);
    check.noise_mm = quantile(changes_, kWithinOneDeviation);
    if (check.noise_mm) *check.noise_mm /= std::numbers::sqrt2;  // the difference of two has both their noise
  }

 private:
  std::vector<float> depths_;
  std::vector<float> changes_;
};

double measured_share_of(const Image<float>& depth_mm) {
  const auto measured = std::ranges::count_if(depth_mm.pixels(), is_measured);
  return static_cast<double>(measured) / static_cast<double>(std::max<std::size_t>(1, depth_mm.size()));
}

}  // namespace

CameraCheck check_camera(FrameStream& stream, const CheckLimits& limits) {
  CameraCheck check;
  DepthSamples samples;
  Frame before;
  double first_s = 0.0;
  double share = 0.0;
  check.is_still = true;
  while (check.frames < limits.most_frames) {
    std::optional<Frame> frame = stream.next();
    if (!frame) break;
    const double time_s = frame->time_s.value_or(0.0);
    if (check.frames == 0) first_s = time_s;
    if (check.frames > 0) {
      if (frame->depth_mm != before.depth_mm) check.is_still = false;
      check.rate_hz = time_s > first_s ? static_cast<double>(check.frames) / (time_s - first_s) : 0.0;
    }
    ++check.frames;
    share += measured_share_of(frame->depth_mm);
    samples.add(frame->depth_mm, before.depth_mm);
    before = *std::move(frame);
    if (time_s - first_s >= limits.most_seconds) break;
  }
  check.width = before.depth_mm.width();
  check.height = before.depth_mm.height();
  check.has_infrared = !before.infrared.empty();
  check.lost = stream.lost_frames();
  check.measured_share = check.frames > 0 ? share / static_cast<double>(check.frames) : 0.0;
  check.is_still = check.is_still && check.frames > 1;
  samples.tell(check);
  return check;
}

std::vector<std::string> remarks_on(const CameraCheck& check, const CameraFacts& facts) {
  constexpr double kLeastShare = 0.2;
  constexpr double kFarMm = 12000.0;
  constexpr double kNearMm = 60.0;
  constexpr double kMostLostShare = 0.05;
  std::vector<std::string> remarks;
  if (facts.intrinsics.empty()) {
    remarks.emplace_back(
        "its intrinsics are not known: say them by ?camera=FILE.toml, or roughly by ?fov_deg= "
        "(docs/cameras.md)");
  }
  if (check.frames == 0) {
    remarks.emplace_back("no frame came");
    return remarks;
  }
  if (!check.median_mm) {
    remarks.emplace_back("no pixel is measured: is the lens covered, or all nearer than the camera can see?");
    return remarks;
  }
  if (check.measured_share < kLeastShare) {
    remarks.push_back(
        fmt::format("only {:.0f} % of the pixels are measured: things may be too near, too far, in sunlight, "
                    "or black or shiny",
                    100.0 * check.measured_share));
  }
  if (*check.median_mm > kFarMm || *check.farthest_mm < kNearMm) {
    remarks.push_back(fmt::format(
        "depths lie about {:.4g} mm, which is unlikely: is the unit wrong? ?depth_unit_mm= says how many "
        "millimetres a count is",
        *check.median_mm));
  }
  const auto all = static_cast<double>(check.frames + check.lost);
  if (static_cast<double>(check.lost) > kMostLostShare * all) {
    remarks.push_back(
        fmt::format("{} of {} frames were lost on the way: use a port of USB 3 without a hub, a lower rate "
                    "or a smaller size",
                    check.lost, check.frames + check.lost));
  }
  if (check.is_still) remarks.emplace_back("all frames are the same image: the camera seems to hang");
  return remarks;
}

}  // namespace knuckle
