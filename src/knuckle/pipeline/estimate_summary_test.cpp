// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/estimate_summary.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace knuckle {
namespace {

HandEstimate hand_with(std::vector<float> confidence) {
  HandEstimate hand;
  hand.pose.confidence = std::move(confidence);
  return hand;
}

TEST(SummaryOfEstimates, HoldsTheConfidencesOfEachHand) {
  std::vector<FrameEstimate> frames(4);
  frames[0].hands = {hand_with({0.75f, 0.5f}), hand_with({0.25f, 0.12345f})};
  frames[1].hands = {hand_with({1.0f, 0.0f})};
  frames[2].status = "no hand";
  frames[3].hands = {hand_with({})};
  const Convention convention{"two", {}};
  const nlohmann::json summary = nlohmann::json::parse(summary_json(frames, "folder:x", convention));
  EXPECT_EQ(summary["confidence"], nlohmann::json::parse("[[0.75, 0.5], [1.0, 0.0], null, null]"));
  EXPECT_EQ(summary["confidence.hand2"], nlohmann::json::parse("[[0.25, 0.123], null, null, null]"));
  EXPECT_FALSE(summary.contains("confidence.hand3"));
  EXPECT_EQ(summary["found"], 3);
  EXPECT_EQ(summary["frames_without_hand"], nlohmann::json::parse(R"([{"frame": 2, "reason": "no hand"}])"));
}

TEST(SummaryOfEstimates, HoldsTheMedianOfEachStage) {
  std::vector<FrameEstimate> frames(3);
  for (FrameEstimate& frame : frames) frame.times = {1.0, 2.0, 4.0, 8.0};
  const nlohmann::json summary = nlohmann::json::parse(summary_json(frames, "folder:x", {"two", {}}));
  const nlohmann::json& medians = summary["median_ms"];
  EXPECT_NEAR(medians["segment"].get<double>(), 1.0, 0.002);
  EXPECT_NEAR(medians["patch"].get<double>(), 2.0, 0.004);
  EXPECT_NEAR(medians["estimate"].get<double>(), 4.0, 0.008);
  EXPECT_NEAR(medians["refine"].get<double>(), 8.0, 0.016);
  EXPECT_NEAR(medians["total"].get<double>(), 15.0, 0.03);
}

}  // namespace
}  // namespace knuckle
