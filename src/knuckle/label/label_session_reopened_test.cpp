// SPDX-License-Identifier: Apache-2.0
// A session that goes on with the labels of an earlier one, against one that was never interrupted.

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/label/label_session.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

using testing::ClosingHand;

constexpr int kReopenedFrames = 11;

void finish(LabelSession& session) {
  while (session.work()) {
  }
}

class ReopenedLabelSessionTest : public ::testing::Test {
 protected:
  LabelSessionOptions options() const {
    LabelSessionOptions options;
    options.now = [] { return "2026-11-23T17:40:58Z"; };
    options.estimate = testing::wrong_by_as_much(source_);
    return options;
  }
  /// All landmarks are put where they are, then the hand is verified.
  void verify(LabelSession& session, std::int64_t frame) const {
    std::int64_t revision = session.frame(frame).hands.at(0).revision;
    for (std::size_t i = 0; i < kSupersetSize; ++i) {
      session.apply({.kind = LabelRequest::Kind::move,
                     .hand = {frame},
                     .revision = revision++,
                     .landmark = i,
                     .point_mm = source_.truth(frame)[i]});
    }
    session.apply({.kind = LabelRequest::Kind::verify, .hand = {frame}, .revision = revision});
  }
  /// Largest distance between the labels of two books, in any frame [mm].
  static double largest_difference_mm(const LabelBook& one, const LabelBook& other) {
    const Projection projection(testing::kLabelCamera);
    double largest = 0.0;
    for (const auto& [hand, history] : one.hands()) {
      const auto& labels = history.newest().landmarks;
      const auto& of_other = other.find(hand)->newest().landmarks;
      for (std::size_t i = 0; i < labels.size(); ++i) {
        EXPECT_EQ(labels[i].state, of_other[i].state) << hand.frame;
        largest = std::max(
            largest, (projection.to_camera(labels[i].at) - projection.to_camera(of_other[i].at)).norm());
      }
    }
    return largest;
  }

  testing::TemporaryFolder folder_;
  ClosingHand source_{kReopenedFrames};
  LabelJournal journal_{folder_ / "labels.jsonl", testing::closing_hand_head(kReopenedFrames)};
  LabelJournal undisturbed_{folder_ / "undisturbed.jsonl", testing::closing_hand_head(kReopenedFrames)};
};

TEST_F(ReopenedLabelSessionTest, WhatWaitedToFollowFollows) {
  for (LabelJournal* const journal : {&journal_, &undisturbed_}) {
    LabelSession session(source_, *journal, options());
    finish(session);
    verify(session, 4);
    if (journal == &undisturbed_) finish(session);
  }
  ASSERT_EQ(journal_.book().find({3})->state(), LabelState::estimated);
  LabelSession reopened(source_, journal_, options());
  finish(reopened);
  EXPECT_EQ(journal_.book().find({3})->state(), LabelState::propagated);
  EXPECT_LT(largest_difference_mm(undisturbed_.book(), journal_.book()), 0.2);
}

TEST_F(ReopenedLabelSessionTest, VerifiedFramesOfYesterdayPullAsThoseOfToday) {
  LabelSession undisturbed(source_, undisturbed_, options());
  finish(undisturbed);
  verify(undisturbed, 2);
  finish(undisturbed);
  verify(undisturbed, 8);
  finish(undisturbed);
  {
    LabelSession session(source_, journal_, options());
    finish(session);
    verify(session, 2);
    finish(session);
  }
  LabelSession reopened(source_, journal_, options());
  verify(reopened, 8);
  finish(reopened);
  EXPECT_LT(largest_difference_mm(undisturbed_.book(), journal_.book()), 0.5);
}

TEST_F(ReopenedLabelSessionTest, DoubtsAndProposalsComeBackAndNothingIsWrittenAgain) {
  std::vector<double> doubts;
  std::optional<std::int64_t> proposed;
  {
    LabelSession session(source_, journal_, options());
    finish(session);
    verify(session, 2);
    finish(session);
    for (const FrameStanding& standing : session.standings()) doubts.push_back(standing.doubt_mm);
    proposed = session.proposed(2);
  }
  const std::string before = read_text_file(folder_ / "labels.jsonl");
  LabelSession reopened(source_, journal_, options());
  std::vector<std::int64_t> told;
  reopened.changed = [&](HandKey hand, std::int64_t) { told.push_back(hand.frame); };
  finish(reopened);
  EXPECT_EQ(read_text_file(folder_ / "labels.jsonl"), before);
  const std::vector<FrameStanding> standings = reopened.standings();
  for (std::size_t i = 0; i < standings.size(); ++i)
    EXPECT_NEAR(standings[i].doubt_mm, doubts[i], 0.1) << "frame " << i;
  EXPECT_EQ(reopened.proposed(2), proposed);
  EXPECT_EQ(told.size(), kReopenedFrames) << "of each it is told once that its doubt is known";
  EXPECT_EQ(told.front(), 2) << "the verified one comes first";
}

TEST_F(ReopenedLabelSessionTest, AFrameThatIsOpenedBeforeItsTurnIsAsDoubtfulAfterIt) {
  double doubt_mm = 0.0;
  {
    LabelSession session(source_, journal_, options());
    finish(session);
    verify(session, 2);
    finish(session);
    doubt_mm = session.standings()[4].doubt_mm;
  }
  LabelSession reopened(source_, journal_, options());
  reopened.frame(4);
  finish(reopened);
  EXPECT_NEAR(reopened.standings()[4].doubt_mm, doubt_mm, 0.1);
}

/// Counts what is asked of a source in which each frame is a sequence of its own.
class CountedSource final : public FrameSource {
 public:
  std::int64_t size() const override { return kMany; }
  Frame read(std::int64_t) const override {
    ++reads;
    Frame frame;
    frame.camera = testing::kLabelCamera;
    return frame;
  }
  FrameLabel read_label(std::int64_t index) const override {
    ++labels;
    return {.camera = testing::kLabelCamera, .truth = {}, .sequence = static_cast<int>(index)};
  }
  std::optional<Convention> convention() const override { return std::nullopt; }

  static constexpr int kMany = 1000;
  mutable int reads = 0;
  mutable int labels = 0;
};

TEST_F(ReopenedLabelSessionTest, OpeningManyVerifiedFramesReadsFewAndNoImage) {
  LabelJournal journal(folder_ / "many.jsonl", testing::closing_hand_head(CountedSource::kMany));
  const HandPose pose = testing::pose_of_points(source_.truth(0));
  std::vector<LabelChange> changes;
  for (int i = 0; i < CountedSource::kMany; ++i) {
    LabelChange& change = changes.emplace_back(LabelChange{.frame = i, .act = LabelAct::verify});
    for (const ImagePoint& joint : pose.joints)
      change.landmarks.push_back({.at = joint, .state = LabelState::verified});
  }
  journal.add_all(std::move(changes));
  const CountedSource source;
  const LabelSession session(source, journal, {});
  EXPECT_EQ(source.reads, 0);
  EXPECT_GT(source.labels, 0) << "bones are learned from the first";
  EXPECT_LT(source.labels, 100);
}

}  // namespace
}  // namespace knuckle
