// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/propagation_queue.h"

#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

constexpr int kQueueFrames = 12;

/// A book in which one landmark of each of these frames' right hands has that state.
LabelBook book_of(const std::vector<std::pair<std::int64_t, LabelState>>& frames) {
  LabelBook book(testing::closing_hand_head(kQueueFrames));
  for (const auto& [frame, state] : frames) {
    LabelChange change{.frame = frame};
    change.landmarks.resize(kSupersetSize);
    change.landmarks[0] = {.at = {10.0, 20.0, 500.0}, .state = state};
    book.add(std::move(change));
  }
  return book;
}

std::vector<std::int64_t> all_of(PropagationQueue& queue) {
  std::vector<std::int64_t> frames;
  while (const auto hand = queue.take()) frames.push_back(hand->frame);
  return frames;
}

TEST(PropagationQueue, WhatWaitedInAnEarlierSessionIsPutInAndWhatHasFollowedIsNot) {
  LabelBook book(testing::closing_hand_head(kQueueFrames));
  const auto add = [&](std::int64_t frame, std::int64_t revision, LabelAct act, LabelState state) {
    LabelChange change{.frame = frame, .revision = revision, .act = act};
    change.landmarks.resize(kSupersetSize);
    change.landmarks[0] = {.at = {10.0, 20.0, 500.0}, .state = state};
    book.add(std::move(change));
  };
  add(3, 1, LabelAct::propagate, LabelState::propagated);
  add(4, 1, LabelAct::verify, LabelState::verified);
  add(5, 1, LabelAct::propagate, LabelState::propagated);
  add(8, 1, LabelAct::import, LabelState::verified);
  PropagationQueue queue(2);
  queue.add_interrupted(book);
  EXPECT_EQ(all_of(queue), (std::vector<std::int64_t>{3, 2, 6})) << "5 has followed, 8 pulls nothing";
  add(1, 1, LabelAct::verify, LabelState::verified);
  queue.add_interrupted(book);
  EXPECT_EQ(all_of(queue), (std::vector<std::int64_t>{6, 0, 2, 3})) << "in the order of what was verified";
  queue.add_interrupted(book);
  EXPECT_EQ(all_of(queue).size(), 4U) << "each once, though put in before";
  add(1, 2, LabelAct::undo, LabelState::estimated);
  queue.add_interrupted(book);
  EXPECT_EQ(all_of(queue), (std::vector<std::int64_t>{3, 2, 6}))
      << "what is verified no longer pulls nothing";
}

TEST(PropagationQueue, TheNearestComeFirstAsFarAsTheReachAndTheFramesGo) {
  PropagationQueue queue(3);
  EXPECT_FALSE(queue.take());
  queue.add_neighbours({1, HandSide::left}, book_of({}));
  const auto first = queue.take();
  ASSERT_TRUE(first);
  EXPECT_EQ(*first, (HandKey{0, HandSide::left}));
  EXPECT_EQ(all_of(queue), (std::vector<std::int64_t>{2, 3, 4}));
  queue.add_neighbours({kQueueFrames - 1, HandSide::left}, book_of({}));
  EXPECT_EQ(all_of(queue), (std::vector<std::int64_t>{10, 9, 8}));
}

TEST(PropagationQueue, EndsAtTheNextVerifiedAndLeavesOutWhatAPersonTouched) {
  PropagationQueue queue(4);
  queue.add_neighbours({5}, book_of({{3, LabelState::verified},
                                     {4, LabelState::propagated},
                                     {6, LabelState::estimated},
                                     {7, LabelState::corrected}}));
  EXPECT_EQ(all_of(queue), (std::vector<std::int64_t>{4, 6, 8, 9}));
}

TEST(PropagationQueue, AHandWaitsOnceWhereItCameLast) {
  PropagationQueue queue(2);
  queue.add_neighbours({2}, book_of({}));
  queue.add_neighbours({4}, book_of({}));
  EXPECT_EQ(all_of(queue), (std::vector<std::int64_t>{1, 0, 4, 3, 5, 2, 6}));
}

}  // namespace
}  // namespace knuckle
