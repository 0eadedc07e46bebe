// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

namespace knuckle::cli {

/// Adds a verb with its example and the options that all verbs have.
CLI::App& add_verb(CLI::App& program, const std::string& name, const std::string& description,
                   const std::string& example);

// One file a verb; each adds its verb to the program.
void add_annotate(CLI::App& program);
void add_cameras(CLI::App& program);
void add_demo(CLI::App& program);
void add_estimate(CLI::App& program);
void add_evaluate(CLI::App& program);
void add_experiment(CLI::App& program);
void add_export(CLI::App& program);
void add_info(CLI::App& program);
void add_inspect(CLI::App& program);
void add_labels(CLI::App& program);
void add_landmarks(CLI::App& program);
void add_live(CLI::App& program);
void add_record(CLI::App& program);
void add_shrink(CLI::App& program);
void add_render(CLI::App& program);
void add_join(CLI::App& program);
void add_segment(CLI::App& program);
void add_train(CLI::App& program);

/// Adds --source, which must be given.
void add_source_option(CLI::App& verb, std::string& source);

/// Adds --init nearest|truth: where segmentation starts.
void add_init_option(CLI::App& verb, std::string& init);

/// Adds --landmarks, a definition of where a convention's landmarks lie; `does` says what happens with it.
void add_landmarks_option(CLI::App& verb, std::filesystem::path& landmarks, const std::string& does);

/// Writes the options that a run used beside what it made: "poses.txt" gets "poses.txt.options.toml", a
/// folder gets "options.toml" in it. The command line comes first, as a comment.
void write_resolved_options(const std::filesystem::path& output, std::string_view toml);

/// The command line of this run, the program's name first.
const std::vector<std::string>& command_line_arguments();

/// What `main` does: parses the command line with the verbs that `add_verbs` adds, runs one, prints an Error
/// as one line. Returns the exit status.
int run_program(const std::string& description, void (*add_verbs)(CLI::App& program), int count,
                char** arguments);

}  // namespace knuckle::cli
