// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/shard.h"

#include <cstdlib>
#include <map>
#include <string>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;

TEST(Shard, IsReadFromItsText) {
  EXPECT_EQ(shard_from_text("0/1"), (Shard{0, 1}));
  EXPECT_EQ(shard_from_text("7/8"), (Shard{7, 8}));
  for (const char* const wrong : {"", "1", "/", "1/", "/2", "8/8", "-1/8", "1/0", "0/0", "1.5/8", "1/8x",
                                  " 1/8", "1/8/9", "9999999999/99999999999", "1/1e3"}) {
    EXPECT_THAT(error_of([&] { shard_from_text(wrong); }), HasSubstr("expected I/N")) << wrong;
  }
}

/// All parts together are the whole, in order, and none is longer than another by more than one.
TEST(Shard, PartsAreTheWhole) {
  for (const IndexRange whole : {IndexRange{0, 1}, {0, 10}, {7, 23}, {1'000'000'000 - 64, 64}}) {
    for (std::int64_t count = 1; count <= whole.count; ++count) {
      std::int64_t next = whole.first;
      for (std::int64_t number = 0; number < count; ++number) {
        const IndexRange part = part_of(whole, {number, count});
        ASSERT_EQ(part.first, next);
        ASSERT_GE(part.count, whole.count / count);
        ASSERT_LE(part.count, (whole.count + count - 1) / count);
        next = part.end();
      }
      ASSERT_EQ(next, whole.end());
    }
  }
  EXPECT_THAT(error_of([] { part_of({0, 3}, {0, 4}); }), HasSubstr("there are 3 frames"));
}

/// Variables of the environment during one test.
class SlurmTask : public ::testing::Test {
 protected:
  void TearDown() override {
    for (const char* const name : {"ID", "COUNT", "MIN", "MAX", "STEP"}) ::unsetenv(variable(name).c_str());
  }
  static std::string variable(const std::string& name) { return "SLURM_ARRAY_TASK_" + name; }
  static void set(const std::map<std::string, std::string>& values) {
    for (const auto& [name, value] : values) ::setenv(variable(name).c_str(), value.c_str(), 1);
  }
};

TEST_F(SlurmTask, IsTheShardOfAnArray) {
  set({{"ID", "3"}, {"COUNT", "8"}});
  EXPECT_EQ(shard_from_text("auto"), (Shard{3, 8}));
  set({{"ID", "7"}, {"MIN", "0"}, {"MAX", "7"}, {"STEP", "1"}});
  EXPECT_EQ(shard_from_text("auto"), (Shard{7, 8}));
  set({{"ID", "0"}, {"COUNT", "1"}, {"MAX", "0"}});
  EXPECT_EQ(shard_from_text("auto"), (Shard{0, 1}));
}

TEST_F(SlurmTask, OutsideOfAnArrayItSaysSo) {
  EXPECT_THAT(error_of([] { shard_from_text("auto"); }), HasSubstr("no task of a Slurm job array"));
  set({{"COUNT", "8"}});
  EXPECT_THAT(error_of([] { shard_from_text("auto"); }), HasSubstr("no task of a Slurm job array"));
  ::unsetenv(variable("COUNT").c_str());
  set({{"ID", "3"}});
  EXPECT_THAT(error_of([] { shard_from_text("auto"); }), HasSubstr("no task of a Slurm job array"));
}

/// Of some tasks of a larger array Slurm says their own count: their parts would be others.
TEST_F(SlurmTask, OfSomeTasksOfAnArrayItIsRefused) {
  using Variables = std::map<std::string, std::string>;
  const Variables all = {{"ID", "2"}, {"COUNT", "8"}, {"MIN", "0"}, {"MAX", "7"}, {"STEP", "1"}};
  for (const Variables& other : {Variables{{"ID", "8"}},
                                 {{"COUNT", "2"}, {"MIN", "2"}, {"MAX", "5"}},
                                 {{"COUNT", "2"}, {"MIN", "0"}, {"MAX", "2"}},
                                 {{"COUNT", "2"}, {"MIN", "2"}, {"MAX", "3"}},
                                 {{"COUNT", "4"}, {"MAX", "6"}, {"STEP", "2"}},
                                 {{"MIN", "1"}},
                                 {{"COUNT", "9"}},
                                 {{"STEP", "0"}}}) {
    set(all);
    set(other);
    EXPECT_THAT(error_of([] { shard_from_text("auto"); }),
                AllOf(HasSubstr("expected an array 0-(N-1)"), HasSubstr("say --shard I/N")));
  }
  set(all);
  EXPECT_EQ(shard_from_text("auto"), (Shard{2, 8}));
  set({{"STEP", "x"}});
  EXPECT_THAT(error_of([] { shard_from_text("auto"); }), HasSubstr("SLURM_ARRAY_TASK_STEP is 'x'"));
}

}  // namespace
}  // namespace knuckle
