// SPDX-License-Identifier: Apache-2.0
#include "knuckle/cli/verb.h"

#include <cstdio>
#include <exception>
#include <new>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/parallel.h"
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

}  // namespace

CLI::App& add_verb(CLI::App& program, const std::string& name, const std::string& description,
                   const std::string& example) {
  CLI::App& verb = *program.add_subcommand(name, description);
  verb.footer("Example:\n  " + example);
  verb.add_option_function<int>("--threads", set_thread_count, "Threads to use, 0 to 4096; 0: one a core")
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

const std::vector<std::string>& command_line_arguments() {
  return remembered_arguments();
}

int run_program(const std::string& description, void (*add_verbs)(CLI::App& program), int count,
                char** arguments) {
  try {
    CLI::App program(description);
    program.name("knuckle");
    program.require_subcommand(1);
    remembered_arguments().assign(arguments, arguments + count);
    add_verbs(program);
    watch_for_interruption();
    try {
      program.parse(count, arguments);
    } catch (const CLI::ParseError& error) {
      return program.exit(error) == 0 ? 0 : kWrongUsage;
    }
    return 0;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "knuckle: there is not enough memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "knuckle: {}\n", error.what());
  }
  return kFailed;
}

void write_resolved_options(const std::filesystem::path& output, std::string_view toml) {
  std::filesystem::path path = output / "options.toml";
  if (!std::filesystem::is_directory(output)) path = output.string() + ".options.toml";
  write_text_file(path, fmt::format("# {}\n{}", fmt::join(command_line_arguments(), " "), toml));
}

}  // namespace knuckle::cli
