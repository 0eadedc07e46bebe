// SPDX-License-Identifier: Apache-2.0
// Processes that crash, hang or lie, in place of the one that reads cameras.
#include "knuckle/stream/camera_process.h"

#include <cmath>
#include <cstring>
#include <thread>

#include "knuckle/core/interruption.h"
#include "knuckle/core/testing.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/stream/oni_source.h"
#include "knuckle/stream/process_stream.h"

namespace knuckle {
namespace {

using std::chrono::milliseconds;
using testing::error_of;
using ::testing::AllOf;
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
    return {std::make_unique<CameraProcess>(program(script, said), std::vector<std::string>{}, "freenect:0"), "freenect:0", {}, timeout_s, UnknownIntrinsics::refuse};
  }
  std::string fault_of(const std::string& script, const std::string& said = "") {
    CameraProcess process = start(script, said);
    return error_of([&] { process.wait_for_message(std::chrono::milliseconds(300)); });
  }

  testing::TemporaryFolder folder_;
};

TEST_F(CameraProcessTest, MessagesComeWholeHoweverTheyAreCut) {
  CameraProcess process = start("head -c 5 $0.said; sleep 0.05; tail -c +6 $0.said; sleep 9", message(CameraMessage::fault, "one") + message(CameraMessage::listing, "two\nname") );
  const ReceivedMessage first = process.wait_for_message(std::chrono::seconds(5));
  EXPECT_EQ(first.kind, CameraMessage::fault);
  EXPECT_EQ(parse_text(first.bytes), "one");
  EXPECT_EQ(parse_text(process.wait_for_message(std::chrono::seconds(5)).bytes), "two\nname");
  EXPECT_FALSE(process.receive(milliseconds(10)));
}

TEST_F(CameraProcessTest, OneThatDiesIsOneLine) {
  EXPECT_THAT(fault_of("kill -SEGV $$"), AllOf(HasSubstr("a.oni: the process that reads it crashed"), HasSubstr("egmentation")));
  EXPECT_THAT(fault_of("exit 3"), HasSubstr("ended too early (status 3)"));
  EXPECT_THAT(fault_of("head -c 20 $0.said", message(CameraMessage::fault, "a long text")), HasSubstr("ended too early (status 0)"));
}

TEST_F(CameraProcessTest, OneThatHangsIsOneLineAndIsEnded) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(fault_of("exec sleep 60"), HasSubstr("a.oni: gave no answer for 0.3 s"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(30));
}

TEST_F(CameraProcessTest, OneThatTalksNonsenseIsOneLine) {
  EXPECT_THAT(fault_of("echo 'a line of a library that prints'; sleep 9"), HasSubstr("sent something that is no message"));
  std::string huge;
  append(huge, CameraMessageHead{kCameraMessageMagic, 2, std::uint64_t{1} << 62});
  EXPECT_THAT(fault_of("cat $0.said; sleep 9", huge), HasSubstr("is no message"));
}

TEST_F(CameraProcessTest, OneThatCannotBeStartedIsOneLine) {
  EXPECT_THAT(error_of([&] { CameraProcess(folder_ / "none", {}, "a.oni"); }), HasSubstr("none: cannot be started"));
}

TEST_F(CameraProcessTest, AQuestionToOneThatHasEndedIsAnError) {
  CameraProcess process = start("exec true");
  EXPECT_THAT(error_of([&] {
                for (int tries = 0; tries < 1000; ++tries) {
                  process.ask(0);
                  std::this_thread::sleep_for(milliseconds(10));
                }
              }),
              HasSubstr("a.oni: the process that reads it ended too early (status 0)"));
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
  ProcessStream camera = stream("cat $0.said; exec sleep 9", description_message(description) + frame_message(3, 1000, 50.0) + frame_message(6, 2000, 50.5));
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
  ProcessStream camera = stream("cat $0.said; exec sleep 9", description_message(description) + frame_message(0, 500));
  const Frame frame = camera.next().value();
  EXPECT_EQ(frame.depth_mm(3, 0), 500.0f);
  EXPECT_EQ(frame.depth_mm(0, 0), 503.0f);
}

TEST_F(CameraProcessTest, AStreamWhoseProcessEndsIsLost) {
  ProcessStream camera = stream("cat $0.said; kill -ABRT $$", description_message(camera_of_4x3()) + frame_message(0, 500));
  EXPECT_TRUE(camera.next());
  EXPECT_THROW(camera.next(), DeviceLost);
  EXPECT_FALSE(camera.next()) << "it has ended";
  ProcessStream silent = stream("cat $0.said; exec sleep 60", description_message(camera_of_4x3()), 0.2);
  EXPECT_THAT(error_of([&] { silent.next(); }), HasSubstr("freenect:0: gave no answer for 0.2 s"));
  ProcessStream unplugged = stream("cat $0.said; exec sleep 60", description_message(camera_of_4x3()) + message(CameraMessage::fault, "the Kinect was unplugged"));
  EXPECT_THAT(error_of([&] { unplugged.next(); }), HasSubstr("freenect:0: the Kinect was unplugged"));
}

/// A recording of three frames, each read by a new process; the second one crashes it.
TEST_F(CameraProcessTest, AFrameOfARecordingThatCrashesItIsAFaultOfThatFrame) {
  PipedDescription description = camera_of_4x3();
  description.frames = 3;
  std::string said = description_message(description);
  const std::size_t head = said.size();
  const std::size_t frame = frame_message(0, 0).size();
  for (int i = 0; i < 3; ++i) said += frame_message(i, static_cast<std::uint16_t>(100 * (i + 1)), 0.1 * i);
  const std::string script = fmt::format(
      "head -c {0} $0.said\n"
      "while true; do\n"
      "  number=$(dd bs=8 count=1 2>/dev/null | od -An -td8 | tr -d ' ')\n"
      "  [ -z \"$number\" ] && exit 0\n"
      "  [ \"$number\" = 1 ] && kill -SEGV $$\n"
      "  tail -c +$(({0} + 1 + number * {1})) $0.said | head -c {1}\n"
      "done",
      head, frame);
  write_text_file(folder_ / "a.oni", "anything");
  const OniSource source(folder_ / "a.oni", {}, program(script, said));
  ASSERT_EQ(source.size(), 3);
  EXPECT_EQ(source.read(0).depth_mm(0, 0), 100.0f);
  EXPECT_THAT(error_of([&] { source.read(1); }), HasSubstr("a.oni: the process that reads it crashed"));
  EXPECT_EQ(source.read(2).depth_mm(0, 0), 300.0f) << "by another process";
  EXPECT_EQ(source.read_label(2).time_s, 0.2);
}

TEST_F(CameraProcessTest, ARecordingThatLiesIsRefused) {
  PipedDescription description = camera_of_4x3();
  description.frames = 3;
  write_text_file(folder_ / "a.oni", "anything");
  const auto open = [&](const std::string& said) { return OniSource(folder_ / "a.oni", {}, program("cat $0.said; exec cat >/dev/null", said)); };
  EXPECT_THAT(error_of([&] { open(description_message(description) + frame_message(1, 0)).read(0); }), HasSubstr("frame 1 came in its place"));
  EXPECT_THAT(error_of([&] { open(description_message(description) + message(CameraMessage::fault, "no\nsense")).read(0); }), HasSubstr("a.oni: frame 0: no\nsense"));
  EXPECT_THAT(error_of([&] { open(frame_message(0, 0)); }), HasSubstr("did not say what it is"));
  description.frames = 0;
  EXPECT_THAT(error_of([&] { open(description_message(description)); }), HasSubstr("holds no depth image"));
  description.frames = 3;
  description.horizontal_fov_rad = 0.0;
  EXPECT_THAT(error_of([&] { open(description_message(description)); }), HasSubstr("its intrinsics are not known"));
  EXPECT_THAT(error_of([&] { OniSource(folder_ / "none.oni", {}); }), HasSubstr("none.oni"));
}

}  // namespace
}  // namespace knuckle
