// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/inputs.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "knuckle/core/options.h"
#include "knuckle/data/source_spec.h"
#include "knuckle/hand/body_file.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/synth/manifest.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle {
namespace {

std::vector<std::filesystem::path> files_below(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

/// The models of an estimator that has several.
struct ModelFiles {
  std::vector<std::string> models;

  void visit(OptionVisitor& visitor) { visitor.texts("models", models, {}); }
};

}  // namespace

std::vector<PipelineModel> models_named_in(const OptionTable& pipeline) {
  std::vector<PipelineModel> models;
  for (const char* table : {"segmentation", "estimator"}) {
    const std::string model = pipeline.table(table).text_or("model", "");
    if (!model.empty()) models.push_back({table, model});
  }
  ModelFiles several;
  pipeline.table("estimator").read(several);
  for (const std::string& model : several.models) models.push_back({"estimator", model});
  return models;
}

Inputs& Inputs::add(std::string_view name, std::string_view value) {
  text_ += fmt::format("{}: {}\n", name, value);
  return *this;
}

Inputs& Inputs::add_content(std::string_view name, const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return add(name, content_hash(path));
  for (const std::filesystem::path& file : files_below(path)) {
    add(fmt::format("{}/{}", name, std::filesystem::relative(file, path).string()), content_hash(file));
  }
  return *this;
}

Inputs& Inputs::add_content_if_there(std::string_view name, const std::filesystem::path& path) {
  return std::filesystem::exists(path) ? add_content(name, path) : add(name, "none");
}

Inputs& Inputs::add_source(std::string_view name, const std::string& source) {
  const SourceSpec spec = parse_source_spec(source);
  const std::size_t settings = std::min(source.find('?'), source.size());
  add(name, fmt::format("{}{}", spec.kind, source.substr(settings)));
  add_content(fmt::format("{} content", name), spec.path);
  return spec.kind == "synthetic" ? add_body(name, load_manifest(spec.path)) : *this;
}

Inputs& Inputs::add_body(std::string_view name, const Manifest& manifest) {
  const std::string title = fmt::format("{} body", name);
  const std::string& file = manifest.body.file;
  if (file.empty()) return add(title, body_hash(body_of(manifest)));
  return add_content(title, manifest.path.parent_path() / file);
}

Inputs& Inputs::add_pipeline(const std::filesystem::path& pipeline) {
  return add_content("pipeline", pipeline).add_models(pipeline);
}

Inputs& Inputs::add_models(const std::filesystem::path& pipeline) {
  const OptionTable document = OptionTable::load(pipeline);
  for (const PipelineModel& model : models_named_in(document))
    add_content(fmt::format("{} model", model.table), document.resolved_path(model.file));
  return *this;
}

}  // namespace knuckle
