// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_times.h"

#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

TEST(LabelTimes, AreThoseOfFramesInWhichAPersonWorked) {
  constexpr int kTimedFrames = 20;
  LabelBook book(testing::closing_hand_head(kTimedFrames));
  EXPECT_EQ(times_of(book).frames, 0);
  EXPECT_TRUE(std::isnan(times_of(book).median_s));
  const auto add = [&](HandKey hand, std::int64_t revision, LabelAct act, double seconds) {
    LabelChange change{
        .frame = hand.frame, .side = hand.side, .revision = revision, .act = act, .seconds = seconds};
    change.landmarks.resize(kSupersetSize);
    book.add(std::move(change));
  };
  for (int i = 0; i < 10; ++i) add({i}, 1, LabelAct::correct, i + 1.0);
  add({9}, 2, LabelAct::verify, 20.0);
  add({0, HandSide::left}, 1, LabelAct::correct, 2.0);
  add({15}, 1, LabelAct::estimate, 0.0);
  const LabelTimes times = times_of(book);
  EXPECT_EQ(times.frames, 10) << "what machines found is not work";
  EXPECT_EQ(times.total_s, 77.0);
  EXPECT_EQ(times.median_s, 5.5) << "of 2 3 3 4 5 6 7 8 9 30";
  EXPECT_EQ(times.percentile90_s, 9.0);
}

}  // namespace
}  // namespace knuckle
