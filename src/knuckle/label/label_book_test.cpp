// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_book.h"

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

using ::testing::HasSubstr;

LabelChange change_at(HandKey hand, std::int64_t revision, LabelAct act, double u) {
  LabelChange change{.frame = hand.frame, .side = hand.side, .revision = revision, .act = act};
  change.landmarks.resize(kSupersetSize);
  change.landmarks[0] = {.at = {u, 1, 500},
                         .state = act == LabelAct::estimate ? LabelState::estimated : LabelState::corrected};
  return change;
}

double u_of(const LabelBook& book, HandKey hand) {
  return book.find(hand)->newest().landmarks[0].at.u;
}

TEST(LabelBook, UndoAndRedoHaveNoEndAndGoOverAllHands) {
  LabelBook book(testing::closing_hand_head(4));
  Random random(3);
  std::vector<std::pair<HandKey, double>> before;  // how each hand stood before each step
  for (int i = 0; i < 200; ++i) {
    const HandKey hand{static_cast<std::int64_t>(random.below(4)),
                       random.below(2) == 0 ? HandSide::left : HandSide::right};
    const HandHistory* const history = book.find(hand);
    before.emplace_back(hand, history == nullptr ? kNaN : u_of(book, hand));
    book.add(change_at(hand, history == nullptr ? 1 : history->revision() + 1, LabelAct::correct, i));
  }
  std::vector<double> after;
  for (int i = 199; i >= 0; --i) {
    const auto& [hand, was] = before[static_cast<std::size_t>(i)];
    after.push_back(u_of(book, hand));
    auto undo = book.undone();
    ASSERT_TRUE(undo);
    book.add(*undo);
    if (std::isnan(was)) {
      EXPECT_TRUE(book.find(hand)->newest().landmarks[0].at.is_missing());
    } else {
      EXPECT_EQ(u_of(book, hand), was);
    }
  }
  EXPECT_FALSE(book.undone());
  for (int i = 0; i < 200; ++i) {
    auto redo = book.redone();
    ASSERT_TRUE(redo);
    book.add(*redo);
    EXPECT_EQ(u_of(book, before[static_cast<std::size_t>(i)].first),
              after[static_cast<std::size_t>(199 - i)]);
  }
  EXPECT_FALSE(book.redone());
}

TEST(LabelBook, WhatMachinesDoIsNotUndone) {
  LabelBook book(testing::closing_hand_head(4));
  book.add(change_at({1}, 1, LabelAct::estimate, 5));
  EXPECT_FALSE(book.undone());
  book.add(change_at({1}, 2, LabelAct::correct, 6));
  book.add(*book.undone());
  EXPECT_EQ(u_of(book, {1}), 5);
  book.add(change_at({1}, 4, LabelAct::correct, 7));
  EXPECT_FALSE(book.redone()) << "something new was done since";
  EXPECT_EQ(book.find({1})->estimate()->revision, 3) << "undone to what the estimator said";
}

TEST(LabelBook, ARevisionThatIsNotTheNextIsRefused) {
  LabelBook book(testing::closing_hand_head(4));
  book.add(change_at({1}, 1, LabelAct::correct, 5));
  for (const std::int64_t revision : {1, 3})
    EXPECT_THAT(testing::error_of([&] { book.add(change_at({1}, revision, LabelAct::correct, 6), "x:9"); }),
                HasSubstr("x:9: revision"));
  EXPECT_THAT(testing::error_of([&] { book.add(change_at({1}, 2, LabelAct::redo, 6), "x:9"); }),
              HasSubstr("x:9: 'redo'"));
  // The left hand of the frame was not changed last.
  book.add(change_at({1, HandSide::left}, 1, LabelAct::estimate, 5));
  EXPECT_THAT(testing::error_of([&] {
                book.add(change_at({1, HandSide::left}, 2, LabelAct::undo, 6), "x:9");
              }),
              HasSubstr("x:9: 'undo' of something that was not done last"));
  EXPECT_EQ(book.find({1})->revision(), 1);
}

TEST(LabelBook, AChangeHasTheLandmarksOfTheLabels) {
  LabelBook book(testing::closing_hand_head(4));
  LabelChange change = change_at({1}, 1, LabelAct::correct, 5);
  change.landmarks.pop_back();
  EXPECT_THAT(testing::error_of([&] { book.add(change, "x:9"); }),
              HasSubstr("x:9: 21 landmarks, expected 22"));
  EXPECT_EQ(book.find({1}), nullptr);
}

TEST(LabelBook, AnotherHeadIsOfTheSameConvention) {
  LabelBook book(testing::closing_hand_head(4));
  LabelHead other = testing::closing_hand_head(4);
  other.convention = convention_from_name("icg20");
  EXPECT_THAT(testing::error_of([&] { book.take_head(other, "x:9"); }),
              HasSubstr("x:9: another number of frames or convention"));
}

TEST(LabelBook, EachLandmarkSaysSinceWhenItIsAsItIs) {
  LabelBook book(testing::closing_hand_head(4));
  book.add(change_at({1}, 1, LabelAct::correct, 5));
  LabelChange next = change_at({1}, 2, LabelAct::correct, 5);
  next.landmarks[4] = {.at = {1, 2, 3}};
  book.add(next);
  EXPECT_EQ(book.find({1})->newest().landmarks[0].since, 1);
  EXPECT_EQ(book.find({1})->newest().landmarks[4].since, 2);
}

TEST(LabelBook, ATornLastLineIsLeftOutWhereverItIsCut) {
  std::string text = to_json_line(testing::closing_hand_head(4)) + "\n";
  std::vector<std::size_t> ends{text.size()};
  for (int i = 1; i <= 3; ++i) {
    text += to_json_line(change_at({2}, i, LabelAct::correct, i), superset_convention()) + "\n";
    ends.push_back(text.size());
  }
  for (std::size_t size = 0; size <= text.size(); size += size + 7 < text.size() ? 7 : 1) {
    const auto read = read_labels(std::string_view(text).substr(0, size), "labels.jsonl");
    const auto whole = std::ranges::count_if(ends, [&](std::size_t end) { return end <= size; });
    ASSERT_EQ(read.has_value(), whole > 0) << size;
    if (!read) continue;
    EXPECT_EQ(read->whole_bytes, ends[static_cast<std::size_t>(whole - 1)]);
    const HandHistory* const history = read->book.find({2});
    EXPECT_EQ(history == nullptr ? 0 : history->revision(), whole - 1);
  }
}

TEST(LabelBook, ADamagedLineBeforeTheLastIsNamed) {
  const std::string head = to_json_line(testing::closing_hand_head(4)) + "\n";
  EXPECT_THAT(testing::error_of([&] { (void)read_labels(head + "{}\n", "a/labels.jsonl"); }),
              HasSubstr("a/labels.jsonl:2: lacks the key"));
  EXPECT_THAT(testing::error_of([&] { (void)read_labels("nothing\n", "a"); }), HasSubstr("a:1: not JSON"));
  LabelHead other = testing::closing_hand_head(9);
  EXPECT_THAT(testing::error_of([&] { (void)read_labels(head + to_json_line(other) + "\n", "a"); }),
              HasSubstr("a:2: another number of frames"));
}

}  // namespace
}  // namespace knuckle
