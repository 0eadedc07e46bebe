// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/scale.h"

#include "knuckle/core/testing.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

TEST(ScaleTest, FollowsTheRules) {
  EXPECT_DOUBLE_EQ(scaled(400000, Scaling::amount, 0.01, 1), 4000);
  EXPECT_DOUBLE_EQ(scaled(4096, Scaling::size, 0.25, 1), 2048);
  EXPECT_DOUBLE_EQ(scaled(25, Scaling::depth, 1.0 / 16, 1), 21);
}

TEST(ScaleTest, TheWholeIsTheWhole) {
  for (const Scaling how : {Scaling::amount, Scaling::size, Scaling::depth}) {
    EXPECT_DOUBLE_EQ(scaled(12345, how, 1.0, 1), 12345);
  }
}

TEST(ScaleTest, StaysBetweenTheLeastAndTheWhole) {
  for (const double s : {1e-6, 0.01, 0.5, 1.0}) {
    for (const Scaling how : {Scaling::amount, Scaling::size, Scaling::depth}) {
      EXPECT_GE(scaled(100, how, s, 10), 10);
      EXPECT_LE(scaled(100, how, s, 10), 100);
      EXPECT_DOUBLE_EQ(scaled(4, how, s, 10), 4) << "nothing grows to what is least for others";
    }
  }
}

class ScaledSourceTest : public ::testing::Test {
 protected:
  ScaledSourceTest() {
    write_text_file(folder_ / "scene.toml",
                    "frames = 400\n[body]\npeople = 1\n[pose]\nmotion = \"smooth\"\n");
    source_ = "synthetic:" + (folder_ / "scene.toml").string();
  }

  TemporaryFolder folder_;
  std::string source_;
};

TEST_F(ScaledSourceTest, ATestSequenceIsSeenFromEndToEnd) {
  EXPECT_EQ(scaled_test_source(source_, 1.0), source_);
  EXPECT_EQ(scaled_test_source(source_, 0.25), source_ + "?count=100&step=4");
  EXPECT_EQ(scaled_test_source(source_, 0.001), source_ + "?count=10&step=40") << "the least";
  EXPECT_EQ(scaled_test_source(source_ + "?step=2&first=100", 0.1), source_ + "?first=100&count=15&step=20");
  EXPECT_EQ(open_source(scaled_test_source(source_, 0.03))->size(), 12);
  EXPECT_EQ(open_source(scaled_test_source(source_ + "?count=3", 0.01))->size(), 3)
      << "no more than there are";
}

TEST_F(ScaledSourceTest, WhereNoFrameIsLeftThereIsNothingToScale) {
  EXPECT_THAT(error_of([&] { scaled_test_source(source_ + "?first=400", 0.5); }),
              ::testing::HasSubstr("?first=400: of 400 frames none is left"));
}

TEST_F(ScaledSourceTest, TrainingTakesTheFirstFrames) {
  EXPECT_EQ(scaled_training_source(source_, 1.0), source_);
  EXPECT_EQ(scaled_training_source(source_, 0.1), source_ + "?count=40");
  EXPECT_EQ(scaled_training_source(source_ + "?first=300", 0.1), source_ + "?first=300&count=20");
}

}  // namespace
}  // namespace knuckle::testing
