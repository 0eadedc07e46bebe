// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/contact_sheet.h"

#include <algorithm>

#include "knuckle/core/testing.h"
#include "knuckle/eval/metrics/eval_fixtures.h"
#include "knuckle/eval/pictures/drawing.h"

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using testing::error_of;
using testing::FakeSource;
using ::testing::HasSubstr;

TEST(ContactSheet, FramesAreSpreadFromTheFirstToTheLast) {
  EXPECT_THAT(spread_frames(10, 5, 8), ElementsAre(10, 11, 12, 13, 14));
  EXPECT_THAT(spread_frames(0, 101, 5), ElementsAre(0, 25, 50, 75, 100));
  EXPECT_THAT(spread_frames(7, 100, 1), ElementsAre(7));
  EXPECT_THAT(spread_frames(0, std::int64_t{1} << 40, 2), ElementsAre(0, (std::int64_t{1} << 40) - 1));
  EXPECT_THAT(error_of([] { spread_frames(0, 0, 4); }), HasSubstr("4 of 0 frames"));
  EXPECT_THAT(error_of([] { spread_frames(-1, 3, 4); }), HasSubstr("frames from -1 on"));
  EXPECT_THAT(error_of([] { spread_frames(0, 3, 0); }), HasSubstr("0 of 3 frames"));
}

TEST(ContactSheet, HasATileForEachFrame) {
  const FakeSource source(testing::example_truth(5));  // 64 x 48 pixels
  const Image<Rgb> sheet = contact_sheet(source, {0, 1, 2, 3, 4}, {3, 128});
  EXPECT_EQ(sheet.width(), 6 + 3 * (128 + 96 + 6));
  EXPECT_EQ(sheet.height(), 6 + 2 * (96 + 6));
  const Rgb paper = sheet(0, 0);
  const auto differs = [&](int column, int row) { return !(sheet(column, row) == paper); };
  EXPECT_TRUE(differs(6, 6));
  EXPECT_TRUE(differs(6 + 230, 6 + 102));
  EXPECT_FALSE(differs(6 + 2 * 230 + 60, 6 + 102 + 40)) << "the sixth place is empty";
}

TEST(ContactSheet, ShowsTheSkeletonWhereThereIsTruth) {
  const auto is_truth = [](const Rgb& pixel) { return pixel == kTruthColour; };
  const Image<Rgb> labelled = contact_sheet(FakeSource(testing::example_truth(1)), {0}, {1, 256});
  EXPECT_TRUE(std::ranges::any_of(labelled.pixels(), is_truth));
  const Image<Rgb> unlabelled = contact_sheet(FakeSource(), {0}, {1, 256});
  EXPECT_FALSE(std::ranges::any_of(unlabelled.pixels(), is_truth));
}

TEST(ContactSheet, ChecksItsOptions) {
  EXPECT_THAT(error_of([] { contact_sheet(FakeSource(), {0}, {0, 200}); }), HasSubstr("columns"));
  EXPECT_THAT(error_of([] { contact_sheet(FakeSource(), {0}, {8, 8}); }), HasSubstr("tile_width_px"));
  EXPECT_THAT(error_of([] { contact_sheet(FakeSource(), {}); }), HasSubstr("no frame"));
}

}  // namespace
}  // namespace knuckle
