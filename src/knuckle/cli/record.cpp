// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "knuckle/cli/live_recording.h"
#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/text.h"
#include "knuckle/data/writers/frame_recorder.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle::cli {
namespace {

struct RecordArguments {
  std::string source;
  std::filesystem::path out;
  std::filesystem::path rest;
  std::int64_t frames = 0;
  double seconds = 0.0;
};

/// What came of a stream.
struct Arrived {
  std::int64_t frames = 0;
  std::int64_t unreadable = 0;
  std::string fault;  ///< of the first that could not be read
  double seconds = 0.0;
  std::string why_camera_is_lost;  ///< empty where it is not
};

/// Hands over the frames of a stream until it ends, or is to.
Arrived record_stream(FrameStream& stream, const RecordArguments& arguments, FrameRecorder& recorder) {
  using Clock = std::chrono::steady_clock;
  Arrived arrived;
  std::optional<Clock::time_point> began;
  while (!is_interrupted() && !recorder.has_failed()) {
    try {
      std::optional<Frame> frame = stream.next();
      if (!frame) break;
      if (!began) began = Clock::now();
      recorder.put(std::make_shared<const Frame>(*std::move(frame)));
      ++arrived.frames;
    } catch (const Interrupted&) {
      break;
    } catch (const DeviceLost& error) {
      arrived.why_camera_is_lost = error.what();
      break;
    } catch (const Error& error) {
      if (arrived.unreadable++ == 0) arrived.fault = error.what();
    }
    if (began) arrived.seconds = std::chrono::duration<double>(Clock::now() - *began).count();
    if (arrived.frames == arguments.frames && arguments.frames > 0) break;
    if (arguments.seconds > 0.0 && arrived.seconds >= arguments.seconds) break;
  }
  return arrived;
}

/// Why not all is recorded that was to be; empty where it is.
std::string fault_of(const Arrived& arrived, const std::string& source) {
  if (!arrived.why_camera_is_lost.empty()) return arrived.why_camera_is_lost;
  if (arrived.unreadable == 0) return {};
  return fmt::format("{}: {} frames could not be read; the first: {}", source, arrived.unreadable,
                     arrived.fault);
}

void run_record_verb(const RecordArguments& arguments) {
  if (!arguments.rest.empty()) {
    fmt::print("{}: {} frames\n", printable(arguments.rest.string()), finish_recording(arguments.rest));
    return;
  }
  const auto stream = open_stream(arguments.source);
  FrameRecorder recorder(arguments.out);
  const Arrived arrived = record_stream(*stream, arguments, recorder);
  const std::string fault = fault_of(arrived, arguments.source);
  // It says more than that there is no frame.
  if (arrived.frames == 0 && !fault.empty()) fail("{}", fault);
  set_interrupted(false);  // what is recorded is made whole
  finish_recording_of(recorder, arguments.out);
  const RecordingState state = recorder.state();
  fmt::print("{}: {} of {} frames in {:.1f} s\n", printable(arguments.out.string()), state.frames,
             arrived.frames, arrived.seconds);
  if (const std::int64_t lost = stream->lost_frames(); lost > 0)
    fmt::print(stderr, "warning: the camera lost {} frames on the way\n", lost);
  if (!fault.empty()) fail("{}", fault);
}

}  // namespace

void add_record(CLI::App& program) {
  CLI::App& verb =
      add_verb(program, "record", "Keep the raw frames of a stream: depth, infrared, times, camera",
               "knuckle record --source 'synthetic:manifests/demo.toml?rate=30' --out take.h5 "
               "--seconds 2");
  auto arguments = std::make_shared<RecordArguments>();
  CLI::Option* const source =
      verb.add_option("--source", arguments->source,
                      "Where frames come from, as in `knuckle live`; `knuckle info` lists the kinds")
          ->type_name("STREAM");
  CLI::Option* const out =
      verb.add_option("--out", arguments->out,
                      "A new file F.h5, or a new folder (a folder set); read as h5:F.h5 or folder:DIR")
          ->type_name("F.h5|DIR");
  verb.add_option("--frames", arguments->frames, "Ends after so many frames; 0: with the stream, or Ctrl-C")
      ->check(CLI::NonNegativeNumber);
  verb.add_option("--seconds", arguments->seconds,
                  "Ends after so many seconds; 0: with the stream, or Ctrl-C")
      ->check(CLI::NonNegativeNumber);
  CLI::Option* const finish =
      verb.add_option("--finish", arguments->rest,
                      "Makes the set of this name out of what a recording left that was cut short, and ends")
          ->type_name("F.h5|DIR")
          ->excludes(source)
          ->excludes(out);
  verb.callback([arguments, source, out, finish] {
    if (finish->empty() && source->empty()) throw CLI::RequiredError("--source");
    if (finish->empty() && out->empty()) throw CLI::RequiredError("--out");
    run_record_verb(*arguments);
  });
}

}  // namespace knuckle::cli
