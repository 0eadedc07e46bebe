// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/streamed_views.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/prepare/stream_testing.h"
#include "knuckle/training/batch_loader.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::made_up_samples;
using testing::MemoryStream;
using testing::no_augmentation;

constexpr int kBatch = 8;

bool are_equal(const TrainingBatch& a, const TrainingBatch& b) {
  const auto is_same = [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return a.inputs == b.inputs && std::ranges::equal(a.targets, b.targets, is_same);
}

/// Two sets in runs, the first with things.
class StreamedViewsTest : public ::testing::Test {
 protected:
  std::shared_ptr<const StreamedViews> views(const StreamingOptions& options) const {
    return std::make_shared<const StreamedViews>(std::vector{StreamedCrops{few_stream_, thing_stream_, 3.0},
                                                             StreamedCrops{many_stream_, nullptr, 1.0}},
                                                 AugmentationOptions{}, PatchQuestions{.hand = true},
                                                 options);
  }
  BatchPlan streamed(const StreamingOptions& options) const { return {views(options), kBatch, 3}; }
  BatchPlan in_memory() const {
    return {std::make_shared<const CubeSampleViews>(
                std::vector{TrainingCrops{few_, &things_, 3.0}, TrainingCrops{many_, nullptr, 1.0}},
                AugmentationOptions{}, PatchQuestions{.hand = true}),
            kBatch, 3};
  }

  CubeSamples few_ = made_up_samples(6);
  CubeSamples things_ = made_up_samples(5);
  CubeSamples many_ = made_up_samples(40);
  std::shared_ptr<MemoryStream> few_stream_ =
      std::make_shared<MemoryStream>(few_, std::vector<std::int64_t>{4, 2});
  std::shared_ptr<MemoryStream> thing_stream_ =
      std::make_shared<MemoryStream>(things_, std::vector<std::int64_t>{5});
  std::shared_ptr<MemoryStream> many_stream_ =
      std::make_shared<MemoryStream>(many_, std::vector<std::int64_t>{10, 10, 10, 10});
};

TEST_F(StreamedViewsTest, GiveTheBatchesOfMemoryWhereAWindowHoldsEachSet) {
  BatchPlan expected = in_memory();
  BatchPlan plan = streamed({.window = 100, .most_at_once = 20});
  for (const std::int64_t number : {0, 1, 9, 4})
    EXPECT_TRUE(are_equal(plan.batch(number), expected.batch(number)));
  std::vector<float> input(32 * 32);
  std::vector<float> target(45);
  TrainingBatch one = expected.batch(0);
  Random random(1);
  views({})->view(50, random, input, target);
  Random same(1);
  std::vector<float> expected_input(32 * 32);
  CubeSampleViews({TrainingCrops{many_}}, {}).view(39, same, expected_input, std::span(target).first(42));
  EXPECT_EQ(input, expected_input);
}

TEST_F(StreamedViewsTest, GiveTheSameBatchesHoweverManyAreReadAtOnceAndFromAnyStart) {
  BatchPlan plan = streamed({.window = 20, .most_at_once = 1});
  EXPECT_EQ(plan.most_at_once(), 1) << "a batch at least";
  EXPECT_EQ(streamed({.most_at_once = 16000}).most_at_once(), 2000);
  EXPECT_EQ(StreamedViews({{thing_stream_, nullptr, 1.0}}, {}, {}, {}).most_at_once(), 1024) << "in one run";
  for (const std::int64_t at_once : {1, 16, 40, 1000}) {
    for (const std::int64_t first : {0, 7}) {
      BatchLoader loader(streamed({.window = 20, .most_at_once = at_once}), first, 30);
      for (std::int64_t number = first; number < 30; ++number)
        ASSERT_TRUE(are_equal(loader.next(), plan.batch(number))) << number << ", " << at_once;
      EXPECT_THAT(error_of([&] { loader.next(); }), HasSubstr("no batch left"));
    }
  }
}

TEST_F(StreamedViewsTest, HoldNoMoreSamplesThanTwoReadings) {
  const auto views_of_24 = views({.window = 20, .most_at_once = 24});
  {
    BatchLoader loader(BatchPlan(views_of_24, kBatch, 3), 0, 50);
    for (int i = 0; i < 50; ++i) (void)loader.next();
  }
  EXPECT_LE(views_of_24->most_held(), 48);
  EXPECT_GT(views_of_24->most_held(), 0);
}

TEST_F(StreamedViewsTest, ReadForAPartOfEachBatchItsOwnSamplesAlone) {
  BatchPlan whole = streamed({.window = 20, .most_at_once = 24});
  const auto read = [&] { return few_stream_->fetched + thing_stream_->fetched + many_stream_->fetched; };
  for (const auto& [begin, end] : {std::pair(0, 2), std::pair(2, 8)}) {
    BatchPlan part = whole.part(begin, end);
    const std::int64_t before = read();
    const BatchSamples samples = part.fetched(5, 7);
    EXPECT_LE(read() - before, 2 * (end - begin));
    for (const std::int64_t number : {5, 6}) {
      const TrainingBatch batch = whole.batch(number);
      const auto pixels = static_cast<std::ptrdiff_t>(32 * 32);
      EXPECT_EQ(part.batch(number, samples).inputs, std::vector<float>(batch.inputs.begin() + begin * pixels,
                                                                       batch.inputs.begin() + end * pixels));
    }
  }
}

TEST_F(StreamedViewsTest, HandOnWhatReadingThrows) {
  many_stream_->breaks_at = 17;
  BatchLoader loader(streamed({.window = 20, .most_at_once = 16}), 0, 1000);
  EXPECT_THAT(error_of([&] {
                for (int i = 0; i < 1000; ++i) (void)loader.next();
              }),
              HasSubstr("sample 17 breaks"));
}

TEST_F(StreamedViewsTest, GiveOnlySamplesThatWereFetchedAndMissNone) {
  const auto all = views({});
  const auto some = all->fetched(std::vector<std::int64_t>{2, 9});
  std::vector<float> input(32 * 32);
  std::vector<float> target(45);
  Random random(1);
  EXPECT_NO_THROW(some->view(9, random, input, target));
  EXPECT_THAT(error_of([&] { some->view(3, random, input, target); }), HasSubstr("sample 3 was not fetched"));
  EXPECT_THAT(error_of([&] { some->view(10, random, input, target); }),
              HasSubstr("sample 10 was not fetched"));
  few_stream_->leaves_out = 2;
  EXPECT_THAT(error_of([&] {
                all->fetched(std::vector<std::int64_t>{2, 9});
              }),
              HasSubstr("1 samples were fetched, expected 2"));
}

TEST_F(StreamedViewsTest, EndWhileSamplesAreLeft) {
  BatchLoader loader(streamed({.window = 20, .most_at_once = 16}), 0, 1000000000);
  EXPECT_FALSE(loader.next().inputs.empty());
}

TEST_F(StreamedViewsTest, RefuseWhatViewsOfMemoryRefuse) {
  const auto fault = [&](std::vector<StreamedCrops> sets, const PatchQuestions& questions) {
    return error_of([&] { StreamedViews(std::move(sets), no_augmentation(), questions, {}); });
  };
  EXPECT_THAT(fault({}, {}), HasSubstr("no sample"));
  EXPECT_THAT(fault({{many_stream_, nullptr, 1.0}}, {.hand = true}), HasSubstr("tells_hand"));
  EXPECT_THAT(fault({{many_stream_, thing_stream_, 1.0}}, {}), HasSubstr("tells_hand"));
  const CubeSamples none = made_up_samples(0);
  EXPECT_THAT(fault({{std::make_shared<MemoryStream>(none, std::vector<std::int64_t>{}), nullptr, 1.0}}, {}),
              HasSubstr("no sample"));
  EXPECT_THAT(fault({{std::make_shared<MemoryStream>(none, std::vector<std::int64_t>{}), thing_stream_, 1.0}},
                    {.hand = true}),
              HasSubstr("no sample"))
      << "things alone are no set";
  CubeSamples other(1, 14, {16, 100.0}, 20);
  const std::vector<std::uint8_t> codes(20 * 20);
  const std::vector<float> joints(3 * 14);
  other.set(0, {codes, joints, Point3(0, 0, 500)});
  other.finish();
  EXPECT_THAT(
      fault({{many_stream_, nullptr, 1.0},
             {std::make_shared<MemoryStream>(other, std::vector<std::int64_t>{1}), many_stream_, 1.0}},
            {.hand = true}),
      HasSubstr("different sizes"));
}

}  // namespace
}  // namespace knuckle
