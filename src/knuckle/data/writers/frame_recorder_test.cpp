// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/frame_recorder.h"

#include <chrono>
#include <cmath>
#include <thread>

#include "knuckle/core/interruption.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/data/readers/folder_source.h"
#include "knuckle/data/readers/h5_source.h"
#include "knuckle/storage/flush_testing.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::TemporaryFolder;

constexpr Camera kCamera{.width = 24, .height = 18, .fx = 20.125, .fy = -21.25, .cx = 11.5, .cy = 8.75};

/// Noise in whole multiples of a unit, with holes.
std::shared_ptr<Frame> frame_of(int number, double unit_mm = 1.0, bool has_infrared = true) {
  auto frame = std::make_shared<Frame>();
  Random random(4, static_cast<std::uint64_t>(number));
  frame->camera = kCamera;
  frame->depth_mm = Image<float>(kCamera.width, kCamera.height);
  for (float& depth : frame->depth_mm.pixels()) {
    const std::uint64_t count = random.below(65536);
    depth = count % 7 == 0 ? 0.0f : static_cast<float>(static_cast<double>(count) * unit_mm);
  }
  if (has_infrared) {
    frame->infrared = Image<std::uint16_t>(kCamera.width, kCamera.height);
    for (std::uint16_t& value : frame->infrared.pixels())
      value = static_cast<std::uint16_t>(random.below(65536));
  }
  frame->time_s = 12.3456789 + number / 29.97;
  return frame;
}

std::vector<std::string> record(const fs::path& path, const std::vector<std::shared_ptr<Frame>>& frames) {
  FrameRecorder recorder(path);
  for (const auto& frame : frames) recorder.put(frame);
  return recorder.finish();
}

void expect_same(const Frame& read, const Frame& recorded) {
  EXPECT_EQ(read.camera, recorded.camera);
  EXPECT_EQ(read.depth_mm, recorded.depth_mm);
  EXPECT_EQ(read.infrared, recorded.infrared);
  EXPECT_EQ(read.time_s, recorded.time_s);
}

/// Each unit that cameras have, into a file and into a folder.
class RecorderUnits : public ::testing::TestWithParam<double> {};

TEST_P(RecorderUnits, WhatWasRecordedReadsBackToTheBit) {
  const TemporaryFolder folder;
  std::vector<std::shared_ptr<Frame>> frames;
  for (int i = 0; i < 9; ++i) frames.push_back(frame_of(i, GetParam()));
  EXPECT_THAT(record(folder / "a.h5", frames), IsEmpty());
  EXPECT_THAT(record(folder / "b", frames), IsEmpty());
  const H5Source file(folder / "a.h5");
  const FolderSource set(folder / "b");
  ASSERT_EQ(file.size(), 9);
  ASSERT_EQ(set.size(), 9);
  for (int i = 0; i < 9; ++i) {
    SCOPED_TRACE(i);
    expect_same(file.read(i), *frames[static_cast<std::size_t>(i)]);
    expect_same(set.read(i), *frames[static_cast<std::size_t>(i)]);
    EXPECT_EQ(file.read(i).sequence, 0);
  }
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder.path())) names.push_back(entry.path().filename());
  EXPECT_THAT(names, ::testing::UnorderedElementsAre("a.h5", "b")) << "nothing half-written is left";
}

INSTANTIATE_TEST_SUITE_P(Units, RecorderUnits, ::testing::Values(1.0, 0.5, 0.25, 0.2, 0.125, 0.1));

TEST(FrameRecorder, FramesThatShowNothingDoNotDecideTheUnit) {
  const TemporaryFolder folder;
  std::vector<std::shared_ptr<Frame>> frames;
  for (int i = 0; i < 5; ++i) {
    frames.push_back(frame_of(i, 0.1));
    if (i < 3) std::ranges::fill(frames.back()->depth_mm.pixels(), 0.0f);
  }
  EXPECT_THAT(record(folder / "a.h5", frames), IsEmpty());
  const H5Source source(folder / "a.h5");
  ASSERT_EQ(source.size(), 5);
  for (int i = 0; i < 5; ++i) expect_same(source.read(i), *frames[static_cast<std::size_t>(i)]);
}

TEST(FrameRecorder, NothingButEmptyFramesAreARecordingToo) {
  const TemporaryFolder folder;
  const auto empty = frame_of(0);
  std::ranges::fill(empty->depth_mm.pixels(), 0.0f);
  EXPECT_THAT(record(folder / "a.h5", {empty, empty, empty}), IsEmpty());
  EXPECT_EQ(H5Source(folder / "a.h5").size(), 3);
}

TEST(FrameRecorder, TellsWhatItHadToChange) {
  const TemporaryFolder folder;
  const auto first = frame_of(0);
  const auto fine = frame_of(1);
  fine->depth_mm(3, 2) = 500.3f;
  const auto far = frame_of(2);
  far->depth_mm(4, 5) = 70000.0f;
  EXPECT_THAT(record(folder / "a.h5", {first, fine, far}),
              ElementsAre(HasSubstr("1 frames was rounded to whole multiples of 1 mm"),
                          HasSubstr("in 1 frames what is farther than 65535 mm")));
  const H5Source source(folder / "a.h5");
  EXPECT_EQ(source.read(1).depth_mm(3, 2), 500.0f);
  EXPECT_EQ(source.read(2).depth_mm(4, 5), 0.0f);
}

TEST(FrameRecorder, ANewSequenceBeginsWhereTimeGoesBack) {
  const TemporaryFolder folder;
  std::vector<std::shared_ptr<Frame>> frames;
  const std::vector<double> times{1.0, 1.1, 0.2, 0.2, 90.0, 0.1};
  for (std::size_t i = 0; i < times.size(); ++i) {
    frames.push_back(frame_of(static_cast<int>(i)));
    frames.back()->time_s = times[i];
  }
  frames[4]->sequence = 2;
  frames[5]->sequence = 1;
  EXPECT_THAT(record(folder / "a.h5", frames), IsEmpty());
  const H5Source source(folder / "a.h5");
  std::vector<int> sequences;
  for (int i = 0; i < source.size(); ++i) {
    sequences.push_back(source.read_label(i).sequence);
    EXPECT_EQ(source.read_label(i).time_s, times[static_cast<std::size_t>(i)]);
  }
  EXPECT_THAT(sequences, ElementsAre(0, 0, 1, 1, 3, 4));
}

TEST(FrameRecorder, FramesOfAnotherKindAreLeftOut) {
  const TemporaryFolder folder;
  const auto without_time = frame_of(1);
  without_time->time_s.reset();
  const auto not_a_time = frame_of(2);
  not_a_time->time_s = std::nan("");
  const auto without_infrared = frame_of(3, 1.0, false);
  const auto smaller = frame_of(4);
  smaller->camera.width = 23;
  const auto zoomed = frame_of(5);
  zoomed->camera.fx = 25.0;
  const std::vector<std::shared_ptr<Frame>> frames{frame_of(0),      without_time, not_a_time,
                                                   without_infrared, smaller,      zoomed};
  EXPECT_THAT(record(folder / "a.h5", frames), ElementsAre(HasSubstr("4 frames were left out")));
  EXPECT_EQ(H5Source(folder / "a.h5").read(1).camera, zoomed->camera);
  EXPECT_THAT(record(folder / "b", frames), ElementsAre(HasSubstr("5 frames were left out")))
      << "a folder set has one camera";
  EXPECT_EQ(FolderSource(folder / "b").size(), 1);
}

TEST(FrameRecorder, NeverWaitsAndCountsWhatItDrops) {
  const TemporaryFolder folder;
  FrameRecorder recorder(folder / "a.h5");
  const auto frame = frame_of(0);
  const int count = 3000;
  for (int i = 0; i < count; ++i) recorder.put(frame);  // faster than any disk
  const RecordingState state = recorder.state();
  EXPECT_EQ(state.file, "a.h5");
  EXPECT_EQ(state.frames + state.dropped, count);
  recorder.finish();
  EXPECT_EQ(recorder.state().frames + recorder.state().dropped, count);
  EXPECT_EQ(H5Source(folder / "a.h5").size(), recorder.state().frames);
}

TEST(FrameRecorder, ReplacesNothing) {
  const TemporaryFolder folder;
  record(folder / "a.h5", {frame_of(0)});
  EXPECT_THAT(error_of([&] { FrameRecorder(folder / "a.h5"); }), HasSubstr("a.h5: is there already"));
  EXPECT_THAT(error_of([&] { FrameRecorder(folder / "none/a.h5"); }), HasSubstr("none/a.h5"));
  EXPECT_THAT(error_of([&] { FrameRecorder(folder / "b/"); }), HasSubstr("without '/'"));
  fs::create_directory(folder / "empty");
  EXPECT_THAT(record(folder / "empty", {frame_of(0)}), IsEmpty());
  EXPECT_EQ(FolderSource(folder / "empty").size(), 1);
  EXPECT_THAT(error_of([&] { FrameRecorder(folder / "empty"); }), HasSubstr("is there already"));
}

TEST(FrameRecorder, WithoutAFrameThereIsNoRecording) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { record(folder / "a.h5", {}); }), HasSubstr("a.h5: nothing was recorded"));
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(FrameRecorder, AFolderSetIsOnTheDiskUnderItsNameBeforeTheRecordingGoes) {
  const TemporaryFolder folder;
  const fs::path real = fs::canonical(folder.path());
  bool is_named = false;
  bool has_both = false;
  testing::on_flush = [&](const fs::path& path) {
    is_named = path == real && fs::exists(real / "b");
    has_both = is_named && std::distance(fs::directory_iterator(real), {}) == 2;
  };
  EXPECT_THAT(record(real / "b", {frame_of(1), frame_of(2)}), IsEmpty());
  testing::on_flush = nullptr;
  EXPECT_TRUE(is_named) << "the folder of the set is handed to the disk last";
  EXPECT_TRUE(has_both);
}

TEST(FrameRecorder, WhatWasCutShortIsFinishedLater) {
  for (const char* const name : {"a.h5", "b"}) {
    const TemporaryFolder folder;
    const auto frame = frame_of(3, 0.125);
    {
      FrameRecorder recorder(folder / name);
      for (int i = 0; i < 5; ++i) recorder.put(frame);
      set_interrupted(true);  // Ctrl-C for the second time, while the set is made
      EXPECT_THROW(recorder.finish(), Interrupted);
      set_interrupted(false);
    }
    EXPECT_FALSE(fs::exists(folder / name));
    EXPECT_THAT(error_of([&] { FrameRecorder(folder / name); }),
                HasSubstr("cut short; `knuckle record --finish"));
    EXPECT_EQ(finish_recording(folder / name), 5);
    if (fs::is_directory(folder / name)) {
      expect_same(FolderSource(folder / name).read(4), *frame);
    } else {
      expect_same(H5Source(folder / name).read(4), *frame);
    }
    EXPECT_THAT(error_of([&] { finish_recording(folder / name); }), HasSubstr("no such recording"));
  }
}

TEST(FrameRecorder, ClosingDoesNotWait) {
  const TemporaryFolder folder;
  FrameRecorder recorder(folder / "a.h5");
  recorder.put(frame_of(0));
  recorder.close();
  recorder.put(frame_of(1));  // comes too late
  while (!recorder.has_ended()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(H5Source(folder / "a.h5").size(), 1);
  EXPECT_THAT(recorder.finish(), IsEmpty());
}

}  // namespace
}  // namespace knuckle
