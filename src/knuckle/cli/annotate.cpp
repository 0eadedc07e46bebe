// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <csignal>
#include <thread>

#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/core/resources.h"
#include "knuckle/core/statistics.h"
#include "knuckle/core/text.h"
#include "knuckle/label/label_session.h"
#include "knuckle/pipeline/pipeline.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/prepare/source_fingerprint.h"
#include "knuckle/view/label_server.h"

namespace knuckle::cli {
namespace {

constexpr int kUsualPort = 8791;
constexpr int kMostPort = 65535;

struct AnnotateArguments {
  std::string source;
  std::filesystem::path labels;
  std::filesystem::path prelabel;
  std::string convention = "knuckle22";
  std::string author;
  std::string host = "127.0.0.1";
  int port = kUsualPort;
  int reach = LabelSessionOptions().reach;
  bool accepts_changed_source = false;
};

LabelHead head_of(const AnnotateArguments& arguments, const FrameSource& source,
                  const std::filesystem::path& file) {
  return {.source = arguments.source,
          .fingerprint = source_fingerprint(arguments.source, {&file, 1}),
          .frames = source.size(),
          .convention = convention_from_option(arguments.convention),
          .camera = source.read_label(0).camera};
}

/// What the pipeline finds in a frame, by both sides.
std::vector<EstimatedHand> hands_in(const Pipeline& pipeline, const Frame& frame) {
  std::vector<EstimatedHand> hands;
  for (HandEstimate& hand : pipeline.estimate(frame, {.max_hands = pipeline.hand().max_hands}).hands)
    hands.push_back({hand.side, std::move(hand.pose)});
  return hands;
}

void wait_for_the_end() {
  while (!is_interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  set_interrupted(false);  // what was labelled is written
}

void tell(const LabelJournal& journal, const std::vector<double>& seconds) {
  if (journal.waiting() > 0)
    fail("{}; {} changes are lost with the end of the program", journal.fault(), journal.waiting());
  fmt::print("{}: {} hands verified", printable(journal.path().string()), seconds.size());
  if (!seconds.empty()) fmt::print(", {:.0f} s each (median)", median(seconds));
  fmt::print("\n");
}

void run_annotate(const AnnotateArguments& arguments) {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is a full disk: said, not died of
  const auto source = open_source(arguments.source);
  const std::filesystem::path file = label_file(arguments.labels, arguments.author);
  const LabelHead head = head_of(arguments, *source, file);
  std::optional<Pipeline> pipeline;
  if (!arguments.prelabel.empty()) pipeline.emplace(Pipeline::load(arguments.prelabel));
  LabelJournal journal(file, head,
                       arguments.accepts_changed_source ? ChangedSource::accept : ChangedSource::refuse);
  LabelSessionOptions options;
  options.reach = arguments.reach;
  if (!arguments.author.empty()) options.author = arguments.author;
  if (pipeline) {
    options.estimator = arguments.prelabel.filename().string();
    options.estimate = [&](const Frame& frame) { return hands_in(*pipeline, frame); };
  }
  LabelSession session(*source, journal, options);
  {
    const LabelServer server({.version = KNUCKLE_VERSION,
                              .source = arguments.source,
                              .file = file.string(),
                              .author = options.author,
                              .estimator = arguments.prelabel.string()},
                             session,
                             {.host = arguments.host,
                              .port = arguments.port,
                              .page = resource_path("web/dist"),
                              .index = "annotate.html"});
    fmt::print(stderr, "annotate: {}\n", server.address());
    wait_for_the_end();
  }
  journal.flush();
  tell(journal, session.seconds_of_verified());
}

}  // namespace

void add_annotate(CLI::App& program) {
  CLI::App& verb =
      add_verb(program, "annotate",
               "Label hands in the browser: correct what a pipeline found, with the hand model's help",
               "knuckle annotate --source synthetic:manifests/demo.toml --labels demo_labels --prelabel "
               "pipelines/default.toml");
  auto arguments = std::make_shared<AnnotateArguments>();
  add_source_option(verb, arguments->source);
  verb.add_option("--labels", arguments->labels, "Folder of the labels; it is made where it is not there")
      ->type_name("DIR")
      ->required();
  verb.add_option("--prelabel", arguments->prelabel,
                  "Pipeline file (pipelines/) that finds hands first; without it one begins from nothing")
      ->type_name("FILE");
  verb.add_option("--convention", arguments->convention,
                  "Landmarks that are labelled: a name, or a file of one's own")
      ->type_name("NAME|FILE")
      ->capture_default_str();
  verb.add_option("--author", arguments->author,
                  "Who labels; each author's labels are in a file of their own, labels.NAME.jsonl")
      ->type_name("NAME");
  constexpr int kFarthestReach = 100;
  verb.add_option("--follow", arguments->reach,
                  "Frames on both sides that follow a verified one; 0 where frames have nothing to do with "
                  "each other")
      ->check(CLI::Range(0, kFarthestReach).description(""))
      ->type_name("FRAMES")
      ->capture_default_str();
  verb.add_option("--port", arguments->port, "Port of the page; 0: any free one")
      ->check(CLI::Range(0, kMostPort).description(""))
      ->type_name("PORT")
      ->capture_default_str();
  verb.add_option("--host", arguments->host,
                  "Address that is served; others than this machine's own need the token that is printed")
      ->type_name("ADDRESS")
      ->capture_default_str();
  verb.add_flag("--accept-changed-source", arguments->accepts_changed_source,
                "Go on with labels although the source's files have changed since");
  verb.callback([arguments] { run_annotate(*arguments); });
}

}  // namespace knuckle::cli
