// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/frame_note.h"

#include "knuckle/core/testing.h"
#include "knuckle/pipeline/estimate_all.h"

namespace knuckle {
namespace {

constexpr Landmark kPalm[] = {Landmark::palm};

FrameEstimate estimate_with(int hands, std::string_view status) {
  FrameEstimate estimate;
  estimate.status = status;
  for (int i = 0; i < hands; ++i) {
    HandEstimate hand;
    hand.pose = {{"palm1", kPalm}, {{10.0 + i, 20.0, 500.0}}, {0.25f * static_cast<float>(i + 1)}};
    estimate.hands.push_back(hand);
  }
  return estimate;
}

TEST(FrameNote, ALineReadsBackAsTheNote) {
  const FrameNote note = note_of(estimate_with(2, "unsure"), "broken");
  const FrameNote back = note_from_line(note_as_line(note));
  EXPECT_EQ(back.status, "unsure");
  EXPECT_EQ(back.fault, "broken");
  EXPECT_EQ(back.confidence, (std::vector<std::vector<float>>{{0.25f}, {0.5f}}));
  EXPECT_EQ(note_as_line(note), R"({"status":"unsure","fault":"broken","confidence":[[0.25],[0.5]]})");
  EXPECT_THAT(testing::error_of([] { note_from_line("{}"); }), ::testing::HasSubstr("journal was damaged"));
}

TEST(RunCounts, CountWhatTheNotesSay) {
  const std::vector<FrameNote> notes = {
      note_of(estimate_with(1, "")),      note_of(estimate_with(0, "nothing there")),
      note_of(estimate_with(2, kUnsure)), note_of(estimate_with(0, "x"), "first"),
      note_of(estimate_with(1, kUnsure)), note_of(estimate_with(0, "x"), "second"),
      note_of(estimate_with(1, ""))};
  const RunCounts counts = counts_of([&](const auto& visit) { std::ranges::for_each(notes, visit); });
  EXPECT_EQ(counts.frames, 7);
  EXPECT_EQ(counts.found, 4);
  EXPECT_EQ(counts.unsure, 2);
  EXPECT_EQ(counts.unreadable, 2);
  EXPECT_EQ(counts.first_fault, 3);
  EXPECT_EQ(counts.fault, "first");
  EXPECT_EQ(counts.most_hands, 2u);
}

TEST(PosesOf, AreThoseOfTheRankAndMissingWhereThereAreFewerHands) {
  const std::vector<FrameEstimate> frames = {estimate_with(2, ""), estimate_with(1, ""),
                                             estimate_with(0, "")};
  const Convention convention{"palm1", kPalm};
  const std::vector<HandPose> first = poses_of(frames, convention, 0);
  const std::vector<HandPose> second = poses_of(frames, convention, 1);
  ASSERT_EQ(first.size(), 3u);
  ASSERT_EQ(second.size(), 3u);
  EXPECT_EQ(first[0].joints[0].u, 10.0);
  EXPECT_EQ(first[1].joints[0].u, 10.0);
  EXPECT_TRUE(first[2].is_missing());
  EXPECT_EQ(second[0].joints[0].u, 11.0);
  EXPECT_TRUE(second[1].is_missing() && second[2].is_missing());
}

}  // namespace
}  // namespace knuckle
