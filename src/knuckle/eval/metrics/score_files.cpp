// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/score_files.h"

#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace knuckle {
namespace {

using nlohmann::ordered_json;

/// Numbers that are not known become null.
ordered_json motion_json(const MotionScore& motion) {
  return {{"frames", motion.frames},
          {"acceleration_mm", motion.acceleration_mm},
          {"true_acceleration_mm", motion.true_acceleration_mm},
          {"acceleration_error_mm", motion.acceleration_error_mm},
          {"lag_frames", motion.lag_frames},
          {"jitter_mm", motion.jitter_mm},
          {"worst_jitter_mm", motion.worst_jitter_mm},
          {"bone_deviation", motion.bone_deviation}};
}

ordered_json method_json(const MethodScore& method) {
  ordered_json joints = ordered_json::array();
  ordered_json per_joint = ordered_json::array();
  for (const JointScore& joint : method.joints) {
    joints.push_back(name_of(joint.landmark));
    per_joint.push_back(joint.mean_3d_mm);
  }
  ordered_json within = ordered_json::object();
  for (std::size_t i = 0; i < kTableThresholdsMm.size(); ++i) {
    within[std::to_string(kTableThresholdsMm[i])] = method.frames_all_joints_within[i];
  }
  return {{"name", method.name},
          {"frames", method.frames},
          {"missing", method.missing},
          {"joints", joints},
          {"mean_3d_mm", method.mean_3d_mm},
          {"median_3d_mm", method.median_3d_mm},
          {"mean_2d_px", method.mean_2d_px},
          {"per_joint_3d_mm", per_joint},
          {"frames_all_joints_within", within},
          {"auc_pck_0_50", method.auc_pck_0_50},
          {"motion", motion_json(method.motion)}};
}

ordered_json difference_json(const MethodDifference& difference, const std::vector<MethodScore>& methods) {
  return {{"first", methods[difference.first].name},
          {"second", methods[difference.second].name},
          {"frames", difference.frames},
          {"mean_mm", difference.mean_mm},
          {"interval_95_mm", {difference.low_mm, difference.high_mm}},
          {"p_value", difference.p_value}};
}

ordered_json methods_json(const std::vector<MethodScore>& methods) {
  ordered_json all = ordered_json::array();
  for (const MethodScore& method : methods) all.push_back(method_json(method));
  return all;
}

ordered_json segmentation_json(const SegmentationScore& score) {
  ordered_json above = ordered_json::object();
  for (const std::size_t percent : {50U, 75U}) {  // the curve has a value per hundredth
    above[fmt::format("{:.2f}", score.threshold.at(percent))] = score.fraction_above.at(percent);
  }
  return {{"name", score.name},         {"frames", score.frames},         {"missing", score.missing},
          {"mean_iou", score.mean_iou}, {"median_iou", score.median_iou}, {"fraction_above", above}};
}

ordered_json reliability_json(const Reliability& reliability) {
  ordered_json bins = ordered_json::array();
  for (const ReliabilityBin& bin : reliability.bins)
    bins.push_back({{"joints", bin.joints}, {"confidence", bin.confidence}, {"within_20mm", bin.within}});
  return {{"joints", reliability.joints}, {"error", reliability.error}, {"bins", bins}};
}

/// Of what lies before at least one landmark.
ordered_json occlusion_json(const OcclusionScores& scores) {
  ordered_json all = ordered_json::object();
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const OcclusionScore& score = scores[i];
    if (score.joints == 0) continue;
    all[name_of(static_cast<Occluder>(i))] = {{"joints", score.joints},
                                              {"mean_3d_mm", score.mean_3d_mm},
                                              {"within_20mm", score.within},
                                              {"confidence", score.confidence}};
  }
  return all;
}

ordered_json followed_json(const FollowedScore& score) {
  return {{"name", score.name},
          {"frames", score.frames},
          {"hands", score.hands},
          {"found", score.found},
          {"right_side", score.right_side},
          {"invented", score.invented},
          {"switches", score.switches},
          {"losses", score.losses},
          {"longest_loss", score.longest_loss},
          {"mean_3d_mm", score.mean_3d_mm},
          {"occluders", occlusion_json(score.occlusion)},
          {"reliability", reliability_json(score.reliability)}};
}

}  // namespace

std::string to_json(const Evaluation& evaluation) {
  return to_json(evaluation, {});
}

std::string to_json(const std::optional<Evaluation>& evaluation, std::span<const SegmentationScore> boxes,
                    std::span<const FollowedScore> followed) {
  ordered_json all = ordered_json::object();
  if (evaluation) {
    all["convention"] = evaluation->convention.name;
    all["methods"] = methods_json(evaluation->methods);
    if (!evaluation->in_common.empty()) all["in_common"] = methods_json(evaluation->in_common);
    for (const MethodDifference& difference : evaluation->differences)
      all["differences"].push_back(difference_json(difference, evaluation->methods));
  }
  for (const SegmentationScore& score : boxes) all["segmentation"].push_back(segmentation_json(score));
  for (const FollowedScore& score : followed) all["followed"].push_back(followed_json(score));
  // A name may hold bytes that are no UTF-8: replaced, not refused.
  return all.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::string overlaps_csv(std::span<const SegmentationScore> boxes) {
  std::string text = "method,threshold,frames_above\n";
  for (const SegmentationScore& score : boxes) {
    for (std::size_t i = 0; i < score.threshold.size(); ++i) {
      fmt::format_to(std::back_inserter(text), "{},{:.2f},{:.6f}\n", csv_field(score.name),
                     score.threshold[i], score.fraction_above[i]);
    }
  }
  return text;
}

std::string curves_csv(const Evaluation& evaluation) {
  std::string text = "method,threshold_mm,frames_all_joints_within,frames_mean_within,joints_within\n";
  for (const MethodScore& method : evaluation.methods) {
    const ErrorCurves& curves = method.curves;
    for (std::size_t i = 0; i < curves.threshold_mm.size(); ++i) {
      fmt::format_to(std::back_inserter(text), "{},{},{:.6f},{:.6f},{:.6f}\n", csv_field(method.name),
                     curves.threshold_mm[i], curves.all_joints_within[i], curves.mean_within[i],
                     curves.joints_within[i]);
    }
  }
  return text;
}

std::string joints_csv(const Evaluation& evaluation) {
  std::string text = "method,joint,frames,mean_3d_mm,median_3d_mm,mean_2d_px,median_2d_px\n";
  for (const MethodScore& method : evaluation.methods) {
    for (const JointScore& joint : method.joints) {
      fmt::format_to(std::back_inserter(text), "{},{},{},{:.4f},{:.4f},{:.4f},{:.4f}\n",
                     csv_field(method.name), name_of(joint.landmark), joint.frames, joint.mean_3d_mm,
                     joint.median_3d_mm, joint.mean_2d_px, joint.median_2d_px);
    }
  }
  return text;
}

std::string frames_csv(const Evaluation& evaluation) {
  std::string text = "method,frame,mean_3d_mm,largest_3d_mm\n";
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{:.4f}", value) : ""; };
  for (const MethodScore& method : evaluation.methods) {
    for (std::size_t i = 0; i < method.frame_mean_3d_mm.size(); ++i) {
      fmt::format_to(std::back_inserter(text), "{},{},{},{}\n", csv_field(method.name), i,
                     number(method.frame_mean_3d_mm[i]), number(method.frame_largest_3d_mm[i]));
    }
  }
  return text;
}

}  // namespace knuckle
