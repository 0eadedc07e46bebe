// SPDX-License-Identifier: Apache-2.0
#include "knuckle/cli/verb.h"

#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/suggestion.h"
#include "knuckle/core/text.h"
#include "knuckle/pipeline/start.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::cli {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;

std::vector<std::string>& remembered_arguments() {
  static std::vector<std::string> arguments;
  return arguments;
}

/// The verb that was typed, or the program itself where none was understood.
const CLI::App& innermost_verb(const CLI::App& program) {
  const CLI::App* verb = &program;
  while (!verb->get_subcommands().empty()) verb = verb->get_subcommands().back();
  return *verb;
}

std::vector<std::string> option_names(const CLI::App& verb) {
  std::vector<std::string> names;
  for (const CLI::Option* option : verb.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> verb_names(const CLI::App& program) {
  std::vector<std::string> names;
  for (const CLI::App* verb : program.get_subcommands({})) names.push_back(verb->get_name());
  return names;
}

/// The first word of the command line that the program does not know, with the nearest one that it does;
/// empty where it knows all.
std::string unknown_word(const CLI::App& program) {
  const CLI::App& verb = innermost_verb(program);
  const std::vector<std::string> unknown = verb.remaining();
  if (unknown.empty()) return {};
  const std::string word = unknown.front().substr(0, unknown.front().find('='));
  const bool is_option = word.starts_with("-");
  const std::vector<std::string> known = is_option ? option_names(verb) : verb_names(verb);
  const std::string help =
      &verb == &program ? "knuckle --help" : fmt::format("knuckle {} --help", verb.get_name());
  return fmt::format("unknown {} '{}'{}; `{}` lists what there is",
                     is_option       ? "option"
                     : known.empty() ? "argument"
                                     : "verb",
                     word, suggestion(word, known), help);
}

/// Says what is wrong with the command line, or prints the help that was asked for. Returns the exit status.
int explain(const CLI::App& program, const CLI::ParseError& error) {
  const bool may_be_mistyped = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError) ||
                               error.get_exit_code() == static_cast<int>(CLI::ExitCodes::RequiredError);
  const std::string unknown = may_be_mistyped ? unknown_word(program) : std::string();
  if (unknown.empty()) {
    std::ostringstream faults;
    const int status = program.exit(error, std::cout, faults);
    for (const std::string_view line : split(faults.view(), '\n')) {
      if (!line.empty()) fmt::print(stderr, "{}\n", message_line(line));
    }
    return status == 0 ? 0 : kWrongUsage;
  }
  fmt::print(stderr, "knuckle: {}\n", message_line(unknown));
  return kWrongUsage;
}

}  // namespace

CLI::App& add_verb(CLI::App& program, const std::string& name, const std::string& description,
                   const std::string& example) {
  CLI::App& verb = *program.add_subcommand(name, description);
  verb.footer("Example:\n  " + example);
  verb.add_option_function<int>("--threads", set_thread_count, "Threads to use, 0 to 4096; 0: one per core")
      ->check(CLI::Range(0, 4096).description(""))
      ->type_name("N")
      ->default_str("0");
  return verb;
}

void add_source_option(CLI::App& verb, std::string& source) {
  verb.add_option(
          "--source", source,
          "Where frames come from, KIND:PATH[?first=..&count=..&step=..]; `knuckle info` lists the kinds")
      ->type_name("SOURCE")
      ->required();
}

void add_init_option(CLI::App& verb, std::string& init) {
  verb.add_option("--init", init, "Where segmentation starts: at the nearest point, or at the true palm")
      ->type_name("")
      ->check(CLI::IsMember(std::vector<std::string>(std::begin(kStartNames), std::end(kStartNames))))
      ->capture_default_str();
}

void add_landmarks_option(CLI::App& verb, std::filesystem::path& landmarks, const std::string& does) {
  verb.add_option("--landmarks", landmarks,
                  does +
                      ": a file of `knuckle landmarks`, or mediapipe21, icg20, nyu14, icvl16 of those that "
                      "are shipped")
      ->type_name("FILE");
}

const std::vector<std::string>& command_line_arguments() {
  return remembered_arguments();
}

int run_program(const std::string& description, void (*add_verbs)(CLI::App& program), int count,
                char** arguments) {
  try {
    CLI::App program(description);
    program.name("knuckle");
    program.require_subcommand(1);
    program.set_version_flag("--version", "knuckle " KNUCKLE_VERSION, "Print the version and exit");
    remembered_arguments().assign(arguments, arguments + count);
    add_verbs(program);
    watch_for_interruption();
    try {
      program.parse(count, arguments);
    } catch (const CLI::ParseError& error) {
      return explain(program, error);
    }
    return 0;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "knuckle: there is not enough memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "knuckle: {}\n", message_line(error.what()));
  }
  return kFailed;
}

void write_resolved_options(const std::filesystem::path& output, std::string_view toml) {
  std::filesystem::path path = output / "options.toml";
  if (!std::filesystem::is_directory(output)) path = output.string() + ".options.toml";
  write_text_file(path, fmt::format("# {}\n{}", fmt::join(command_line_arguments(), " "), toml));
}

}  // namespace knuckle::cli
