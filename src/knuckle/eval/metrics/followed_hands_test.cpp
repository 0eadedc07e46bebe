// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/followed_hands.h"

#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/eval/metrics/eval_fixtures.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using testing::error_of;
using testing::example_convention;
using ::testing::HasSubstr;

std::vector<Point3> landmarks_at(const Point3& place) {
  std::vector<Point3> points;
  for (int i = 0; i < example_convention().size(); ++i)
    points.emplace_back(place + Point3(i % 4, i / 4.0, 0.0));
  return points;
}

const Point3 kHere(0.0, 0.0, 500.0);
const Point3 kThere(200.0, 0.0, 500.0);

TrueHand hand_at(HandSide side, const Point3& place, double visible_share = 1.0) {
  return {side, landmarks_at(place), visible_share};
}

HandRecord found_at(int id, std::optional<HandSide> side, const Point3& place) {
  HandRecord hand;
  hand.id = id;
  hand.side = side;
  hand.convention = example_convention();
  hand.landmarks_mm = landmarks_at(place);
  hand.landmarks_px.resize(hand.landmarks_mm.size());
  return hand;
}

FrameRecord record_of(std::vector<HandRecord> hands) {
  FrameRecord record;
  record.hands = std::move(hands);
  return record;
}

FollowedScore score_of(const std::vector<TrueHands>& truth, const std::vector<FrameRecord>& records) {
  return followed_score("made up", example_convention(), truth, records);
}

TEST(FollowedHands, LandmarksCountByWhatLiesBeforeThemInTheHandsThatHadToBeFound) {
  TrueHand seen = hand_at(HandSide::right, kHere);
  seen.occluders.assign(seen.landmarks_mm.size(), Occluder::none);
  seen.occluders[4] = Occluder::object;
  TrueHand hardly = hand_at(HandSide::left, kThere, 0.1);
  hardly.occluders.assign(hardly.landmarks_mm.size(), Occluder::person);
  const FollowedScore score =
      score_of({{0, {seen, hardly}}}, {record_of({found_at(1, HandSide::right, kHere + Point3(0, 3, 0)),
                                                  found_at(2, HandSide::left, kThere)})});
  EXPECT_EQ(score.occlusion[0].joints, 19);
  EXPECT_NEAR(score.occlusion[0].mean_3d_mm, 3.0, 1e-12);
  EXPECT_EQ(score.occlusion[static_cast<std::size_t>(Occluder::object)].joints, 1);
  EXPECT_EQ(score.occlusion[static_cast<std::size_t>(Occluder::person)].joints, 0) << "it need not be found";
}

TEST(FollowedHands, EachIsFoundWithItsOwnSide) {
  const std::vector<TrueHands> truth(4,
                                     {0, {hand_at(HandSide::right, kHere), hand_at(HandSide::left, kThere)}});
  const Point3 beside(3.0, 4.0, 0.0);
  const std::vector<FrameRecord> records(
      4, record_of({found_at(2, HandSide::right, kThere + beside), found_at(1, HandSide::right, kHere)}));
  const FollowedScore score = score_of(truth, records);
  EXPECT_EQ(score.frames, 4);
  EXPECT_EQ(score.hands, 8);
  EXPECT_EQ(score.found, 8);
  EXPECT_EQ(score.right_side, 4);
  EXPECT_EQ(score.invented, 0);
  EXPECT_EQ(score.switches, 0);
  EXPECT_EQ(score.losses, 0);
  EXPECT_NEAR(score.mean_3d_mm, 2.5, 1e-9);
}

TEST(FollowedHands, WhatIsNoHandsOrAHandsSecondIsInvented) {
  const std::vector<TrueHands> truth{{0, {hand_at(HandSide::right, kHere)}}};
  const std::vector<FrameRecord> records{
      record_of({found_at(1, HandSide::right, kHere), found_at(2, HandSide::right, kHere + Point3(5, 0, 0)),
                 found_at(3, HandSide::left, kThere)})};
  const FollowedScore score = score_of(truth, records);
  EXPECT_EQ(score.found, 1);
  EXPECT_EQ(score.invented, 2);
  EXPECT_NEAR(score.mean_3d_mm, 0.0, 1e-9) << "the nearest counts";
}

TEST(FollowedHands, ExchangedIdsAreTwoSwitchesEachTime) {
  const std::vector<TrueHands> truth(6,
                                     {0, {hand_at(HandSide::right, kHere), hand_at(HandSide::left, kThere)}});
  std::vector<FrameRecord> records;
  for (int i = 0; i < 6; ++i) {
    const bool is_exchanged = i == 2 || i == 3;
    records.push_back(record_of({found_at(is_exchanged ? 2 : 1, HandSide::right, kHere),
                                 found_at(is_exchanged ? 1 : 2, HandSide::left, kThere)}));
  }
  EXPECT_EQ(score_of(truth, records).switches, 4);
}

TEST(FollowedHands, AHandThatIsFoundLaterOrAgainWasLost) {
  const std::vector<TrueHands> truth(10, {0, {hand_at(HandSide::right, kHere)}});
  std::vector<FrameRecord> records(10);
  for (const int i : {2, 3, 7, 8}) records[i] = record_of({found_at(i < 5 ? 1 : 2, HandSide::right, kHere)});
  const FollowedScore score = score_of(truth, records);
  EXPECT_EQ(score.found, 4);
  EXPECT_EQ(score.losses, 2) << "of the beginning, and of the middle; it never came back at the end";
  EXPECT_EQ(score.longest_loss, 3);
  EXPECT_EQ(score.switches, 1);
}

TEST(FollowedHands, HaveARecordForEachFrame) {
  const std::vector<TrueHands> truth(2);
  const std::vector<FrameRecord> records(3);
  EXPECT_THAT(error_of([&] { followed_score("mine", superset_convention(), truth, records); }),
              ::testing::HasSubstr("mine: 3 records, expected one for each of 2 frames"));
}

TEST(FollowedHands, AnotherSequenceBeginsAnew) {
  std::vector<TrueHands> truth(2, {0, {hand_at(HandSide::right, kHere)}});
  truth.push_back({1, {hand_at(HandSide::right, kHere)}});
  const std::vector<FrameRecord> records{record_of({found_at(1, HandSide::right, kHere)}), record_of({}),
                                         record_of({found_at(7, HandSide::right, kHere)})};
  const FollowedScore score = score_of(truth, records);
  EXPECT_EQ(score.switches, 0);
  EXPECT_EQ(score.losses, 0);
}

TEST(FollowedHands, AHiddenHandNeedNotBeFoundAndMay) {
  const std::vector<TrueHands> truth(
      2, {0, {hand_at(HandSide::right, kHere), hand_at(HandSide::left, kThere, 0.1)}});
  const std::vector<FrameRecord> records{
      record_of({found_at(1, HandSide::right, kHere)}),
      record_of({found_at(1, HandSide::right, kHere), found_at(2, HandSide::left, kThere)})};
  const FollowedScore score = score_of(truth, records);
  EXPECT_EQ(score.hands, 2);
  EXPECT_EQ(score.found, 2);
  EXPECT_EQ(score.invented, 0);
  EXPECT_EQ(score.losses, 0);
}

TEST(FollowedHands, LandmarksAreComparedByName) {
  const std::vector<TrueHands> truth{{0, {hand_at(HandSide::right, kHere)}}};
  HandRecord hand;
  hand.convention = superset_convention();
  hand.landmarks_mm.assign(static_cast<std::size_t>(hand.convention.size()), Point3(kNaN, kNaN, kNaN));
  for (int i = 0; i < example_convention().size(); ++i) {
    const int place = hand.convention.index_of(example_convention().landmarks[i]);
    if (place >= 0) hand.landmarks_mm[place] = truth[0].hands[0].landmarks_mm[i] + Point3(0, 0, 6);
  }
  const FollowedScore score = score_of(truth, {record_of({hand})});
  EXPECT_EQ(score.found, 1);
  EXPECT_NEAR(score.mean_3d_mm, 6.0, 1e-9);
  EXPECT_EQ(score.right_side, 0) << "no side is no right side";
}

TEST(FollowedHands, RecordsOfAFileMayPassFramesOverButComeInOrder) {
  const testing::TemporaryFolder folder;
  const auto file_of = [&](const std::vector<int>& frames) {
    std::string text;
    for (const int frame : frames) {
      FrameRecord record = record_of({found_at(frame + 1, HandSide::left, kHere)});
      record.frame = frame;
      text += to_json_line(record) + "\n";
    }
    write_text_file(folder / "records.jsonl", text);
    return folder / "records.jsonl";
  };
  const std::vector<FrameRecord> records = records_from_file(file_of({0, 2}), 4);
  ASSERT_EQ(records.size(), 4u);
  EXPECT_EQ(records[2].hands.at(0).id, 3);
  EXPECT_TRUE(records[1].hands.empty());
  EXPECT_THAT(error_of([&] {
                records_from_file(file_of({0, 2, 1}), 4);
              }),
              HasSubstr("records.jsonl:3: is of frame 1, expected one of 3 to 3"));
  EXPECT_THAT(error_of([&] { records_from_file(file_of({4}), 4); }), HasSubstr("records.jsonl:1"));
  write_text_file(folder / "records.jsonl", "no record\n");
  EXPECT_THAT(error_of([&] { records_from_file(folder / "records.jsonl", 4); }),
              HasSubstr("records.jsonl:1"));
}

TEST(FollowedHands, NeedATruth) {
  EXPECT_THAT(error_of([] { true_hands(testing::FakeSource()); }), HasSubstr("the source has no truth"));
}

}  // namespace
}  // namespace knuckle
