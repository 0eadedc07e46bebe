// SPDX-License-Identifier: Apache-2.0
// Processes that crash, hang or lie, in place of the one that reads cameras.
#include "knuckle/stream/camera_process.h"

#include <cmath>
#include <cstring>
#include <thread>

#include "knuckle/core/interruption.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/stream/oni_source.h"
#include "knuckle/stream/process_stream.h"

namespace knuckle {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

template <class Plain>
void append(std::string& bytes, const Plain& plain) {
  bytes.append(reinterpret_cast<const char*>(&plain), sizeof plain);
}

std::string message(CameraMessage kind, const std::string& bytes) {
  std::string whole;
  append(whole, CameraMessageHead{kCameraMessageMagic, static_cast<std::uint32_t>(kind), bytes.size()});
  return whole + bytes;
}

PipedDescription camera_of_4x3() {
  PipedDescription description;
  description.width = 4;
  description.height = 3;
  description.horizontal_fov_rad = 1.0;
  description.vertical_fov_rad = 0.8;
  return description;
}

std::string description_message(const PipedDescription& description) {
  std::string bytes;
  append(bytes, description);
  return message(CameraMessage::description, bytes);
}

std::string frame_message(std::int64_t number, std::uint16_t first, double time_s = 0.0) {
  std::string bytes;
  append(bytes, PipedFrame{number, time_s});
  for (int i = 0; i < 12; ++i) append(bytes, static_cast<std::uint16_t>(first + i));
  return message(CameraMessage::frame, bytes);
}

class CameraProcessTest : public ::testing::Test {
 protected:
  /// A program that does what the script says; `said` lies beside it as $0.said.
  fs::path program(const std::string& script, const std::string& said = "") {
    const fs::path path = folder_ / "program";
    write_text_file(path, "#!/bin/sh\n" + script + "\n");
    write_text_file(folder_ / "program.said", said);
    fs::permissions(path, fs::perms::owner_all);
    return path;
  }
  CameraProcess start(const std::string& script, const std::string& said = "") {
    return {program(script, said), {"oni", "a.oni"}, "a.oni"};
  }
  ProcessStream stream(const std::string& script, const std::string& said, double timeout_s = 5.0) {
    return {std::make_unique<CameraProcess>(program(script, said), std::vector<std::string>{}, "freenect:0"),
            "freenect:0",
            {},
            timeout_s,
            UnknownIntrinsics::refuse};
  }
  std::string fault_of(const std::string& script, const std::string& said = "") {
    CameraProcess process = start(script, said);
    return error_of([&] { process.wait_for_message(std::chrono::milliseconds(300)); });
  }

  testing::TemporaryFolder folder_;
};

TEST_F(CameraProcessTest, MessagesComeWholeHoweverTheyAreCut) {
  CameraProcess process =
      start("head -c 5 $0.said; sleep 0.05; tail -c +6 $0.said; sleep 9",
            message(CameraMessage::fault, "one") + message(CameraMessage::listing, "two\nname"));
  const ReceivedMessage first = process.wait_for_message(std::chrono::seconds(5));
  EXPECT_EQ(first.kind, CameraMessage::fault);
  EXPECT_EQ(parse_text(first.bytes), "one");
  EXPECT_EQ(parse_text(process.wait_for_message(std::chrono::seconds(5)).bytes), "two\nname");
  EXPECT_FALSE(process.receive(milliseconds(10)));
}

TEST_F(CameraProcessTest, OneThatDiesIsOneLine) {
  EXPECT_THAT(fault_of("kill -SEGV $$"),
              AllOf(HasSubstr("a.oni: the process that reads it crashed"), HasSubstr("egmentation")));
  EXPECT_THAT(fault_of("exit 3"), HasSubstr("ended too early (status 3)"));
  EXPECT_THAT(fault_of("head -c 20 $0.said", message(CameraMessage::fault, "a long text")),
              HasSubstr("ended too early (status 0)"));
}

TEST_F(CameraProcessTest, OneThatHasEndedIsNotWaitedForAgain) {
  CameraProcess process = start("exit 3");
  const auto wait = [&] { process.wait_for_message(std::chrono::seconds(5)); };
  EXPECT_THAT(error_of(wait), HasSubstr("ended too early"));
  EXPECT_THAT(error_of(wait), HasSubstr("a.oni: the process that reads it has ended"));
}

TEST_F(CameraProcessTest, OursRefusesArgumentsThatItDoesNotKnow) {
  using Arguments = std::vector<std::string>;
  for (const Arguments& arguments : {Arguments{}, Arguments{"dance"}, Arguments{"list"},
                                     Arguments{"freenect", "0"}, Arguments{"oni", "a.oni", "b.oni"}}) {
    CameraProcess process(camera_program(), arguments, "x");
    const ReceivedMessage message = process.wait_for_message(std::chrono::seconds(20));
    EXPECT_EQ(message.kind, CameraMessage::fault);
    EXPECT_THAT(parse_text(message.bytes), HasSubstr("arguments that it does not know"));
  }
}

TEST_F(CameraProcessTest, OneThatHangsIsOneLineAndIsEnded) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(fault_of("exec sleep 60"), HasSubstr("a.oni: gave no answer for 0.3 s"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(30));
}

TEST_F(CameraProcessTest, OneThatTalksNonsenseIsOneLine) {
  EXPECT_THAT(fault_of("echo 'a line of a library that prints'; sleep 9"),
              HasSubstr("sent something that is no message"));
  std::string huge;
  append(huge, CameraMessageHead{kCameraMessageMagic, 2, std::uint64_t{1} << 62});
  EXPECT_THAT(fault_of("cat $0.said; sleep 9", huge), HasSubstr("is no message"));
}

TEST_F(CameraProcessTest, OneThatCannotBeStartedIsOneLine) {
  EXPECT_THAT(error_of([&] { CameraProcess(folder_ / "none", {}, "a.oni"); }),
              HasSubstr("none: cannot be started"));
}

TEST_F(CameraProcessTest, CtrlCEndsTheWaiting) {
  CameraProcess process = start("exec sleep 60");
  set_interrupted(true);
  EXPECT_THROW(process.wait_for_message(std::chrono::seconds(60)), Interrupted);
  set_interrupted(false);
}

TEST_F(CameraProcessTest, AStreamsFramesAreMillimetresFromTheFirstOn) {
  PipedDescription description = camera_of_4x3();
  description.unit_mm = 0.1;
  ProcessStream camera =
      stream("cat $0.said; exec sleep 9",
             description_message(description) + frame_message(3, 1000, 50.0) + frame_message(6, 2000, 50.5));
  EXPECT_EQ(camera.facts().intrinsics, "the fields of view that the device reports");
  const Frame first = camera.next().value();
  EXPECT_EQ(first.depth_mm(0, 0), 100.0f);
  EXPECT_EQ(first.depth_mm(3, 2), 101.1f);
  EXPECT_EQ(first.time_s, 0.0);
  EXPECT_NEAR(first.camera.fx, 2.0 / std::tan(0.5), 1e-12);
  EXPECT_NEAR(first.camera.fy, 1.5 / std::tan(0.4), 1e-12);
  EXPECT_EQ(camera.next()->time_s, 0.5);
  EXPECT_EQ(camera.lost_frames(), 2) << "numbers 4 and 5";
}

TEST_F(CameraProcessTest, AMirroredImageIsTurnedBack) {
  PipedDescription description = camera_of_4x3();
  description.is_mirrored = 1;
  ProcessStream camera =
      stream("cat $0.said; exec sleep 9", description_message(description) + frame_message(0, 500));
  const Frame frame = camera.next().value();
  EXPECT_EQ(frame.depth_mm(3, 0), 500.0f);
  EXPECT_EQ(frame.depth_mm(0, 0), 503.0f);
}

TEST_F(CameraProcessTest, AStreamWhoseProcessEndsIsLost) {
  ProcessStream camera =
      stream("cat $0.said; kill -ABRT $$", description_message(camera_of_4x3()) + frame_message(0, 500));
  EXPECT_TRUE(camera.next());
  EXPECT_THROW(camera.next(), DeviceLost);
  EXPECT_FALSE(camera.next()) << "it has ended";
  ProcessStream silent = stream("cat $0.said; exec sleep 60", description_message(camera_of_4x3()), 0.2);
  EXPECT_THAT(error_of([&] { silent.next(); }), HasSubstr("freenect:0: gave no answer for 0.2 s"));
  ProcessStream unplugged =
      stream("cat $0.said; exec sleep 60", description_message(camera_of_4x3()) +
                                               message(CameraMessage::fault, "the Kinect was unplugged"));
  EXPECT_THAT(error_of([&] { unplugged.next(); }), HasSubstr("freenect:0: the Kinect was unplugged"));
  ProcessStream talking = stream("cat $0.said; exec sleep 60",
                                 description_message(camera_of_4x3()) + message(CameraMessage::listing, "0"));
  EXPECT_THAT(error_of([&] { talking.next(); }),
              HasSubstr("freenect:0: the process that reads it sent no frame"));
}

TEST_F(CameraProcessTest, AStreamBeginsWithItsDescription) {
  EXPECT_THAT(error_of([&] { stream("cat $0.said; exec sleep 60", frame_message(0, 500)); }),
              HasSubstr("freenect:0: the process that reads it did not say what it is"));
  EXPECT_THAT(error_of([&] {
                stream("cat $0.said; exec sleep 60", message(CameraMessage::fault, "no such Kinect"));
              }),
              HasSubstr("freenect:0: no such Kinect"));
}

/// What a recording of this many frames sends.
std::string recording(int count, const PipedDescription& description) {
  std::string said = description_message(description);
  for (int i = 0; i < count; ++i)
    said += frame_message(i, static_cast<std::uint16_t>(100 * (i + 1)), 0.1 * i);
  return said;
}

class OniSourceTest : public CameraProcessTest {
 protected:
  OniSourceTest() {
    write_text_file(folder_ / "a.oni", "anything");
    description_.frames = 6;
  }
  OniSource open(const std::string& said, const std::string& end = "") {
    return {folder_ / "a.oni", {}, program("echo >> $0.started; cat $0.said; " + end, said)};
  }
  int times_started() { return static_cast<int>(fs::file_size(folder_ / "program.started")); }

  PipedDescription description_ = camera_of_4x3();
};

TEST_F(OniSourceTest, FramesAreFoundInAnyOrder) {
  const OniSource source = open(recording(6, description_));
  ASSERT_EQ(source.size(), 6);
  for (const int index : {0, 1, 4, 2, 3, 5, 0, 5}) {
    EXPECT_EQ(source.read(index).depth_mm(0, 0), 100.0f * static_cast<float>(index + 1));
    EXPECT_DOUBLE_EQ(source.read_label(index).time_s.value(), 0.1 * index);
  }
  EXPECT_EQ(times_started(), 1) << "what came before is kept";
}

TEST_F(OniSourceTest, ManyThreadsGetTheFramesThatTheyAskFor) {
  const OniSource source = open(recording(6, description_));
  parallel_for(60, [&](std::int64_t i) {
    EXPECT_EQ(source.read(i % 6).depth_mm(0, 0), 100.0f * static_cast<float>(i % 6 + 1));
  });
}

TEST_F(OniSourceTest, WhatIsNotKeptIsReadAnew) {
  description_.width = 4000;
  description_.height = 3000;  // 24 MB each: two are kept
  std::string said = description_message(description_);
  for (int i = 0; i < 6; ++i) {
    std::string bytes;
    append(bytes, PipedFrame{i, 0.0});
    bytes.resize(sizeof(PipedFrame) + 24000000, static_cast<char>(i + 1));
    said += message(CameraMessage::frame, bytes);
  }
  const OniSource source = open(said);
  EXPECT_EQ(source.read(5).depth_mm(7, 7), 6.0f * 257);
  EXPECT_EQ(source.read(4).depth_mm(7, 7), 5.0f * 257);
  EXPECT_EQ(times_started(), 1);
  EXPECT_EQ(source.read(0).depth_mm(7, 7), 257.0f);
  EXPECT_EQ(times_started(), 2);
}

TEST_F(OniSourceTest, WhereTheProcessCrashesTheFramesFromThereOnAreFaulty) {
  const OniSource source = open(recording(3, description_), "kill -SEGV $$");
  EXPECT_THAT(error_of([&] { source.read(4); }), HasSubstr("a.oni: the process that reads it crashed"));
  EXPECT_THAT(error_of([&] { source.read(3); }), HasSubstr("crashed"));
  EXPECT_THAT(error_of([&] { source.read(5); }), HasSubstr("crashed"));
  EXPECT_EQ(times_started(), 1) << "it is not tried again";
  EXPECT_EQ(source.read(2).depth_mm(0, 0), 300.0f);
}

TEST_F(OniSourceTest, AFrameThatIsPassedOverIsTheOnlyFaultyOne) {
  description_.frames = 3;
  const OniSource source =
      open(description_message(description_) + frame_message(0, 100) + frame_message(2, 300));
  EXPECT_THAT(error_of([&] { source.read(1); }), HasSubstr("a.oni: frame 1 is missing or damaged"));
  EXPECT_EQ(source.read(2).depth_mm(0, 0), 300.0f);
  EXPECT_EQ(source.read(0).depth_mm(0, 0), 100.0f);
}

TEST_F(OniSourceTest, ARecordingThatLiesIsRefused) {
  const std::string head = description_message(description_);
  EXPECT_THAT(error_of([&] { open(head + frame_message(0, 0) + frame_message(0, 0)).read(1); }),
              HasSubstr("frame 0 comes after frame 0"));
  EXPECT_THAT(error_of([&] { open(head + frame_message(6, 0)).read(0); }), HasSubstr("frame 6 comes after"));
  EXPECT_THAT(error_of([&] { open(head + message(CameraMessage::fault, "nonsense")).read(0); }),
              HasSubstr("a.oni: nonsense"));
  EXPECT_THAT(error_of([&] { open(message(CameraMessage::fault, "is it whole?")); }),
              HasSubstr("a.oni: is it whole?"));
  EXPECT_THAT(error_of([&] { open(head + message(CameraMessage::end, "")).read(0); }),
              HasSubstr("ends before its frame 0"));
  EXPECT_THAT(error_of([&] { open(frame_message(0, 0)); }), HasSubstr("did not say what it is"));
  description_.frames = 0;
  EXPECT_THAT(error_of([&] { open(description_message(description_)); }), HasSubstr("holds no depth image"));
  description_.frames = 3;
  description_.horizontal_fov_rad = 0.0;
  EXPECT_THAT(error_of([&] { open(description_message(description_)); }),
              HasSubstr("its intrinsics are not known"));
  EXPECT_THAT(error_of([&] { OniSource(folder_ / "none.oni"); }), HasSubstr("none.oni"));
}

}  // namespace
}  // namespace knuckle
