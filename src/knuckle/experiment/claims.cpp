// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/claims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "knuckle/core/text.h"
#include "knuckle/eval/metrics/score_files.h"

namespace knuckle {
namespace {

constexpr double kMagnitude = 10.0;     // "a magnitude faster"
constexpr double kAboutTheSame = 0.05;  // "identical", "nearly no gain": a difference up to this part
constexpr std::array<std::string_view, 5> kPaperNetworks = {"heatmap2d", "heatmap25d", "regression", "pca",
                                                            "autoencoder"};

/// The numbers of one sequence, by the methods' names.
class Numbers {
 public:
  explicit Numbers(const SequenceScores& scores) : scores_(scores) {}

  const std::string& title() const { return scores_.title; }
  double iou(std::string_view method) const { return scores_.segmentation.at(segmentation(method)).mean_iou; }
  double segmentation_ms(std::string_view method) const {
    return scores_.segmentation_ms.at(segmentation(method));
  }
  double error_3d(std::string_view method) const { return score_of(method).mean_3d_mm; }
  double error_2d(std::string_view method) const { return score_of(method).mean_2d_px; }

  bool has_segmentation(std::string_view method) const {
    return segmentation(method) < scores_.segmentation.size();
  }
  bool has_estimation(std::string_view method) const {
    return scores_.evaluation && estimation(method) < scores_.evaluation->methods.size();
  }

 private:
  std::size_t segmentation(std::string_view method) const {
    const auto found = std::ranges::find(scores_.segmentation, method, &SegmentationScore::name);
    return static_cast<std::size_t>(found - scores_.segmentation.begin());
  }
  std::size_t estimation(std::string_view method) const {
    const auto& methods = scores_.evaluation->methods;
    return static_cast<std::size_t>(std::ranges::find(methods, method, &MethodScore::name) - methods.begin());
  }
  const MethodScore& score_of(std::string_view method) const {
    return scores_.evaluation->methods.at(estimation(method));
  }

  const SequenceScores& scores_;
};

/// What one sequence says of a claim.
struct Observation {
  bool holds = false;
  std::string text;
};

/// A claim, the methods it speaks of, and what has to hold on a sequence for it to be true there.
struct Rule {
  std::string statement;
  std::string test;
  std::vector<std::string_view> segmentation;
  std::vector<std::string_view> estimation;
  std::function<Observation(const Numbers&)> observe;
};

std::vector<std::string> missing_methods(const Rule& rule, const ExperimentScores& scores) {
  const Numbers first(scores.sequences.front());  // all sequences have the same methods
  std::vector<std::string> missing;
  for (const std::string_view method : rule.segmentation) {
    if (!first.has_segmentation(method)) missing.push_back(fmt::format("the segmentation \"{}\"", method));
  }
  for (const std::string_view method : rule.estimation) {
    if (!first.has_estimation(method)) missing.push_back(fmt::format("the estimation \"{}\"", method));
  }
  return missing;
}

Verdict verdict_of(std::size_t holding, std::size_t all) {
  if (holding == all) return Verdict::agrees;
  return holding == 0 ? Verdict::disagrees : Verdict::in_part;
}

Claim judged(const Rule& rule, const ExperimentScores& scores) {
  Claim claim{.statement = rule.statement, .test = rule.test, .verdict = Verdict::unknown, .evidence = {}};
  const std::vector<std::string> missing = missing_methods(rule, scores);
  if (!missing.empty()) {
    claim.evidence = {"This experiment lacks " + joined(missing) + "."};
    return claim;
  }
  std::size_t holding = 0;
  for (const SequenceScores& sequence : scores.sequences) {
    const Observation seen = rule.observe(Numbers(sequence));
    holding += seen.holds ? 1 : 0;
    claim.evidence.push_back(
        fmt::format("{}: {} ({})", sequence.title, seen.text, seen.holds ? "yes" : "no"));
  }
  claim.verdict = verdict_of(holding, scores.sequences.size());
  return claim;
}

/// `value` against `reference`, as in "-12%".
std::string change(double value, double reference) {
  return fmt::format("{:+.0f}%", 100.0 * (value / reference - 1.0));
}

bool is_about_the_same(double value, double reference) {
  return std::abs(value / reference - 1.0) <= kAboutTheSame;
}

Observation tightest(const Numbers& numbers) {
  const double mean_shift = numbers.iou("mean shift");
  const double forest = numbers.iou("forest");
  const double threshold = numbers.iou("threshold");
  return {mean_shift > forest && mean_shift > threshold,
          fmt::format("mean overlap {:.3f} by mean shift, {:.3f} by the forest, {:.3f} by the threshold",
                      mean_shift, forest, threshold)};
}

Observation a_magnitude_faster(const Numbers& numbers) {
  const double mean_shift = numbers.segmentation_ms("mean shift");
  const double forest = numbers.segmentation_ms("forest");
  return {forest >= kMagnitude * mean_shift,
          fmt::format("{:.2f} ms per frame against {:.2f} ms, {:.1f} times as fast", mean_shift, forest,
                      forest / mean_shift)};
}

Observation networks_beat_forest(const Numbers& numbers) {
  const double forest = numbers.error_3d("forest");
  std::string text = fmt::format("forest {:.1f} mm", forest);
  bool holds = true;
  for (const std::string_view network : kPaperNetworks) {
    const double error = numbers.error_3d(network);
    holds = holds && error < forest;
    text += fmt::format(", {} {:.1f}", network, error);
  }
  return {holds, text};
}

Observation depth_bins_help_in_3d(const Numbers& numbers) {
  const double plain_3d = numbers.error_3d("heatmap2d");
  const double bins_3d = numbers.error_3d("heatmap25d");
  const double plain_2d = numbers.error_2d("heatmap2d");
  const double bins_2d = numbers.error_2d("heatmap25d");
  return {bins_3d < plain_3d && is_about_the_same(bins_2d, plain_2d),
          fmt::format("3D {:.1f} mm against {:.1f} ({}), 2D {:.2f} px against {:.2f} ({})", bins_3d, plain_3d,
                      change(bins_3d, plain_3d), bins_2d, plain_2d, change(bins_2d, plain_2d))};
}

Observation regression_beats_heat_maps(const Numbers& numbers) {
  const double regression = numbers.error_3d("regression");
  const double plain = numbers.error_3d("heatmap2d");
  const double bins = numbers.error_3d("heatmap25d");
  return {regression < plain && regression < bins,
          fmt::format("regression {:.1f} mm, heatmap2d {:.1f}, heatmap25d {:.1f}", regression, plain, bins)};
}

Observation pca_gains_nothing(const Numbers& numbers) {
  const double pca = numbers.error_3d("pca");
  const double regression = numbers.error_3d("regression");
  return {is_about_the_same(pca, regression),
          fmt::format("pca {:.1f} mm, regression {:.1f} ({})", pca, regression, change(pca, regression))};
}

Observation autoencoder_helps(const Numbers& numbers) {
  const double autoencoder = numbers.error_3d("autoencoder");
  const double regression = numbers.error_3d("regression");
  return {autoencoder < regression, fmt::format("autoencoder {:.1f} mm, regression {:.1f} ({})", autoencoder,
                                                regression, change(autoencoder, regression))};
}

std::vector<Rule> scia15_rules() {
  std::vector<std::string_view> all(kPaperNetworks.begin(), kPaperNetworks.end());
  all.insert(all.begin(), "forest");
  return {
      {"Mean shift gives the tightest segmentation, and generalises best over cameras.",
       "Its mean overlap r is the highest on the sequence of every sensor.",
       {"mean shift", "forest", "threshold"},
       {},
       tightest},
      {"Mean shift runs a magnitude faster than the segmentation forest.",
       "Its median time of a frame is at most a tenth.",
       {"mean shift", "forest"},
       {},
       a_magnitude_faster},
      {"The convolutional networks beat the regression forest.",
       "Each of the paper's five networks has a smaller mean 3D error.",
       {},
       all,
       networks_beat_forest},
      {"Bins of depth (heatmap25d) improve heat maps in 3D, and change nothing in 2D.",
       "The mean 3D error falls, and the 2D error stays within 5%.",
       {},
       {"heatmap2d", "heatmap25d"},
       depth_bins_help_in_3d},
      {"Direct regression does better than heat maps.",
       "Its mean 3D error is smaller than that of both kinds of heat map.",
       {},
       {"regression", "heatmap2d", "heatmap25d"},
       regression_beats_heat_maps},
      {"A linear sub-space (PCA) gains almost nothing.",
       "The mean 3D error stays within 5% of regression's.",
       {},
       {"pca", "regression"},
       pca_gains_nothing},
      {"A non-linear sub-space (auto-encoder) helps further.",
       "The mean 3D error is smaller than regression's.",
       {},
       {"autoencoder", "regression"},
       autoencoder_helps},
  };
}

}  // namespace

std::string name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::agrees:
      return "agrees";
    case Verdict::in_part:
      return "in part";
    case Verdict::disagrees:
      return "disagrees";
    default:
      return "not known";
  }
}

std::vector<Claim> scia15_claims(const ExperimentScores& scores) {
  std::vector<Claim> claims;
  for (const Rule& rule : scia15_rules()) claims.push_back(judged(rule, scores));
  return claims;
}

std::string claims_csv(const std::vector<Claim>& claims) {
  std::string csv = "claim,verdict,evidence\n";
  for (std::size_t i = 0; i < claims.size(); ++i) {
    csv += fmt::format("{},{},{}\n", i + 1, name_of(claims[i].verdict),
                       csv_field(joined(claims[i].evidence, "; ")));
  }
  return csv;
}

}  // namespace knuckle
