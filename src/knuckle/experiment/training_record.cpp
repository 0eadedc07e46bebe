// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/training_record.h"

#include <algorithm>
#include <map>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/experiment/layout.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using Columns = std::map<std::string, std::vector<double>, std::less<>>;

/// A CSV file of numbers, by the heads of its columns.
Columns read_columns(const std::filesystem::path& path) {
  const std::vector<std::string> lines = read_lines(path);
  if (lines.empty()) fail("{}: expected metrics, found nothing", path.string());
  const std::vector<std::string_view> heads = split(lines.front(), ',');
  Columns columns;
  for (const std::string_view head : heads) {
    if (!columns.try_emplace(std::string(head)).second) fail("{}: two columns {}", path.string(), head);
  }
  for (std::size_t row = 1; row < lines.size(); ++row) {
    const std::string where = fmt::format("{}:{}", path.string(), row + 1);
    const std::vector<double> numbers = parse_numbers(lines[row], where);
    if (numbers.size() != heads.size())
      fail("{}: {} columns, expected {}", where, numbers.size(), heads.size());
    for (std::size_t i = 0; i < heads.size(); ++i) columns[std::string(heads[i])].push_back(numbers[i]);
  }
  return columns;
}

const std::vector<double>& column(const Columns& columns, std::string_view head,
                                  const std::filesystem::path& path) {
  const auto found = columns.find(head);
  if (found == columns.end()) fail("{}: no column {}", path.string(), head);
  return found->second;
}

/// Time and samples of a network's training, and its best validation.
void add_metrics(const std::filesystem::path& path, TrainingRecord& record) {
  const Columns columns = read_columns(path);
  const std::vector<double>& samples = column(columns, "samples", path);
  const std::vector<double>& rates = column(columns, "samples_per_second", path);
  double seconds = 0.0;
  double before = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (rates[i] > 0.0) seconds += (samples[i] - before) / rates[i];
    before = samples[i];
  }
  record.seconds = seconds;
  constexpr double kMostSamples = 1e15;  // of so many each is a whole number
  if (!(before >= 0.0 && before <= kMostSamples))
    fail("{}: {} samples, expected a number of them", path.string(), before);
  record.samples = static_cast<std::int64_t>(before);
  for (const double error : column(columns, "validation_second_mm", path)) {
    if (!(error >= record.validation_mm)) record.validation_mm = error;
  }
}

void write_record(const std::filesystem::path& model, const nlohmann::ordered_json& record) {
  write_text_file(ExperimentFolder::training_record(model), record.dump(2) + "\n");
}

}  // namespace

void write_given_record(const std::filesystem::path& model, const std::filesystem::path& given) {
  write_record(model, {{"given", given.string()}});
}

void write_trained_record(const std::filesystem::path& model, double seconds) {
  write_record(model, {{"seconds", seconds}});
}

TrainingRecord read_training_record(const std::filesystem::path& model) {
  TrainingRecord record;
  record.model = model.filename().string();
  const std::filesystem::path notes = ExperimentFolder::training_record(model);
  try {
    const auto json = nlohmann::json::parse(read_text_file(notes));
    record.given = json.value("given", "");
    if (json.contains("seconds")) record.seconds = json.at("seconds").get<double>();
  } catch (const nlohmann::json::exception& error) {
    fail("{}: no record of a training: {}", notes.string(), error.what());
  }
  const std::filesystem::path metrics = ExperimentFolder::metrics(model);
  if (std::filesystem::exists(metrics)) add_metrics(metrics, record);
  return record;
}

}  // namespace knuckle
