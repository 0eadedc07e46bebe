// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/learning_rate.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

LearningRateOptions schedule(const std::string& name) {
  LearningRateOptions options;
  options.learning_rate = 2.0;
  options.schedule = name;
  options.warm_up = 0.1;
  return options;
}

TEST(LearningRate, RisesEvenlyThroughTheWarmUp) {
  for (const std::string name : {"cosine", "step", "constant"}) {
    EXPECT_NEAR(learning_rate_at(schedule(name), 0.025), 0.5, 1e-12);
    EXPECT_NEAR(learning_rate_at(schedule(name), 0.05), 1.0, 1e-12);
    EXPECT_NEAR(learning_rate_at(schedule(name), 0.1), 2.0, 1e-12);
  }
}

TEST(LearningRate, CosineFallsToItsFinalShare) {
  const LearningRateOptions options = schedule("cosine");
  EXPECT_NEAR(learning_rate_at(options, 0.55), 2.0 * (0.01 + 0.99 * 0.5), 1e-12);
  EXPECT_NEAR(learning_rate_at(options, 1.0), 0.02, 1e-12);
  for (double progress = 0.1; progress < 0.99; progress += 0.01) {
    EXPECT_GT(learning_rate_at(options, progress), learning_rate_at(options, progress + 0.01));
  }
}

TEST(LearningRate, StepsAreEvenlySpread) {
  LearningRateOptions options = schedule("step");
  options.warm_up = 0.0;
  EXPECT_NEAR(learning_rate_at(options, 0.33), 2.0, 1e-12);
  EXPECT_NEAR(learning_rate_at(options, 0.34), 0.2, 1e-12);
  EXPECT_NEAR(learning_rate_at(options, 0.66), 0.2, 1e-12);
  EXPECT_NEAR(learning_rate_at(options, 0.67), 0.02, 1e-12);
  EXPECT_NEAR(learning_rate_at(options, 1.0), 0.02, 1e-12) << "the last step has the last rate";
}

TEST(LearningRate, ConstantStays) {
  EXPECT_EQ(learning_rate_at(schedule("constant"), 1.0), 2.0);
}

TEST(LearningRate, OptionsAreChecked) {
  LearningRateOptions options;
  options.schedule = "sudden";
  EXPECT_THAT(error_of([&] { check_options(options, "training"); }), HasSubstr("sudden"));
  options = {};
  options.warm_up = 1.0;
  EXPECT_THAT(error_of([&] { check_options(options, "training"); }), HasSubstr("warm_up"));
  options = {};
  options.learning_rate = 0.0;
  EXPECT_THAT(error_of([&] { check_options(options, "training"); }), HasSubstr("learning_rate"));
}

}  // namespace
}  // namespace knuckle
