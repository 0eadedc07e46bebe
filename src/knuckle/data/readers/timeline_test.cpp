// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/timeline.h"

#include <cmath>
#include <limits>

#include "knuckle/core/testing.h"
#include "knuckle/data/readers/data_testing.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;
using testing::put_file;

class TimelineTest : public ::testing::Test {
 protected:
  Timeline read(std::int64_t count, double rate_hz = 0.0) const {
    return read_timeline(folder.path(), count, rate_hz);
  }
  std::string fault(std::int64_t count) const {
    return error_of([&] { read(count); });
  }

  testing::TemporaryFolder folder;
  fs::path times = folder / "times.txt";
  fs::path sequences = folder / "sequences.txt";
};

TEST_F(TimelineTest, WithoutFilesAllFramesAreOfOneSequenceAtUnknownTimes) {
  const Timeline timeline = read(3);
  EXPECT_EQ(timeline.time_s(2), std::nullopt);
  EXPECT_EQ(timeline.sequence(2), 0);
}

TEST_F(TimelineTest, ARateGivesEachSequenceTimesFromZero) {
  put_file(sequences, "0\n2\n");
  const Timeline timeline = read(4, 10.0);
  EXPECT_THAT(timeline.times_s, ElementsAre(0.0, 0.1, 0.0, 0.1));
  EXPECT_THAT(timeline.sequences, ElementsAre(0, 0, 1, 1));
}

TEST_F(TimelineTest, TimesGoBeforeTheRate) {
  put_file(times, "# seconds\n1.5\n\n1.75\r\n1.75");
  const Timeline timeline = read(3, 10.0);
  EXPECT_THAT(timeline.times_s, ElementsAre(1.5, 1.75, 1.75));
}

TEST_F(TimelineTest, ATimeMayGoBackWhereASequenceStarts) {
  put_file(times, "5\n6\n0\n1\n");
  EXPECT_THAT(fault(4),
              AllOf(HasSubstr("times.txt:3: the time goes back from 6 to 0"), HasSubstr("sequence")));
  put_file(sequences, "0\n2\n");
  EXPECT_EQ(read(4).time_s(2), 0.0);
}

TEST_F(TimelineTest, RefusesTimesThatAreNone) {
  put_file(times, "0\nnan\n");
  EXPECT_THAT(fault(2), HasSubstr("times.txt:2: the time is nan"));
  put_file(times, "inf\n1\n");
  EXPECT_THAT(fault(2), HasSubstr("times.txt:1: the time is inf"));
  put_file(times, "0\nsoon\n");
  EXPECT_THAT(fault(2), HasSubstr("times.txt:2: expected a number, found 'soon'"));
  put_file(times, "0\n1 2\n");
  EXPECT_THAT(fault(2), HasSubstr("times.txt:2: expected a number"));
}

TEST_F(TimelineTest, ALongFileIsReadNoFurtherThanToItsFault) {
  put_file(sequences, "0\n0\n" + std::string(std::size_t{2} << 20, '1'));
  EXPECT_THAT(fault(2), HasSubstr("sequences.txt:2: frame 0 is not after 0"));
}

TEST_F(TimelineTest, TimesBeyondTheLastImageAreCountedAlone) {
  put_file(times, "0\n1\nsoon\n\n3\n");
  EXPECT_THAT(fault(2), HasSubstr("times.txt: has 4 times, but there are 2 depth images"));
}

TEST_F(TimelineTest, RefusesTooFewAndTooManyTimes) {
  put_file(times, "0\n1\n");
  EXPECT_THAT(fault(3), HasSubstr("times.txt: has 2 times, but there are 3 depth images"));
  EXPECT_THAT(fault(1), HasSubstr("times.txt: has 2 times, but there are 1 depth images"));
  put_file(times, "");
  EXPECT_THAT(fault(1), HasSubstr("times.txt: has 0 times"));
}

TEST_F(TimelineTest, RefusesSequencesThatDoNotAscendFromZeroWithinTheSet) {
  put_file(sequences, "1\n2\n");
  EXPECT_THAT(fault(4), HasSubstr("sequences.txt:1: the first sequence starts at frame 1, expected 0"));
  put_file(sequences, "0\n3\n2\n");
  EXPECT_THAT(fault(4), HasSubstr("sequences.txt:3: frame 2 is not after 3"));
  put_file(sequences, "0\n2\n2\n");
  EXPECT_THAT(fault(4), HasSubstr("sequences.txt:3: frame 2 is not after 2"));
  put_file(sequences, "0\n# the end\n4\n");
  EXPECT_THAT(fault(4), HasSubstr("sequences.txt:3: there is no frame 4: the set has 4"));
  put_file(sequences, "0\n1.5\n");
  EXPECT_THAT(fault(4), HasSubstr("sequences.txt:2: expected a whole number"));
  put_file(sequences, "\n");
  EXPECT_THAT(fault(4), HasSubstr("sequences.txt: is empty"));
}

TEST_F(TimelineTest, ReadsWhatWasWrittenToTheBit) {
  Timeline timeline{{1.0 / 3.0, 1e9 + 1e-6, 0.0, 0.1}, {4, 4, 7, 7}};
  write_timeline(folder.path(), timeline);
  const Timeline back = read(4);
  EXPECT_EQ(back.times_s, timeline.times_s);
  EXPECT_THAT(back.sequences, ElementsAre(0, 0, 1, 1));
}

TEST_F(TimelineTest, WritesNoFileThatSaysNothing) {
  write_timeline(folder.path(), {{}, {2, 2, 2}});
  EXPECT_FALSE(fs::exists(times));
  EXPECT_FALSE(fs::exists(sequences));
}

TEST_F(TimelineTest, WritesNothingFaulty) {
  EXPECT_THAT(error_of([&] {
                write_timeline(folder.path(), {{1.0, 0.5}, {0, 0}});
              }),
              AllOf(HasSubstr(folder.path().string()), HasSubstr("frame 1: the time goes back")));
  EXPECT_THAT(error_of([&] {
                write_timeline(folder.path(), {{}, {1, 0}});
              }),
              HasSubstr("frame 1: the sequence is 0"));
  EXPECT_THAT(error_of([&] {
                write_timeline(folder.path(), {{}, {-1}});
              }),
              HasSubstr("frame 0: the sequence is -1"));
}

TEST_F(TimelineTest, KnowsARegularRate) {
  EXPECT_EQ(regular_rate_hz({{0.0, 1.0 / 30, 2.0 / 30, 5.0, 5.0 + 1.0 / 30}, {0, 0, 0, 1, 1}}), 30.0);
  EXPECT_EQ(regular_rate_hz({{0.0, 0.1, 0.3}, {}}), std::nullopt);
  EXPECT_EQ(regular_rate_hz({{0.0, 0.0}, {}}), std::nullopt);
  EXPECT_EQ(regular_rate_hz({{0.0, 0.1}, {0, 1}}), std::nullopt);
  EXPECT_EQ(regular_rate_hz({}), std::nullopt);
}

}  // namespace
}  // namespace knuckle
