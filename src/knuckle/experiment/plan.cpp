// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/plan.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/options.h"
#include "knuckle/core/resources.h"
#include "knuckle/core/text.h"
#include "knuckle/pipeline/open_source.h"

namespace knuckle {
namespace {

constexpr std::string_view kFolder = "experiments";

/// The text under `key`, which no table of the same kind may have as well.
std::string unique_text(const OptionTable& table, std::string_view key, std::set<std::string>& known) {
  std::string text = table.required_text(key);
  if (!known.insert(text).second) table.fail_at(key, fmt::format("\"{}\" stands twice", text));
  return text;
}

std::vector<PlannedSequence> read_sequences(const OptionTable& document) {
  std::set<std::string> names;
  std::vector<PlannedSequence> sequences;
  for (const OptionTable& table : document.tables("sequence")) {
    PlannedSequence sequence;
    sequence.name = unique_text(table, "name", names);
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
    model.file = unique_text(table, "file", files);
    model.kind = table.required_text("kind");
    model.config = table.resolved_path(table.required_text("config"));
    models.push_back(model);
  }
  return models;
}

std::vector<PlannedMethod> read_methods(const OptionTable& document, std::string_view key) {
  std::set<std::string> names;
  std::vector<PlannedMethod> methods;
  for (const OptionTable& table : document.tables(key)) {
    PlannedMethod method;
    method.name = unique_text(table, "name", names);
    method.pipeline = table.resolved_path(table.required_text("pipeline"));
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

ExperimentPlan ExperimentPlan::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  ExperimentPlan plan;
  plan.name = path.stem();
  plan.title = document.text_or("title", plan.name);
  plan.convention = convention_from_name(document.text_or("convention", "icg20"));
  plan.sequences = read_sequences(document);
  plan.models = read_models(document);
  plan.segmentation = read_methods(document, "segmentation");
  plan.estimation = read_methods(document, "estimation");
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
