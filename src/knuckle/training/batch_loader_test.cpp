// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/batch_loader.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "knuckle/core/testing.h"
#include "knuckle/net/net_testing.h"

namespace knuckle {
namespace {

using ::testing::Each;
using testing::error_of;
using ::testing::HasSubstr;
using testing::kTestJoints;
using testing::made_up_samples;
using testing::no_augmentation;

constexpr std::size_t kNumbers = kTestJoints * 3;

BatchPlan plan_of(const CubeSamples& samples, const AugmentationOptions& augmentation, int batch_size,
                  std::uint64_t seed) {
  return {std::make_shared<const CubeSampleViews>(std::vector{TrainingCrops{samples}}, augmentation),
          batch_size, seed};
}

/// How often each sample is in the batches [0, count); samples are told apart by their first joint's depth.
std::map<float, int> times_seen(const CubeSamples& samples, int batch_size, int count) {
  BatchPlan plan = plan_of(samples, no_augmentation(), batch_size, 3);
  std::map<float, int> times;
  for (int number = 0; number < count; ++number) {
    const TrainingBatch batch = plan.batch(number);
    for (std::size_t i = 2; i < batch.targets.size(); i += kNumbers) ++times[batch.targets[i]];
  }
  return times;
}

std::vector<int> counts_of(const std::map<float, int>& times) {
  std::vector<int> counts;
  for (const auto& [key, count] : times) counts.push_back(count);
  return counts;
}

TEST(BatchPlan, SeesEachSampleOnceBeforeAnyAgain) {
  const CubeSamples samples = made_up_samples(12);
  EXPECT_THAT(counts_of(times_seen(samples, 4, 3)), ::testing::AllOf(::testing::SizeIs(12), Each(1)));
  EXPECT_THAT(counts_of(times_seen(samples, 5, 12)), ::testing::AllOf(::testing::SizeIs(12), Each(5)));
}

TEST(BatchPlan, OfPartsMakesTheWholeBatch) {
  const CubeSamples samples = made_up_samples(7);
  BatchPlan whole = plan_of(samples, {}, 6, 3);
  for (const std::int64_t number : {0, 5}) {
    TrainingBatch put_together;
    for (const auto& [begin, end] : {std::pair(0, 1), std::pair(1, 4), std::pair(4, 6)}) {
      const TrainingBatch part = whole.part(begin, end).batch(number);
      put_together.inputs.insert(put_together.inputs.end(), part.inputs.begin(), part.inputs.end());
      put_together.targets.insert(put_together.targets.end(), part.targets.begin(), part.targets.end());
    }
    const TrainingBatch expected = whole.batch(number);
    EXPECT_EQ(put_together.inputs, expected.inputs);
    EXPECT_EQ(put_together.targets, expected.targets);
  }
}

TEST(CubeSampleViews, InAMirrorHaveNoJointsAndTellALeftHand) {
  const CubeSamples samples = made_up_samples(4);
  AugmentationOptions mirrors = no_augmentation();
  mirrors.mirrored_share = 0.5;
  const CubeSampleViews views({TrainingCrops{samples}}, mirrors, {.side = true});
  const CubeSampleViews straight({TrainingCrops{samples}}, no_augmentation());
  ASSERT_EQ(views.target_shape(), (std::vector<std::int64_t>{kTestJoints + 1, 3}));
  const auto side = static_cast<std::size_t>(views.input_shape()[1]);
  std::vector<float> input(side * side);
  std::vector<float> expected(side * side);
  std::vector<float> target(kNumbers + 3);
  std::vector<float> joints(kNumbers);
  int mirrored = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    views.view(1, random, input, target);
    Random same(seed);
    straight.view(1, same, expected, joints);
    const bool is_left = target[kNumbers] == 0.0f;
    mirrored += is_left ? 1 : 0;
    for (std::size_t row = 0; row < side; ++row) {
      for (std::size_t column = 0; column < side; ++column) {
        const std::size_t from = is_left ? side - 1 - column : column;
        ASSERT_EQ(input[row * side + column], expected[row * side + from]);
      }
    }
    for (std::size_t i = 0; i < kNumbers; ++i) {
      EXPECT_TRUE(is_left ? std::isnan(target[i]) : target[i] == joints[i]);
    }
  }
  EXPECT_GT(mirrored, 10);
  EXPECT_LT(mirrored, 30);
}

TEST(CubeSampleViews, NeedASet) {
  EXPECT_THAT(error_of([] { CubeSampleViews({}, {}); }), HasSubstr("there is no sample to train on"));
}

TEST(CubeSampleViews, NeedANetworkThatTellsSidesForMirrors) {
  const CubeSamples samples = made_up_samples(1);
  AugmentationOptions mirrors = no_augmentation();
  EXPECT_THAT(error_of([&] { CubeSampleViews({TrainingCrops{samples}}, mirrors, {.side = true}); }),
              HasSubstr("mirrored_share"));
  mirrors.mirrored_share = 0.1;
  EXPECT_THAT(error_of([&] { CubeSampleViews({TrainingCrops{samples}}, mirrors); }), HasSubstr("tells_side"));
}

/// As `made_up_samples`, of nothing: no joint is known.
CubeSamples made_up_things(std::int64_t count) {
  const CubeSamples hands = made_up_samples(count);
  CubeSamples things(count, kTestJoints, hands.patch(), hands.crop_px());
  const std::vector<float> unknown(kNumbers, static_cast<float>(kNaN));
  for (std::int64_t i = 0; i < count; ++i)
    things.set(i, {hands.sample(i).codes, unknown, hands.sample(i).centre_mm});
  things.finish();
  return things;
}

TEST(CubeSampleViews, OfThingsFollowThoseOfHandsAndSayThatTheyAreNone) {
  const CubeSamples hands = made_up_samples(3);
  const CubeSamples things = made_up_things(2);
  AugmentationOptions mirrors = no_augmentation();
  mirrors.mirrored_share = 0.5;
  const CubeSampleViews views({TrainingCrops{hands, &things}}, mirrors, {.side = true, .hand = true});
  EXPECT_EQ(views.size(), 5);
  ASSERT_EQ(views.target_shape(), (std::vector<std::int64_t>{kTestJoints + 2, 3}));
  const auto side = static_cast<std::size_t>(views.input_shape()[1]);
  std::vector<float> input(side * side);
  std::vector<float> target(kNumbers + 6);
  int mirrored_things = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (std::int64_t i = 0; i < 5; ++i) {
      Random random(seed);
      views.view(i, random, input, target);
      const float answer = target[kNumbers + 3];
      EXPECT_EQ(answer, i < 3 ? 1.0f : 0.0f);
      EXPECT_EQ(std::isnan(target[kNumbers]), i >= 3) << "a thing has no side";
      if (i < 3) continue;
      EXPECT_TRUE(
          std::all_of(target.begin(), target.begin() + kNumbers, [](float x) { return std::isnan(x); }));
      // The thing is the hand of that number, perhaps in a mirror.
      std::vector<float> straight(input.size());
      std::vector<float> joints(kNumbers);
      Random same(seed);
      CubeSampleViews({TrainingCrops{hands}}, no_augmentation()).view(i - 3, same, straight, joints);
      mirrored_things += straight == input ? 0 : 1;
    }
  }
  EXPECT_GT(mirrored_things, 8);
  EXPECT_LT(mirrored_things, 32);
}

TEST(CubeSampleViews, WhetherThereIsAHandIsLearnedFromThingsAlone) {
  const CubeSamples hands = made_up_samples(3);
  const CubeSamples things = made_up_things(2);
  EXPECT_THAT(error_of([&] {
                CubeSampleViews({TrainingCrops{hands, &things}}, no_augmentation());
              }),
              HasSubstr("there are 2 things, and [network] tells_hand is false"));
  EXPECT_THAT(error_of([&] { CubeSampleViews({TrainingCrops{hands}}, no_augmentation(), {.hand = true}); }),
              HasSubstr("there are 0 things, and [network] tells_hand is true"));
  CubeSamples large(1, kTestJoints, hands.patch(), hands.crop_px() + 2);
  const std::vector<std::uint8_t> codes(static_cast<std::size_t>(large.crop_px() * large.crop_px()), 255);
  const std::vector<float> unknown(kNumbers, static_cast<float>(kNaN));
  large.set(0, {codes, unknown, Point3(0, 0, 500)});
  large.finish();
  EXPECT_THAT(error_of([&] {
                CubeSampleViews({TrainingCrops{hands, &large}}, no_augmentation(), {.hand = true});
              }),
              HasSubstr("different sizes"));
}

/// Plans of two sets, the first of which has three quarters of the places.
class TwoSets : public ::testing::Test {
 protected:
  BatchPlan plan(std::uint64_t seed) const {
    return {std::make_shared<const CubeSampleViews>(
                std::vector{TrainingCrops{few_, nullptr, 3.0}, TrainingCrops{many_, nullptr, 1.0}},
                no_augmentation()),
            8, seed};
  }

  CubeSamples few_ = made_up_samples(3);
  CubeSamples many_ = made_up_samples(10);
};

TEST_F(TwoSets, GetTheirSharesWhateverTheirSizes) {
  BatchPlan dealt = plan(3);
  std::vector<int> times(13);
  for (std::int64_t place = 0; place < 400; ++place)
    ++times[static_cast<std::size_t>(dealt.sample_of(place))];
  EXPECT_THAT(std::vector(times.begin(), times.begin() + 3), Each(100)) << "300 places for 3";
  EXPECT_THAT(std::vector(times.begin() + 3, times.end()), Each(10)) << "100 places for 10";
}

TEST_F(TwoSets, AreDealtByTheSeedAlone) {
  BatchPlan dealt = plan(3);
  std::vector<std::int64_t> order;
  for (std::int64_t place = 0; place < 80; ++place) order.push_back(dealt.sample_of(place));
  BatchPlan same = plan(3);
  BatchPlan other = plan(4);
  bool differs = false;
  for (const std::int64_t place : {79, 3, 40, 0, 78}) {
    EXPECT_EQ(same.sample_of(place), order[static_cast<std::size_t>(place)]) << "without those before";
    differs |= other.sample_of(place) != order[static_cast<std::size_t>(place)];
  }
  EXPECT_TRUE(differs);
}

TEST_F(TwoSets, OneOfWhichIsEmptyOrOfAnotherSizeAreRefused) {
  const auto fault = [&](const CubeSamples& second) {
    return error_of([&] {
      CubeSampleViews({TrainingCrops{few_}, TrainingCrops{second}}, no_augmentation());
    });
  };
  EXPECT_THAT(fault(made_up_samples(0)), HasSubstr("no sample to train on"));
  CubeSamples of_more_joints(1, kTestJoints + 1, few_.patch(), few_.crop_px());
  const std::vector<float> unknown(kNumbers + 3, static_cast<float>(kNaN));
  of_more_joints.set(0, {few_.sample(0).codes, unknown, Point3(0, 0, 500)});
  of_more_joints.finish();
  EXPECT_THAT(fault(of_more_joints), HasSubstr("different sizes"));
}

TEST(BatchPlan, ABatchMayBeLargerThanTheSet) {
  EXPECT_THAT(counts_of(times_seen(made_up_samples(3), 9, 1)),
              ::testing::AllOf(::testing::SizeIs(3), Each(3)));
}

TEST(BatchPlan, EpochsHaveDifferentOrders) {
  const CubeSamples samples = made_up_samples(16);
  BatchPlan plan = plan_of(samples, no_augmentation(), 16, 3);
  EXPECT_NE(plan.batch(0).targets, plan.batch(1).targets);
}

TEST(BatchPlan, NeverShowsASampleInTheSameViewAgain) {
  const CubeSamples samples = made_up_samples(1);
  BatchPlan plan = plan_of(samples, {}, 2, 3);
  std::set<std::vector<float>> views;
  for (int number = 0; number < 4; ++number) {
    const std::vector<float> inputs = plan.batch(number).inputs;
    const auto middle = inputs.begin() + static_cast<std::ptrdiff_t>(inputs.size() / 2);
    views.insert({inputs.begin(), middle});
    views.insert({middle, inputs.end()});
  }
  EXPECT_EQ(views.size(), 8u);
}

TEST(BatchPlan, ABatchDependsOnItsNumberAndTheSeedAlone) {
  const CubeSamples samples = made_up_samples(10);
  BatchPlan plan = plan_of(samples, {}, 4, 3);
  for (int number = 0; number < 6; ++number) (void)plan.batch(number);
  BatchPlan fresh = plan_of(samples, {}, 4, 3);
  BatchPlan other = plan_of(samples, {}, 4, 4);
  for (const int number : {5, 0, 3}) {
    const TrainingBatch batch = plan.batch(number);
    EXPECT_EQ(batch.inputs, fresh.batch(number).inputs);
    EXPECT_EQ(batch.inputs.size(), 4u * 32 * 32);
    EXPECT_NE(batch.inputs, other.batch(number).inputs);
  }
}

TEST(BatchPlan, RefusesAnEmptySetAndOptionsOutOfRange) {
  const CubeSamples none = made_up_samples(0);
  EXPECT_THAT(error_of([&] { plan_of(none, {}, 4, 1); }), HasSubstr("no sample to train on"));
  EXPECT_THAT(error_of([] { CubeSampleViews(std::vector<TrainingCrops>{}, no_augmentation()); }),
              HasSubstr("no sample to train on"));
  const CubeSamples things = made_up_samples(2);
  EXPECT_THAT(error_of([&] {
                CubeSampleViews({TrainingCrops{none, &things}}, no_augmentation(), {.hand = true});
              }),
              HasSubstr("no sample to train on"))
      << "things alone are no set";
  const CubeSamples samples = made_up_samples(1);
  EXPECT_THAT(error_of([&] { plan_of(samples, {.rotation_deg = 200.0}, 4, 1); }), HasSubstr("rotation_deg"));
}

TEST(BatchLoader, GivesTheBatchesOfThePlanInOrderFromAnyStart) {
  const CubeSamples samples = made_up_samples(10);
  BatchPlan plan = plan_of(samples, {}, 4, 3);
  BatchLoader loader(plan_of(samples, {}, 4, 3), 7, 30);  // more than are made ahead
  for (int number = 7; number < 30; ++number) EXPECT_EQ(loader.next().inputs, plan.batch(number).inputs);
  EXPECT_THAT(error_of([&] { loader.next(); }), HasSubstr("no batch left"));
  EXPECT_GE(loader.waited_seconds(), 0.0);
}

TEST(BatchLoader, EndsWhileBatchesAreLeft) {
  const CubeSamples samples = made_up_samples(10);
  BatchLoader loader(plan_of(samples, {}, 4, 3), 0, 1000000000);
  EXPECT_EQ(loader.next().targets.size(), 4 * kNumbers);
}

}  // namespace
}  // namespace knuckle
