// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/training_config.h"

#include <array>
#include <cmath>
#include <optional>
#include <sstream>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "knuckle/core/text_file.h"
#include "knuckle/data/source_spec.h"
#include "knuckle/experiment/network_config.h"
#include "knuckle/experiment/scale.h"
#include "knuckle/prepare/pose_forest_training.h"
#include "knuckle/prepare/segmentation_forest_training.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/synth/manifest.h"

namespace knuckle {
namespace {

/// How one value of a configuration follows the scale.
struct ScaleRule {
  std::string_view table;
  std::string_view key;
  Scaling how;
  double least;
};

/// A value that a configuration does not have is passed over. 0 samples are all samples, and stay so.
constexpr std::array kRules{
    ScaleRule{"forest", "trees", Scaling::size, 2},
    ScaleRule{"forest", "max_depth", Scaling::depth, 6},
    ScaleRule{"forest", "splits_per_node", Scaling::size, 100},
    ScaleRule{"forest", "samples_per_node", Scaling::size, 100},
    ScaleRule{"samples", "most", Scaling::amount, kFewestTrainingFrames},
    ScaleRule{"samples", "most_validation", Scaling::amount, kFewestTrainingFrames},
    ScaleRule{"training", "epochs", Scaling::size, 1},
    ScaleRule{"training", "validate_every", Scaling::size, 10},
    ScaleRule{"network", "hidden_units", Scaling::size, 32},
    ScaleRule{"network", "first_maps", Scaling::size, 4},
    ScaleRule{"network", "second_maps", Scaling::size, 4},
    ScaleRule{"network", "stem_channels", Scaling::size, 4},
    ScaleRule{"network", "quarter_channels", Scaling::size, 4},
    ScaleRule{"network", "eighth_channels", Scaling::size, 4},
    ScaleRule{"network", "sixteenth_channels", Scaling::size, 4},
    ScaleRule{"network", "head_channels", Scaling::size, 4},
};
constexpr int kFewestPeople = 5;
constexpr std::string_view kSynthetic = "synthetic";

void apply(const ScaleRule& rule, double s, toml::table& config) {
  toml::node* const node = config.at_path(fmt::format("{}.{}", rule.table, rule.key)).node();
  if (node == nullptr) return;
  if (toml::value<std::int64_t>* const whole = node->as_integer()) {
    *whole = std::llround(scaled(static_cast<double>(whole->get()), rule.how, s, rule.least));
  } else if (toml::value<double>* const real = node->as_floating_point()) {
    *real = scaled(real->get(), rule.how, s, rule.least);
  }
}

std::string text_of(const toml::table& table) {
  std::ostringstream text;
  text << table << "\n";
  return text.str();
}

void write_if_changed(const std::filesystem::path& path, const std::string& text) {
  if (std::filesystem::exists(path) && read_text_file(path) == text) return;
  make_folder(path.parent_path());
  write_text_file(path, text);
}

/// Writes the manifest with fewer people.
void write_scaled_manifest(const std::filesystem::path& original, double s,
                           const std::filesystem::path& out) {
  const Manifest manifest = load_manifest(original);
  toml::table document = toml::parse(manifest.resolved);
  toml::table& body = *document["body"].as_table();
  body.insert_or_assign("people", scaled_count(manifest.body.people, Scaling::size, s, kFewestPeople));
  if (!manifest.body.file.empty()) {
    body.insert_or_assign("file",
                          std::filesystem::absolute(original.parent_path() / manifest.body.file).string());
  }
  write_if_changed(out, text_of(document));
}

std::string with_path(const std::string& source, const std::filesystem::path& path) {
  const std::size_t settings = source.find('?');
  return fmt::format("{}:{}{}", parse_source_spec(source).kind, std::filesystem::absolute(path).string(),
                     settings == std::string::npos ? "" : source.substr(settings));
}

/// The source that `key` of the configuration becomes.
std::string scaled_source(const std::string& source, double s, const std::filesystem::path& config,
                          std::string_view key) {
  const SourceSpec spec = parse_source_spec(source);
  if (s == 1.0) return with_path(source, spec.path);
  const std::string fewer = scaled_training_source(source, s);
  if (spec.kind != kSynthetic) return with_path(fewer, spec.path);
  std::filesystem::path manifest = config;
  manifest.replace_extension(fmt::format("{}.toml", key));
  write_scaled_manifest(spec.path, s, manifest);
  return with_path(fewer, manifest);
}

/// A configuration with its defaults, as far as rules speak of them.
struct ReadConfig {
  toml::table document;
  std::vector<std::pair<std::string, std::string>> sources;  ///< key and source
};

ReadConfig read_network_config(const std::filesystem::path& path) {
  const auto config = NetworkConfig::load(path);
  toml::table document = toml::parse(read_text_file(path));
  document.insert_or_assign("network", toml::parse(options_as_toml(config.network)));
  return {std::move(document), {{"source", config.source}, {"validation", config.validation}}};
}

template <class Config>
ReadConfig read_forest_config(const std::filesystem::path& path) {
  const auto config = Config::load(path);
  return {toml::parse(config.resolved_options), {{"source", config.source}}};
}

ReadConfig read_config(std::string_view kind, const std::filesystem::path& path) {
  if (kind == "network") return read_network_config(path);
  if (kind == "pose-forest") return read_forest_config<PoseForestTrainingConfig>(path);
  return read_forest_config<SegmentationForestTrainingConfig>(path);
}

/// Makes the path under `key`, where there is one, absolute, and returns it.
std::optional<std::filesystem::path> absolute_path_in(toml::table& config, std::string_view key,
                                                      const std::filesystem::path& folder) {
  toml::value<std::string>* const text = config.at_path(key).as_string();
  if (text == nullptr || text->get().empty()) return std::nullopt;
  *text = std::filesystem::absolute(folder / text->get()).string();
  return text->get();
}

}  // namespace

ScaledTraining write_scaled_training(std::string_view kind, const std::filesystem::path& original, double s,
                                     const std::filesystem::path& config) {
  ReadConfig read = read_config(kind, original);
  toml::table& document = read.document;
  ScaledTraining training{config, {}, {}};
  // Weights to start from do not fit a smaller network.
  if (s < 1.0 && document.contains("initial")) document.insert_or_assign("initial", "");
  for (const char* key : {"segmentation.model", "initial"}) {
    if (const auto model = absolute_path_in(document, key, original.parent_path()))
      training.models.push_back(*model);
  }
  for (const auto& [key, source] : read.sources) {
    training.sources.push_back(scaled_source(source, s, config, key));
    document.insert_or_assign(key, training.sources.back());
  }
  for (const ScaleRule& rule : kRules) {
    const bool means_all = rule.how == Scaling::amount &&
                           document.at_path(fmt::format("{}.{}", rule.table, rule.key)).value_or(1.0) == 0.0;
    if (!means_all) apply(rule, s, document);
  }
  write_if_changed(config,
                   fmt::format("# {} at scale {}\n{}", original.filename().string(), s, text_of(document)));
  return training;
}

}  // namespace knuckle
