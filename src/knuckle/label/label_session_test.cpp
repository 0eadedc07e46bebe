// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_session.h"

#include <chrono>
#include <future>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/label/label_mask.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

using ::testing::HasSubstr;
using Kind = LabelRequest::Kind;
using testing::ClosingHand;
using testing::mean_error_mm;
using testing::pose_of_points;

constexpr int kFrames = 9;

/// A session whose estimator is wrong by as much in every frame.
class LabelSessionTest : public ::testing::Test {
 protected:
  LabelSessionOptions options(bool estimates = true) {
    LabelSessionOptions options;
    options.author = "ann";
    options.now = [] { return "2026-11-23T17:40:58Z"; };
    if (estimates) options.estimate = testing::wrong_by_as_much(source_);
    return options;
  }
  static LabelRequest request(Kind kind, std::int64_t frame, std::int64_t revision,
                              Landmark landmark = Landmark::wrist) {
    LabelRequest request{.kind = kind, .hand = {frame}, .revision = revision};
    request.landmark = static_cast<std::size_t>(landmark);
    return request;
  }
  LabelRequest to_truth(std::int64_t frame, std::int64_t revision, Landmark landmark) const {
    LabelRequest move = request(Kind::move, frame, revision, landmark);
    move.point_mm = source_.truth(frame)[static_cast<std::size_t>(landmark)];
    return move;
  }
  double error_mm(LabelSession& session, std::int64_t frame) const {
    const LabelledFrame labelled = session.frame(frame);
    std::vector<ImagePoint> points(kSupersetSize);
    if (!labelled.hands.empty())
      std::ranges::transform(labelled.hands[0].landmarks, points.begin(), &LandmarkLabel::at);
    return mean_error_mm(points, source_.truth(frame));
  }

  testing::TemporaryFolder folder_;
  ClosingHand source_{kFrames};
  LabelJournal journal_{folder_ / "labels.jsonl", testing::closing_hand_head(kFrames)};
};

TEST_F(LabelSessionTest, AFrameIsEstimatedOnceAndKept) {
  LabelSession session(source_, journal_, options());
  const LabelledFrame labelled = session.frame(2);
  ASSERT_EQ(labelled.hands.size(), 1U);
  EXPECT_EQ(labelled.hands[0].state, LabelState::estimated);
  EXPECT_EQ(labelled.hands[0].author, "pipeline");
  EXPECT_TRUE(labelled.hands[0].fit);
  session.frame(2);
  EXPECT_EQ(journal_.book().find({2})->revision(), 1);
  EXPECT_THAT(testing::error_of([&] { session.frame(kFrames); }), HasSubstr("there is no frame 9"));
}

TEST_F(LabelSessionTest, WhoOpensAFrameThatIsBeingEstimatedWaitsForItsLabels) {
  std::promise<void> has_begun, may_end;
  LabelSessionOptions slow = options();
  slow.estimate = [&, estimate = slow.estimate](const Frame& frame) {
    has_begun.set_value();
    may_end.get_future().wait();
    return estimate(frame);
  };
  LabelSession session(source_, journal_, slow);
  auto prepared = std::async(std::launch::async, [&] { return session.prepare(); });
  has_begun.get_future().wait();
  auto opened = std::async(std::launch::async, [&] { return session.frame(0).hands.size(); });
  EXPECT_EQ(opened.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
  may_end.set_value();
  EXPECT_EQ(opened.get(), 1U);
  EXPECT_TRUE(prepared.get());
}

TEST_F(LabelSessionTest, AFrameThatCannotBeEstimatedKeepsNobodyWaiting) {
  LabelSessionOptions failing = options();
  failing.estimate = [](const Frame&) -> std::vector<EstimatedHand> { throw Error("no memory"); };
  LabelSession session(source_, journal_, failing);
  EXPECT_EQ(testing::error_of([&] { session.frame(0); }), "no memory");
  EXPECT_TRUE(session.frame(0).hands.empty());
}

TEST_F(LabelSessionTest, ACorrectionMovesTheOthersAndIsPinned) {
  LabelSession session(source_, journal_, options());
  session.frame(2);
  const LabelAnswer answer = session.apply(to_truth(2, 1, Landmark::index_tip));
  EXPECT_EQ(answer.remark, "");
  const LabelledHand& hand = answer.labelled.hands[0];
  EXPECT_EQ(hand.revision, 2);
  EXPECT_EQ(hand.state, LabelState::corrected);
  const auto tip = static_cast<std::size_t>(Landmark::index_tip);
  EXPECT_EQ(hand.landmarks[tip].state, LabelState::corrected);
  EXPECT_NEAR(hand.landmarks[tip].at.u, pose_of_points(source_.truth(2)).joints[tip].u, 1e-4);
  EXPECT_EQ(hand.landmarks[tip - 1].state, LabelState::estimated);
  EXPECT_EQ(hand.landmarks[tip - 1].since, 2) << "the model moved it";
  EXPECT_EQ(hand.author, "ann");
}

TEST_F(LabelSessionTest, MasksArePaintedUndoneAndReadAgain) {
  LabelSession session(source_, journal_, options());
  session.frame(2);
  const LabelAnswer outline = session.apply(request(Kind::outline, 2, 1));
  ASSERT_EQ(outline.remark, "");
  const auto mask = outline.labelled.hands[0].mask;
  ASSERT_TRUE(mask);
  const Image<std::uint8_t> pixels = pixels_of(*mask);
  const Frame frame = source_.read(2);
  EXPECT_GT(std::ranges::count(pixels.pixels(), 1), 500);
  EXPECT_EQ(pixels(0, 0), 0) << "the wall";
  LabelRequest stroke = request(Kind::brush, 2, 2);
  stroke.stroke = {.points = {{3, 3}, {20, 3}}, .radius_px = 2};
  const LabelAnswer painted = session.apply(stroke);
  EXPECT_EQ(pixels_of(*painted.labelled.hands[0].mask)(10, 3), 1);
  EXPECT_EQ(painted.labelled.hands[0].landmarks, outline.labelled.hands[0].landmarks);
  EXPECT_TRUE(session.apply(stroke).is_refused) << "of an old revision";
  session.apply(to_truth(2, 3, Landmark::index_tip));  // leaves the mask as it is
  const LabelBook read = read_label_file(journal_.path());
  EXPECT_EQ(*read.find({2})->newest().mask, *painted.labelled.hands[0].mask) << "in the file";
  session.apply(request(Kind::undo, 0, 0));
  EXPECT_EQ(*session.apply(request(Kind::undo, 0, 0)).labelled.hands[0].mask, *mask);
  EXPECT_EQ(session.apply(request(Kind::undo, 0, 0)).labelled.hands[0].mask, nullptr);
  EXPECT_EQ(read_label_file(journal_.path()).find({2})->newest().mask, nullptr);
  EXPECT_EQ(*session.apply(request(Kind::redo, 0, 0)).labelled.hands[0].mask, *mask);
  EXPECT_EQ(*read_label_file(journal_.path()).find({2})->newest().mask, *mask);
}

TEST_F(LabelSessionTest, AMaskNeedsNoLandmarksButItsOutlineDoes) {
  LabelSession session(source_, journal_, options(false));
  EXPECT_THAT(session.apply(request(Kind::outline, 1, 0)).remark, HasSubstr("three landmarks"));
  LabelRequest stroke = request(Kind::brush, 1, 0);
  stroke.stroke = {.points = {{30, 30}}, .radius_px = 5};
  stroke.is_preview = true;
  session.apply(stroke);
  EXPECT_EQ(journal_.book().find({1}), nullptr) << "a preview keeps nothing";
  stroke.is_preview = false;
  const LabelAnswer painted = session.apply(stroke);
  ASSERT_EQ(painted.labelled.hands.size(), 1U);
  EXPECT_EQ(painted.labelled.hands[0].state, LabelState::corrected);
  const LabelAnswer verified = session.apply(request(Kind::verify, 1, 1));
  EXPECT_EQ(verified.remark, "");
  EXPECT_EQ(verified.labelled.hands[0].state, LabelState::verified);
}

TEST_F(LabelSessionTest, WithoutTheModelRawPointsRemainRaw) {
  LabelSession session(source_, journal_, options());
  const LabelledHand before = session.frame(2).hands[0];
  LabelRequest move = to_truth(2, 1, Landmark::index_tip);
  move.uses_model = false;
  const LabelledHand after = session.apply(move).labelled.hands[0];
  for (std::size_t i = 0; i < after.landmarks.size(); ++i)
    EXPECT_EQ(after.landmarks[i] == before.landmarks[i], i != move.landmark) << i;
}

TEST_F(LabelSessionTest, AHiddenLandmarkThatIsShownOnAPixelTakesItsDepthFromTheModel) {
  LabelSession session(source_, journal_, options());
  session.frame(2);
  LabelRequest look = request(Kind::look, 2, 1, Landmark::thumb_tip);
  look.is_visible = false;
  session.apply(look);
  // Shown on the middle of the palm, which lies nearer or deeper than the thumb's tip.
  const auto truth = pose_of_points(source_.truth(2)).joints;
  LabelRequest place = request(Kind::place, 2, 2, Landmark::thumb_tip);
  place.u = truth[static_cast<std::size_t>(Landmark::palm)].u;
  place.v = truth[static_cast<std::size_t>(Landmark::palm)].v;
  const LabelledHand hand = session.apply(place).labelled.hands[0];
  const LandmarkLabel& label = hand.landmarks[place.landmark];
  EXPECT_FALSE(label.is_visible);
  EXPECT_NEAR(label.at.u, place.u, 1e-3);
  EXPECT_NEAR(label.at.depth_mm, truth[place.landmark].depth_mm, 12.0);
}

TEST_F(LabelSessionTest, APreviewKeepsNothing) {
  LabelSession session(source_, journal_, options());
  session.frame(2);
  LabelRequest move = to_truth(2, 1, Landmark::index_tip);
  move.is_preview = true;
  const LabelAnswer answer = session.apply(move);
  EXPECT_EQ(answer.labelled.hands[0].landmarks[move.landmark].state, LabelState::corrected);
  EXPECT_EQ(journal_.book().find({2})->revision(), 1);
  EXPECT_EQ(session.frame(2).hands[0].landmarks[move.landmark].state, LabelState::estimated);
}

TEST_F(LabelSessionTest, TheSecondOfTwoPagesIsToldAndNothingIsOverwritten) {
  LabelSession session(source_, journal_, options());
  session.frame(2);
  ASSERT_FALSE(session.apply(to_truth(2, 1, Landmark::index_tip)).is_refused);
  const LabelAnswer second = session.apply(to_truth(2, 1, Landmark::thumb_tip));
  EXPECT_TRUE(second.is_refused);
  EXPECT_THAT(second.remark, HasSubstr("changed elsewhere"));
  EXPECT_EQ(second.labelled.hands[0].revision, 2) << "it sees how they stand";
  EXPECT_EQ(journal_.book().find({2})->revision(), 2);
}

TEST_F(LabelSessionTest, UndoAndRedoSurviveTheEndOfTheProgram) {
  {
    LabelSession session(source_, journal_, options());
    session.frame(2);
    session.apply(to_truth(2, 1, Landmark::index_tip));
    session.apply(request(Kind::verify, 2, 2));
  }
  LabelSession session(source_, journal_, options());
  EXPECT_EQ(session.apply(request(Kind::undo, 0, 0)).labelled.hands[0].state, LabelState::corrected);
  EXPECT_EQ(session.apply(request(Kind::undo, 0, 0)).labelled.hands[0].state, LabelState::estimated);
  EXPECT_THAT(session.apply(request(Kind::undo, 0, 0)).remark, HasSubstr("nothing to undo"));
  session.apply(request(Kind::redo, 0, 0));
  EXPECT_EQ(session.apply(request(Kind::redo, 0, 0)).labelled.hands[0].state, LabelState::verified);
  EXPECT_THAT(session.apply(request(Kind::redo, 0, 0)).remark, HasSubstr("nothing to redo"));
}

TEST_F(LabelSessionTest, AHandIsLabelledFromNothing) {
  LabelSession session(source_, journal_, options(/*estimates=*/false));
  EXPECT_TRUE(session.frame(0).hands.empty());
  EXPECT_THAT(session.apply(request(Kind::verify, 0, 0)).remark, HasSubstr("nothing to verify"));
  std::int64_t revision = 0;
  for (const Landmark landmark :
       {Landmark::wrist, Landmark::index_mcp, Landmark::little_mcp, Landmark::thumb_tip, Landmark::index_tip,
        Landmark::middle_tip, Landmark::ring_tip, Landmark::little_tip})
    session.apply(to_truth(0, revision++, landmark));
  EXPECT_LT(error_mm(session, 0), 8.0);
}

TEST_F(LabelSessionTest, AVerifiedFramePullsItsNeighboursAndNotThoseThatAPersonTouched) {
  LabelSession session(source_, journal_, options());
  while (session.work()) {
  }
  std::vector<double> before;
  for (int i = 0; i < kFrames; ++i) before.push_back(error_mm(session, i));
  session.apply(to_truth(6, 1, Landmark::wrist));
  std::int64_t revision = 1;
  for (int i = 0; i < kSupersetSize; ++i) session.apply(to_truth(4, revision++, static_cast<Landmark>(i)));
  session.apply(request(Kind::verify, 4, revision));
  while (session.work()) {
  }
  EXPECT_LT(error_mm(session, 4), 0.1);
  for (const int neighbour : {3, 5}) {
    EXPECT_EQ(session.frame(neighbour).hands[0].state, LabelState::propagated);
    EXPECT_LT(error_mm(session, neighbour), before[static_cast<std::size_t>(neighbour)]) << neighbour;
  }
  EXPECT_EQ(session.frame(6).hands[0].state, LabelState::corrected);
  EXPECT_EQ(session.frame(6).hands[0].revision, 2) << "left as the person left it";
  EXPECT_EQ(session.frame(7).hands[0].state, LabelState::propagated) << "beyond it, too";
}

/// A hand that closes, cut in two.
class TwoSequences final : public FrameSource {
 public:
  std::int64_t size() const override { return kFrames; }
  Frame read(std::int64_t index) const override {
    Frame frame = hand_.read(index);
    frame.sequence = sequence_of(index);
    return frame;
  }
  FrameLabel read_label(std::int64_t index) const override {
    FrameLabel label = hand_.read_label(index);
    label.sequence = sequence_of(index);
    return label;
  }
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  static int sequence_of(std::int64_t index) { return index < 5 ? 0 : 1; }
  ClosingHand hand_{kFrames};
};

TEST_F(LabelSessionTest, AVerifiedFramePullsNoneOfAnotherSequence) {
  const TwoSequences source;
  LabelSession session(source, journal_, options());
  while (session.work()) {
  }
  std::int64_t revision = 1;
  for (int i = 0; i < kSupersetSize; ++i) session.apply(to_truth(4, revision++, static_cast<Landmark>(i)));
  session.apply(request(Kind::verify, 4, revision));
  while (session.work()) {
  }
  EXPECT_EQ(session.frame(3).hands[0].state, LabelState::propagated);
  EXPECT_EQ(session.frame(5).hands[0].state, LabelState::estimated);
}

TEST_F(LabelSessionTest, WhatHardlyMovesIsNotWrittenAgain) {
  LabelSession session(source_, journal_, options());
  while (session.work()) {
  }
  session.apply(request(Kind::verify, 4, 1));
  while (session.work()) {
  }
  const auto lines = journal_.book().find({3})->revision();
  session.apply(request(Kind::undo, 0, 0));
  session.apply(request(Kind::redo, 0, 0));
  session.apply(request(Kind::verify, 4, 4));
  while (session.work()) {
  }
  EXPECT_EQ(journal_.book().find({3})->revision(), lines);
}

TEST_F(LabelSessionTest, TheNextFrameIsTheMostDoubtfulOneThatIsNotVerified) {
  LabelSession session(source_, journal_, options());
  while (session.work()) {
  }
  std::set<std::int64_t> seen;
  std::int64_t at = 0;
  for (int i = 0; i < kFrames; ++i) {
    const auto next = session.proposed(at);
    ASSERT_TRUE(next);
    EXPECT_TRUE(seen.insert(*next).second) << "verified already";
    at = *next;
    session.apply(request(Kind::verify, at, journal_.book().find({at})->revision()));
  }
  EXPECT_FALSE(session.proposed(at)) << "all are verified";
}

TEST_F(LabelSessionTest, ChangesAreTold) {
  LabelSession session(source_, journal_, options());
  std::vector<std::int64_t> told;
  session.changed = [&](HandKey hand, std::int64_t revision) { told.push_back(10 * hand.frame + revision); };
  session.frame(2);
  session.apply(to_truth(2, 1, Landmark::index_tip));
  EXPECT_EQ(told, (std::vector<std::int64_t>{21, 22}));
}

TEST_F(LabelSessionTest, SecondsAddUp) {
  LabelSession session(source_, journal_, options());
  session.frame(2);
  LabelRequest move = to_truth(2, 1, Landmark::index_tip);
  move.seconds = 2.5;
  session.apply(move);
  LabelRequest verify = request(Kind::verify, 2, 2);
  verify.seconds = 1.5;
  EXPECT_EQ(session.apply(verify).labelled.hands[0].seconds, 4.0);
  EXPECT_EQ(session.seconds_of_verified(), std::vector<double>{4.0});
}

}  // namespace
}  // namespace knuckle
