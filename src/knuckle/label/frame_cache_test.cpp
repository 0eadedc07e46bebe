// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/frame_cache.h"

#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

TEST(FrameCache, KeepsTheLastFramesAndNoMore) {
  const testing::ClosingHand source(3);
  FrameCache cache(source, 2);
  const auto first = cache.read(0);
  EXPECT_EQ(cache.read(0), first);
  cache.read(1);
  EXPECT_EQ(cache.read(0), first);
  cache.read(2);
  EXPECT_NE(cache.read(0), first) << "it was read longest ago";
  EXPECT_EQ(first->name, "000000") << "whoever has it keeps it";
  EXPECT_THAT(testing::error_of([&] { cache.read(3); }), ::testing::HasSubstr("there is no frame 3"));
  EXPECT_THAT(testing::error_of([&] { cache.read(-1); }), ::testing::HasSubstr("there is no frame -1"));
}

}  // namespace
}  // namespace knuckle
