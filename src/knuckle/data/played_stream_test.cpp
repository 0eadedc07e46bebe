// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/played_stream.h"

#include <chrono>
#include <cmath>

#include "knuckle/core/interruption.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Pointwise;

/// Frames with times and sequences; the one of the time 99 cannot be read.
class TimedSource final : public FrameSource {
 public:
  struct Row {
    std::optional<double> time_s;
    int sequence = 0;
  };
  explicit TimedSource(std::vector<Row> rows) : rows_(std::move(rows)) {}
  std::int64_t size() const override { return std::ssize(rows_); }
  Frame read(std::int64_t index) const override {
    const Row& row = rows_.at(static_cast<std::size_t>(index));
    if (row.time_s == 99.0) fail("frame {} is damaged", index);
    Frame frame;
    frame.name = std::to_string(index);
    frame.time_s = row.time_s;
    frame.sequence = row.sequence;
    return frame;
  }
  FrameLabel read_label(std::int64_t index) const override {
    const Row& row = rows_.at(static_cast<std::size_t>(index));
    return {.camera = {}, .truth = {}, .time_s = row.time_s, .sequence = row.sequence};
  }
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  std::vector<Row> rows_;
};

std::vector<double> due_times(double rate_hz, const std::vector<TimedSource::Row>& rows) {
  PlayClock clock(rate_hz);
  std::vector<double> due;
  for (const auto& [time_s, sequence] : rows)
    due.push_back(clock.due_s({.camera = {}, .truth = {}, .time_s = time_s, .sequence = sequence}));
  return due;
}

TEST(PlayClock, FramesAreDueAtTheirOwnTimesOrAtARate) {
  const std::vector<TimedSource::Row> rows{{5.0, 0},  {5.1, 0}, {5.4, 0}, {2.0, 1},
                                           {2.25, 1}, {{}, 1},  {3.0, 1}};
  const double step = 1.0 / 30.0;
  EXPECT_THAT(due_times(0.0, rows), Pointwise(DoubleNear(1e-12), {0.0, 0.1, 0.4, 0.4 + step, 0.65 + step,
                                                                  0.65 + 2 * step, 0.65 + 3 * step}));
  EXPECT_THAT(due_times(20.0, rows), Pointwise(DoubleNear(1e-12), {0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3}));
}

TEST(PlayedStream, GivesEachFrameWhenItIsDueAndNotBefore) {
  PlayedStream stream(std::make_unique<TimedSource>(std::vector<TimedSource::Row>{{1.0}, {1.02}, {1.06}}),
                      {});
  const auto begin = std::chrono::steady_clock::now();
  for (const double due_s : {0.0, 0.02, 0.06}) {
    const Frame frame = stream.next().value();
    EXPECT_NEAR(*frame.time_s, due_s, 1e-12);
    EXPECT_GE(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), due_s);
  }
  EXPECT_FALSE(stream.next());
  EXPECT_FALSE(stream.next());
}

TEST(PlayedStream, InALoopEachRoundIsASequenceAndTimeGoesOn) {
  PlayedStream stream(std::make_unique<TimedSource>(std::vector<TimedSource::Row>{{0.0, 0}, {0.0, 2}}),
                      {.rate_hz = 10000.0, .loop = 1});
  std::vector<int> sequences;
  double before = -1.0;
  for (int i = 0; i < 6; ++i) {
    const Frame frame = stream.next().value();
    EXPECT_EQ(frame.name, std::to_string(i % 2));
    sequences.push_back(frame.sequence);
    EXPECT_GT(*frame.time_s, before);
    before = *frame.time_s;
  }
  EXPECT_THAT(sequences, ElementsAre(0, 2, 3, 5, 6, 8));
}

TEST(PlayedStream, GoesOnAfterAFrameThatCannotBeRead) {
  PlayedStream stream(std::make_unique<TimedSource>(std::vector<TimedSource::Row>{{0.0}, {99.0}, {0.0}}),
                      {.rate_hz = 1000.0});
  EXPECT_EQ(stream.next()->name, "0");
  EXPECT_THAT(error_of([&] { stream.next(); }), HasSubstr("frame 1 is damaged"));
  EXPECT_EQ(stream.next()->name, "2");
  EXPECT_FALSE(stream.next());
}

TEST(PlayedStream, AFrameThatCannotBeReadTakesItsTimeAsWell) {
  PlayedStream stream(std::make_unique<TimedSource>(std::vector<TimedSource::Row>{{0.0}, {99.0}, {99.0}}),
                      {.rate_hz = 20.0});
  stream.next();
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THROW(stream.next(), Error);
  EXPECT_THROW(stream.next(), Error);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(95));
}

TEST(PlayedStream, ALoopEndsOnceNothingCanBeRead) {
  PlayedStream stream(std::make_unique<TimedSource>(std::vector<TimedSource::Row>{{99.0}, {99.0}}),
                      {.rate_hz = 1000.0, .loop = 1});
  EXPECT_THROW(stream.next(), Error);
  EXPECT_THROW(stream.next(), Error);
  EXPECT_FALSE(stream.next());
}

TEST(PlayedStream, EndsTheWaitWhereTheProgramIsAskedTo) {
  PlayedStream stream(std::make_unique<TimedSource>(std::vector<TimedSource::Row>{{0.0}, {3600.0}}), {});
  EXPECT_TRUE(stream.next());
  set_interrupted(true);
  EXPECT_THROW(stream.next(), Interrupted);
  set_interrupted(false);
}

TEST(PlayedStream, OptionsOutOfRangeAreRefused) {
  const auto made = [](const PlayOptions& options) {
    return error_of(
        [&] { PlayedStream(std::make_unique<TimedSource>(std::vector<TimedSource::Row>{{}}), options); });
  };
  EXPECT_THAT(made({.rate_hz = -1.0}), HasSubstr("rate"));
  EXPECT_THAT(made({.rate_hz = std::nan("")}), HasSubstr("rate"));
  EXPECT_THAT(made({.loop = 2}), HasSubstr("loop"));
}

}  // namespace
}  // namespace knuckle
