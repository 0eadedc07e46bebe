// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/plan.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <set>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/options.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/core/resources.h"
#include "knuckle/core/text.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle {
namespace {

constexpr std::string_view kFolder = "experiments";
constexpr std::array<std::string_view, 3> kModelKinds = {"pose-forest", "segmentation-forest", "network"};
constexpr std::array<std::string_view, 2> kClaims = {"none", "scia15"};
/// Folders that an experiment makes for itself.
constexpr std::array<std::string_view, 7> kTaken = {"figures", "models",  "pipelines", "samples",
                                                    "tables",  "timings", "training"};

/// The text under `key`, which no table of the same kind may have as well.
std::string unique_text(const OptionTable& table, std::string_view key, std::set<std::string>& known) {
  std::string text = table.required_text(key);
  if (!known.insert(text).second) table.fail_at(key, fmt::format("\"{}\" stands twice", text));
  return text;
}

/// The same for a text that becomes the name of a file or folder.
std::string unique_file_name(const OptionTable& table, std::string_view key, std::set<std::string>& known) {
  std::string name = unique_text(table, key, known);
  const bool is_plain = std::ranges::all_of(
      name, [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.'; });
  if (!is_plain || name.empty() || name.starts_with('.')) {
    table.fail_at(
        key, fmt::format("\"{}\" is not a name for a file: expected letters, digits, '_', '-', '.'", name));
  }
  return name;
}

std::vector<PlannedSequence> read_sequences(const OptionTable& document) {
  std::set<std::string> names;
  std::vector<PlannedSequence> sequences;
  for (const OptionTable& table : document.tables("sequence")) {
    PlannedSequence sequence;
    sequence.name = unique_file_name(table, "name", names);
    if (std::ranges::count(kTaken, sequence.name) > 0) {
      table.fail_at("name", fmt::format("\"{}\" is a folder of the experiment itself", sequence.name));
    }
    sequence.title = table.text_or("title", sequence.name);
    sequence.source = source_in(table, "source");
    sequences.push_back(sequence);
  }
  if (sequences.empty()) document.fail_at("sequence", "expected at least one [[sequence]]");
  return sequences;
}

std::vector<PlannedModel> read_models(const OptionTable& document) {
  std::set<std::string> files;
  std::vector<PlannedModel> models;
  for (const OptionTable& table : document.tables("model")) {
    PlannedModel model;
    model.file = unique_file_name(table, "file", files);
    table.required_text("kind");
    model.kind = table.choice_or("kind", "", kModelKinds);
    model.config = table.resolved_path(table.required_text("config"));
    const std::string trained = table.text_or("trained", "");
    if (!trained.empty()) model.trained = table.resolved_path(trained);
    models.push_back(model);
  }
  return models;
}

/// Pipelines are copied into one folder, so no two of them may have the same file name.
std::vector<PlannedMethod> read_methods(const OptionTable& document, std::string_view key,
                                        std::map<std::string, std::filesystem::path>& pipelines) {
  std::set<std::string> names;
  std::set<std::string> stems;
  std::vector<PlannedMethod> methods;
  for (const OptionTable& table : document.tables(key)) {
    PlannedMethod method;
    method.name = unique_text(table, "name", names);
    if (!stems.insert(method.stem()).second) {
      table.fail_at("name",
                    fmt::format("\"{}\" shares its file name, {}, with another", method.name, method.stem()));
    }
    method.pipeline = table.resolved_path(table.required_text("pipeline"));
    const auto known = pipelines.emplace(method.pipeline.filename(), method.pipeline).first;
    if (known->second != method.pipeline) {
      table.fail_at("pipeline", fmt::format("{} has the file name of {}", method.pipeline.string(),
                                            known->second.string()));
    }
    methods.push_back(method);
  }
  return methods;
}

std::vector<std::string> shipped_plans() {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(resource_path(kFolder), none)) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem());
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace

std::string PlannedMethod::stem() const {
  std::string stem = name;
  std::ranges::replace_if(
      stem, [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '.'; }, '_');
  return stem;
}

ExperimentPlan ExperimentPlan::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  ExperimentPlan plan;
  plan.name = path.stem();
  plan.title = document.text_or("title", plan.name);
  plan.convention = convention_from_key(document, "convention", "icg20");
  plan.claims = document.choice_or("claims", "none", kClaims);
  plan.sequences = read_sequences(document);
  plan.models = read_models(document);
  std::map<std::string, std::filesystem::path> pipelines;
  plan.segmentation = read_methods(document, "segmentation", pipelines);
  plan.estimation = read_methods(document, "estimation", pipelines);
  document.finish();
  return plan;
}

ExperimentPlan find_plan(const std::string& name) {
  if (name.ends_with(".toml")) return ExperimentPlan::load(name);
  const std::filesystem::path path = resource_path(fmt::format("{}/{}.toml", kFolder, name));
  if (!std::filesystem::exists(path)) {
    fail("no experiment '{}'; known: {}, or the path of a plan (.toml)", name, joined(shipped_plans()));
  }
  return ExperimentPlan::load(path);
}

}  // namespace knuckle
