// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/training_source.h"

#include <array>

#include "knuckle/core/error.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle {
namespace {

constexpr std::string_view kKey = "source";
const Interval kHoldoutRange = closed(0, 0.9);

/// The key `holdout` beside a source that is a text.
struct HoldoutBeside {
  double& share;
  void visit(OptionVisitor& visitor) { visitor.real("holdout", share, kHoldoutRange); }
};

}  // namespace

void TrainingSource::visit(OptionVisitor& visitor) {
  static constexpr std::array<std::string_view, 2> kSides{"right", "left"};
  visitor.real("weight", weight, closed(0.001, 1000));
  visitor.choice("side", side, kSides);
  visitor.real("holdout", holdout, kHoldoutRange);
  visitor.integer("most", most, closed(0, 1e9));
  visitor.integer("most_things", most_things, closed(0, 1e9));
}

std::vector<OptionTable> source_tables_in(const OptionTable& document) {
  try {
    return document.tables(kKey);
  } catch (const Error&) {
    return {};  // who reads it as a text says what is wrong with it
  }
}

std::string one_source_in(const OptionTable& document) {
  try {
    return source_in(document, kKey);
  } catch (const Error&) {
    if (!document.has(kKey)) throw;
    document.fail_at(kKey,
                     "expected a text (KIND:PATH), or where there are several sets a table [[source]] for "
                     "each");
  }
}

std::vector<TrainingSource> training_sources_in(const OptionTable& document, const TrainingSource& defaults) {
  std::vector<TrainingSource> sources;
  for (const OptionTable& table : source_tables_in(document)) {
    TrainingSource& source = sources.emplace_back(defaults);
    source.source = source_in(table, kKey);
    table.read(source);
  }
  if (!sources.empty()) return sources;
  TrainingSource& one = sources.emplace_back(defaults);
  one.source = one_source_in(document);
  HoldoutBeside beside{one.holdout};
  document.read(beside);
  return sources;
}

}  // namespace knuckle
