// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/open_source.h"

#include <algorithm>

#include "knuckle/core/error.h"
#include "knuckle/core/suggestion.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/open_dataset.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle {
namespace {

constexpr std::string_view kSynthetic = "synthetic";

std::unique_ptr<FrameSource> open_synthetic_frames(const SourceSpec& spec) {
  require_no_settings(spec);
  return select_frames(open_synthetic(spec.path), spec.selection, spec.text);
}

}  // namespace

std::unique_ptr<FrameSource> open_source(std::string_view text) {
  const SourceSpec spec = parse_source_spec(text);
  if (spec.kind == kSynthetic) return open_synthetic_frames(spec);
  if (!names_a_source(text)) {
    fail("{}: unknown kind of source '{}'{}; known are {}", text, spec.kind,
         suggestion(spec.kind, source_kinds()), joined(source_kinds()));
  }
  return open_dataset(spec);
}

std::vector<std::string> source_kinds() {
  std::vector<std::string> kinds;
  for (const DatasetKind& kind : dataset_kinds()) kinds.emplace_back(kind.name);
  kinds.emplace_back(kSynthetic);
  return kinds;
}

bool names_a_source(std::string_view text) {
  const std::string_view kind = text.substr(0, text.find(':'));
  return kind.size() < text.size() && std::ranges::count(source_kinds(), kind) > 0;
}

std::string source_in(const OptionTable& document, std::string_view key) {
  std::string text = document.required_text(key);
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return text;  // the opener says what is wrong with it
  return text.substr(0, colon + 1) + document.resolved_path(text.substr(colon + 1)).string();
}

}  // namespace knuckle
