// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <csignal>
#include <cstdio>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "knuckle/cli/live_recording.h"
#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/resources.h"
#include "knuckle/core/text.h"
#include "knuckle/pipeline/duration_histogram.h"
#include "knuckle/pipeline/record_of.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/open_own_file.h"
#include "knuckle/track/run_live.h"
#include "knuckle/view/live_server.h"

namespace knuckle::cli {
namespace {

constexpr int kUsualPort = 8790;

struct LiveArguments {
  std::string source;
  std::filesystem::path pipeline = resource_path("pipelines/track.toml");
  std::string records;
  std::filesystem::path record;
  std::filesystem::path record_folder;
  bool is_viewed = false;
  int port = kUsualPort;
  std::string host = "127.0.0.1";
  std::int64_t frames = 0;
  double seconds = 0.0;
};

/// Lines as they come: on standard output (`-`), or in a file that has its name once it is whole.
class RecordLines {
 public:
  explicit RecordLines(const std::string& path) : path_(path) {
    if (path.empty()) return;
    if (path == "-") {
      file_ = stdout;
      return;
    }
    check_writable(path);
    partial_ = path + ".partial";
    const int descriptor = open_own_file_alone(partial_, O_CREAT, "another run is writing it");
    const bool is_empty = ::ftruncate(descriptor, 0) == 0;
    file_ = ::fdopen(descriptor, "wb");
    if (!is_empty || file_ == nullptr) fail("{}: cannot be written", path);
  }
  ~RecordLines() {
    if (!partial_.empty() && file_ != nullptr) std::fclose(file_);
  }
  RecordLines(const RecordLines&) = delete;
  RecordLines& operator=(const RecordLines&) = delete;

  void add(const FrameRecord& record) {
    if (file_ == nullptr) return;
    const std::string line = to_json_line(record) + "\n";
    if (std::fwrite(line.data(), 1, line.size(), file_) != line.size() || std::fflush(file_) != 0)
      fail("{}: cannot be written; is the disk full, or does nobody read it?", path_);
  }
  void finish() {
    if (partial_.empty()) return;
    std::fclose(std::exchange(file_, nullptr));
    publish_file(partial_, path_);
  }

 private:
  std::string path_;
  std::filesystem::path partial_;
  std::FILE* file_ = nullptr;
};

void tell(const LiveCounts& counts, const DurationHistogram& latency, bool is_beside_records) {
  std::FILE* const where = is_beside_records ? stderr : stdout;
  fmt::print(where, "{} frames came, {} passed over, a hand in {} of {}", counts.arrived, counts.passed_over,
             counts.found, counts.results);
  if (counts.lost > 0) fmt::print(where, "; the camera lost {} on the way", counts.lost);
  if (counts.results > 0) {
    fmt::print(where, "; from a frame to its record {:.1f} ms, {:.1f} ms at most in 99 of 100",
               *latency.median_ms(), *latency.percentile_ms(99.0));
  }
  fmt::print(where, "\n");
}

/// The server, and where it is; null where nobody wants to watch.
std::unique_ptr<LiveServer> server_for(const LiveArguments& arguments, const Pipeline& pipeline,
                                       LiveRecording& recording) {
  if (!arguments.is_viewed) return nullptr;
  LiveInfo info{.version = KNUCKLE_VERSION,
                .source = arguments.source,
                .pipeline = arguments.pipeline.string(),
                .convention = pipeline.convention(),
                .can_record = recording.can_be_set()};
  LiveServerOptions options{
      .host = arguments.host, .port = arguments.port, .page = resource_path("web/dist")};
  RecordingControl control{.state = [&] { return recording.state(); },
                           .set = [&](bool on) { recording.set(on); }};
  auto server = std::make_unique<LiveServer>(std::move(info), options, std::move(control));
  fmt::print(stderr, "view: {}\n", server->address());
  return server;
}

void run_live_verb(const LiveArguments& arguments) {
  std::signal(SIGPIPE, SIG_IGN);  // who reads the records may go: then writing fails, with a message
  const auto stream = open_stream(arguments.source);
  const Pipeline pipeline = Pipeline::load(arguments.pipeline);
  RecordLines lines(arguments.records);
  LiveRecording recording(arguments.record, arguments.record_folder);
  auto server = server_for(arguments, pipeline, recording);
  DurationHistogram latency;
  const LiveOptions options{.most_frames = arguments.frames,
                            .most_seconds = arguments.seconds,
                            .at_arrival = [&](std::int64_t, const auto& frame) { recording.put(frame); }};
  const LiveCounts counts = run_live(*stream, pipeline, options, [&](const LiveFrame& live) {
    FrameRecord record = record_of(live.result, PixelOrigin::centre);
    record.latency_ms = live.latency_ms;
    latency.add(live.latency_ms);
    lines.add(record);
    if (server) {
      server->publish(std::make_shared<const LiveUpdate>(
          LiveUpdate{live.frame, std::move(record), recording.state(), live.arrived, live.passed_over}));
    }
    if (recording.has_failed()) set_interrupted(true);  // `finish` says why
  });
  server.reset();
  set_interrupted(false);  // what is recorded is made whole
  lines.finish();
  tell(counts, latency, arguments.records == "-");
  recording.finish();
  if (!counts.why_camera_is_lost.empty()) fail("{}", counts.why_camera_is_lost);
  if (counts.unreadable > 0) {
    fail("{}: {} frames could not be read; the first: {}", arguments.source, counts.unreadable, counts.fault);
  }
}

/// A port from the command line; empty: the usual one.
int port_from(const std::string& text) {
  constexpr int kMostPort = 65535;
  if (text.empty()) return kUsualPort;
  int port = -1;
  const char* const end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data(), end, port);
  if (fault != std::errc() || rest != end || port < 0 || port > kMostPort)
    throw CLI::ValidationError("--view", fmt::format("'{}' is no port, expected 0 to {}", text, kMostPort));
  return port;
}

void add_view_options(CLI::App& verb, const std::shared_ptr<LiveArguments>& arguments) {
  CLI::Option* const view = verb.add_option_function<std::string>(
      "--view",
      [arguments](const std::string& port) {
        arguments->is_viewed = true;
        arguments->port = port_from(port);
      },
      fmt::format(
          "Serves a page that shows the hand, and records for programs, on this port; 0: any free one [{}]",
          kUsualPort));
  view->expected(0, 1)->type_name("PORT");
  verb.add_option("--host", arguments->host,
                  "Address that --view serves; others than this machine's own need the token that is printed")
      ->type_name("ADDRESS")
      ->capture_default_str()
      ->needs(view);
  verb.add_option("--record-folder", arguments->record_folder,
                  "Lets the page of --view begin and end recordings, which go into this folder")
      ->type_name("DIR")
      ->needs(view)
      ->excludes(verb.get_option("--record"));
}

}  // namespace

void add_live(CLI::App& program) {
  CLI::App& verb = add_verb(
      program, "live", "Follow hands while they move: before a camera, or in a recording or data set, played",
      "knuckle live --source 'synthetic:manifests/demo.toml?rate=30' --view 0 --records -");
  auto arguments = std::make_shared<LiveArguments>();
  verb.add_option("--source", arguments->source,
                  "Where frames come from: a camera, as `knuckle cameras` lists them, or a source, played: "
                  "KIND:PATH[?rate=60&loop=1], as `knuckle info` lists the kinds")
      ->type_name("STREAM")
      ->required();
  verb.add_option("--pipeline", arguments->pipeline,
                  "Pipeline file (pipelines/); with [tracker] hands keep their ids")
      ->type_name("FILE")
      ->capture_default_str();
  verb.add_option("--records", arguments->records,
                  "Frame records as they come, one line of JSON each; -: on standard output")
      ->type_name("FILE");
  verb.add_option("--record", arguments->record,
                  "Keeps all raw frames, from start to end, in a new file F.h5 or a new folder")
      ->type_name("F.h5|DIR");
  add_view_options(verb, arguments);
  verb.add_option("--frames", arguments->frames,
                  "Ends after so many frames were looked at; 0: with the stream, or Ctrl-C")
      ->check(CLI::NonNegativeNumber);
  verb.add_option("--seconds", arguments->seconds,
                  "Ends after so many seconds; 0: with the stream, or Ctrl-C")
      ->check(CLI::NonNegativeNumber);
  verb.callback([arguments] { run_live_verb(*arguments); });
}

}  // namespace knuckle::cli
