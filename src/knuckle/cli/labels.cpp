// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <map>
#include <set>

#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/text.h"
#include "knuckle/data/poses_file.h"
#include "knuckle/data/writers/frame_writer.h"
#include "knuckle/data/writers/set_depth_unit.h"
#include "knuckle/label/agreement_json.h"
#include "knuckle/label/label_journal.h"
#include "knuckle/label/labelled_source.h"
#include "knuckle/pipeline/estimate_files.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/prepare/source_fingerprint.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::cli {
namespace {

const std::map<std::string, LabelState> kLeastStates{{"estimated", LabelState::estimated},
                                                     {"propagated", LabelState::propagated},
                                                     {"corrected", LabelState::corrected},
                                                     {"verified", LabelState::verified}};
const std::map<std::string, HandSide> kHandSides{{"right", HandSide::right}, {"left", HandSide::left}};

struct LabelsArguments {
  std::string source;
  std::filesystem::path labels;
  std::string author;
  std::vector<std::string> authors;
  LabelState state = LabelState::verified;
  std::optional<HandSide> side;
  bool leaves_out_hidden = false;
  int smooth_frames = 0;
  std::string convention;
  std::string format = "folder";
  std::filesystem::path out;
  std::filesystem::path poses;
  std::filesystem::path json;
};

// --- export ---

LabelledSourceOptions options_of(const LabelsArguments& arguments) {
  LabelledSourceOptions options{.least = arguments.state,
                                .side = arguments.side,
                                .keeps_hidden = !arguments.leaves_out_hidden,
                                .smooth_frames = arguments.smooth_frames,
                                .convention = {}};
  if (!arguments.convention.empty()) options.convention = convention_from_option(arguments.convention);
  return options;
}

void write_poses(const LabelledSource& labelled, const std::filesystem::path& out) {
  std::vector<HandPose> poses;
  for (std::int64_t i = 0; i < labelled.size(); ++i)
    poses.push_back(labelled.read_label(i).truth.value_or(HandPose::missing(*labelled.convention())));
  write_poses_file(out, *labelled.convention(), poses, labelled.pixel_origin());
}

/// The other hands of frames with both, in a file beside, as `estimate` names it; none where there are none.
void write_second_hands(const FrameSource& source, const LabelBook& book, const LabelsArguments& arguments) {
  if (arguments.side) return;
  LabelledSourceOptions options = options_of(arguments);
  options.takes_second = true;
  const LabelledSource second(source, book, options);
  if (second.labelled_count() > 0) write_poses(second, poses_path_of_hand(arguments.out, 1));
}

/// Frames without a hand get a pose of which nothing is known: all or none of a set are labelled.
void write_set(const LabelledSource& labelled, const LabelsArguments& arguments) {
  FrameWriterOptions options;
  if (arguments.format != "icg") options.depth_unit_mm = set_depth_unit_mm(labelled);
  const auto writer = create_frame_writer(arguments.format, arguments.out, options);
  Progress progress("export", "frames", labelled.size());
  parallel_for(labelled.size(), [&](std::int64_t i) {
    if (!writer->has(i)) {
      Frame frame = labelled.read(i);
      if (!frame.truth) frame.truth = HandPose::missing(*labelled.convention());
      writer->write(i, frame);
    }
    progress.advance();
  });
  writer->finish();
}

/// An .h5 set has columns for the 22 landmarks alone: those that a data set defines itself would be lost.
void require_room_for_landmarks(const Convention& convention, const LabelsArguments& arguments) {
  const auto shared = map_convention(convention, superset_convention()).shared;
  if (arguments.format != "h5" || std::ssize(shared) == convention.size()) return;
  fail("{}: an .h5 set holds the landmarks of {}, not all of {}; choose --format folder or poses",
       arguments.out.string(), superset_convention().name, convention.name);
}

void warn_of_what_is_left_out(const LabelledSource& labelled, const LabelsArguments& arguments) {
  if (labelled.without_mask_count() > 0) {
    fmt::print(stderr, "warning: {} of {} labelled frames have no mask: theirs is written empty\n",
               labelled.without_mask_count(), labelled.labelled_count());
  }
  if (arguments.format != "h5" && labelled.two_handed_count() > 0) {
    fmt::print(stderr,
               "warning: {} frames have both hands; the format {} holds one of them, h5 and poses both\n",
               labelled.two_handed_count(), arguments.format);
  }
}

void run_export(const LabelsArguments& arguments) {
  const auto source = open_source(arguments.source);
  const LabelBook book = read_label_file(label_file(arguments.labels, arguments.author));
  const LabelledSource labelled(*source, book, options_of(arguments));
  if (labelled.labelled_count() == 0) {
    fail("{}: no hand is {}; --state says how sure hands have to be", arguments.labels.string(),
         name_of(arguments.state));
  }
  require_room_for_landmarks(*labelled.convention(), arguments);
  if (arguments.format == "poses") {
    write_poses(labelled, arguments.out);
    write_second_hands(*source, book, arguments);
  } else {
    write_set(labelled, arguments);
    warn_of_what_is_left_out(labelled, arguments);
  }
  fmt::print("{}: {} of {} frames labelled in {}\n", printable(arguments.out.string()),
             labelled.labelled_count(), labelled.size(), labelled.convention()->name);
}

// --- import ---

/// A hand of a frame, of which something is known.
struct HandToImport {
  std::int64_t frame;
  HandTruth truth;
};

/// What a source is labelled with already: all hands in view, where it says them, else the one.
std::vector<HandToImport> hands_of_source(const LabelsArguments& arguments, const FrameSource& source) {
  if (!source.convention()) fail("{}: has no labels of its own; give --poses", arguments.source);
  std::vector<HandToImport> hands;
  for (std::int64_t i = 0; i < source.size(); ++i) {
    Frame frame = source.read(i);
    if (frame.hands.empty() && frame.truth) {
      frame.hands.push_back(
          {.side = frame.side.value_or(HandSide::right), .pose = *frame.truth, .occluders = {}});
    }
    for (HandTruth& hand : frame.hands) {
      if (frame.hands.size() == 1 && arguments.side) hand.side = *arguments.side;
      if (arguments.side.value_or(hand.side) == hand.side) hands.push_back({i, std::move(hand)});
    }
  }
  return hands;
}

std::vector<HandPose> poses_of_file(const LabelsArguments& arguments, const FrameSource& source) {
  PoseSequence sequence = read_poses_file(arguments.poses, std::nullopt, source.pixel_origin());
  if (static_cast<std::int64_t>(sequence.poses.size()) != source.size()) {
    fail("{}: {} poses, the source has {} frames", arguments.poses.string(), sequence.poses.size(),
         source.size());
  }
  return std::move(sequence.poses);
}

std::vector<HandToImport> hands_of_file(const LabelsArguments& arguments, const FrameSource& source) {
  std::vector<HandToImport> hands;
  std::int64_t frame = 0;
  for (HandPose& pose : poses_of_file(arguments, source)) {
    const std::optional<HandSide> of_source = arguments.side ? arguments.side : source.read_label(frame).side;
    hands.push_back(
        {frame++, {.side = of_source.value_or(HandSide::right), .pose = std::move(pose), .occluders = {}}});
  }
  return hands;
}

LabelChange imported(const HandToImport& hand, const LabelsArguments& arguments, const LabelBook& book) {
  const HandHistory* const before = book.find({hand.frame, hand.truth.side});
  LabelChange change{.frame = hand.frame,
                     .side = hand.truth.side,
                     .revision = before == nullptr ? 1 : before->revision() + 1,
                     .act = LabelAct::import,
                     .author = arguments.poses.empty() ? "source" : arguments.poses.filename().string()};
  for (const ImagePoint& joint : converted(hand.truth.pose, book.head().convention).joints)
    change.landmarks.push_back({.at = joint.is_missing() ? ImagePoint{} : joint, .state = arguments.state});
  return change;
}

void run_import(const LabelsArguments& arguments) {
  const auto source = open_source(arguments.source);
  const std::vector<HandToImport> hands =
      arguments.poses.empty() ? hands_of_source(arguments, *source) : hands_of_file(arguments, *source);
  const std::filesystem::path file = label_file(arguments.labels, arguments.author);
  const Convention convention =
      convention_from_option(arguments.convention.empty() ? "knuckle22" : arguments.convention);
  LabelJournal journal(file, {.source = arguments.source,
                              .fingerprint = source_fingerprint(arguments.source, {&file, 1}),
                              .frames = source->size(),
                              .convention = convention,
                              .camera = source->read_label(0).camera});
  std::vector<LabelChange> changes;
  std::set<HandKey> taken;
  std::set<std::int64_t> frames;
  for (const HandToImport& hand : hands) {
    if (hand.truth.pose.is_missing()) continue;
    if (!taken.insert({hand.frame, hand.truth.side}).second) continue;  // a second person's: labels have none
    changes.push_back(imported(hand, arguments, journal.book()));
    frames.insert(hand.frame);
  }
  journal.add_all(std::move(changes));
  if (journal.waiting() > 0) fail("{}", journal.fault());
  fmt::print("{}: {} of {} frames have labels now\n", printable(file.string()), frames.size(),
             source->size());
}

// --- compare ---

void print_agreement(std::string_view name, const LandmarkAgreement& agreement) {
  if (agreement.hands == 0) return;
  fmt::print("{:<16} {:>7} {:>9.2f} {:>11.2f} {:>18}\n", name, agreement.hands, agreement.mean_mm,
             agreement.largest_mm, agreement.of_other_visibility);
}

void print_times(const ComparedAuthor& author) {
  const LabelTimes& times = author.times;
  if (times.frames == 0) return;
  fmt::print("{}: worked on {} frames, {:.1f} s each (median), 90th percentile {:.1f} s, {:.0f} s in all\n",
             author.name, times.frames, times.median_s, times.percentile90_s, times.total_s);
}

void run_compare(const LabelsArguments& arguments) {
  const LabelBook one = read_label_file(label_file(arguments.labels, arguments.authors[0]));
  const LabelBook other = read_label_file(label_file(arguments.labels, arguments.authors[1]));
  std::unique_ptr<FrameSource> source;
  if (!arguments.source.empty()) source = open_source(arguments.source);
  const LabelAgreement agreement = agreement_of(one, other, arguments.state, [&](std::int64_t frame) {
    return source ? source->read_label(frame).camera : one.head().camera;
  });
  if (agreement.hands == 0)
    fail("{}: no hand is {} in the labels of both", arguments.labels.string(), name_of(arguments.state));
  fmt::print("{} hands; {} and {}\n{:<16} {:>7} {:>9} {:>11} {:>18}\n", agreement.hands, arguments.authors[0],
             arguments.authors[1], "landmark", "hands", "mean mm", "largest mm", "other visibility");
  for (std::size_t i = 0; i < agreement.landmarks.size(); ++i)
    print_agreement(name_of(one.head().convention.landmarks[i]), agreement.landmarks[i]);
  print_agreement("all", agreement.all);
  const std::array authors{ComparedAuthor{arguments.authors[0], times_of(one)},
                           ComparedAuthor{arguments.authors[1], times_of(other)}};
  for (const ComparedAuthor& author : authors) print_times(author);
  if (!arguments.json.empty())
    write_text_file(arguments.json, to_json(agreement, one.head().convention, authors));
}

// --- options ---

void add_state_option(CLI::App& verb, LabelsArguments& arguments, const std::string& says) {
  verb.add_option("--state", arguments.state, says)
      ->transform(CLI::CheckedTransformer(kLeastStates).description(""))
      ->type_name("estimated|propagated|corrected|verified")
      ->default_str(std::string(name_of(arguments.state)));
}

void add_labels_options(CLI::App& verb, LabelsArguments& arguments) {
  verb.add_option("--labels", arguments.labels, "Folder of the labels")->type_name("DIR")->required();
  verb.add_option("--author", arguments.author, "Whose labels; without it those of nobody in particular")
      ->type_name("NAME");
  verb.add_option("--convention", arguments.convention, "Landmarks: a name, or a file of one's own")
      ->type_name("NAME|FILE");
  verb.add_option("--side", arguments.side, "Which hand")
      ->transform(CLI::CheckedTransformer(kHandSides).description(""))
      ->type_name("right|left");
}

void add_export_verb(CLI::App& labels) {
  CLI::App& verb =
      add_verb(labels, "export", "Write a source with its labels as a data set",
               "knuckle labels export --source synthetic:manifests/demo.toml --labels demo_labels --out "
               "labelled --state estimated");
  auto arguments = std::make_shared<LabelsArguments>();
  add_source_option(verb, arguments->source);
  add_labels_options(verb, *arguments);
  add_state_option(verb, *arguments, "How sure hands have to be");
  verb.add_flag("--no-hidden", arguments->leaves_out_hidden, "Leave hidden landmarks out");
  verb.add_option("--smooth", arguments->smooth_frames,
                  "Landmarks as the labels of so many frames on both sides say together; 0: as they are")
      ->check(CLI::Range(0, 100))
      ->type_name("N")
      ->capture_default_str();
  std::vector<std::string> formats(frame_writer_formats().begin(), frame_writer_formats().end());
  formats.emplace_back("poses");
  verb.add_option("--format", arguments->format, "A set in this format, or a poses file alone")
      ->check(CLI::IsMember(formats).description(""))
      ->type_name("folder|h5|icg|poses")
      ->capture_default_str();
  verb.add_option("--out", arguments->out, "The new set or file")->required();
  verb.callback([arguments] { run_export(*arguments); });
}

void add_import_verb(CLI::App& labels) {
  CLI::App& verb =
      add_verb(labels, "import", "Begin labels with those that there are: of the source, or of a poses file",
               "knuckle labels import --source synthetic:manifests/demo.toml --labels demo_labels");
  auto arguments = std::make_shared<LabelsArguments>();
  arguments->state = LabelState::verified;
  add_source_option(verb, arguments->source);
  add_labels_options(verb, *arguments);
  add_state_option(verb, *arguments, "How sure they are");
  verb.add_option("--poses", arguments->poses, "A poses file; without it the source's own labels")
      ->type_name("FILE");
  verb.callback([arguments] { run_import(*arguments); });
}

void add_compare_verb(CLI::App& labels) {
  CLI::App& verb = add_verb(labels, "compare", "How far the labels of two authors are apart",
                            "knuckle labels compare --labels demo_labels --authors ann bea");
  auto arguments = std::make_shared<LabelsArguments>();
  verb.add_option("--labels", arguments->labels, "Folder of the labels")->type_name("DIR")->required();
  verb.add_option("--authors", arguments->authors, "Two names")->expected(2)->required();
  verb.add_option(
          "--source", arguments->source,
          "Where the frames come from, where their cameras differ; otherwise that of the first frame counts")
      ->type_name("SOURCE");
  add_state_option(verb, *arguments, "How sure hands have to be, of both");
  verb.add_option("--json", arguments->json, "The same as JSON, also per frame, with overlaps of masks")
      ->type_name("FILE");
  verb.callback([arguments] { run_compare(*arguments); });
}

}  // namespace

void add_labels(CLI::App& program) {
  CLI::App& labels = *program.add_subcommand("labels", "Export, import and compare labels");
  labels.footer("Example:\n  knuckle labels compare --labels demo_labels --authors ann bea");
  labels.require_subcommand(1);
  add_export_verb(labels);
  add_import_verb(labels);
  add_compare_verb(labels);
}

}  // namespace knuckle::cli
