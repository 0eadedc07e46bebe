// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/open_source.h"

#include <algorithm>
#include <functional>

#include "knuckle/core/error.h"
#include "knuckle/core/named_table.h"
#include "knuckle/data/played_stream.h"
#include "knuckle/data/readers/open_dataset.h"
#include "knuckle/stream/open_camera.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle {
namespace {

std::unique_ptr<FrameSource> open_manifest(const SourceSpec& spec) {
  require_no_settings(spec);
  return open_synthetic(spec.path);
}

/// The data sets', and the generator's.
std::vector<DatasetKind> all_kinds() {
  std::vector<DatasetKind> kinds(dataset_kinds().begin(), dataset_kinds().end());
  kinds.push_back({"oni", "recording of OpenNI2, one .oni file", open_oni});
  kinds.push_back({"synthetic", "frames rendered as a manifest says, as they are read", open_manifest});
  return kinds;
}

std::unique_ptr<FrameSource> open_source_of(const SourceSpec& spec) {
  const std::vector<DatasetKind> kinds = all_kinds();
  const DatasetKind* const kind = row_named(kinds, spec.kind);
  if (kind == nullptr) fail("{}: {}", spec.text, unknown_name("kind of source", spec.kind, names_of(kinds)));
  return open_frames(*kind, spec);
}

/// A stream is a camera or a source.
void require_kind_of_stream(const SourceSpec& spec) {
  const std::vector<DatasetKind> sources = all_kinds();
  if (row_named(sources, spec.kind) != nullptr) return;
  std::vector<std::string_view> names = names_of(sources);
  for (const CameraKind& kind : camera_kinds()) names.push_back(kind.name);
  fail("{}: {}", spec.text, unknown_name("kind of stream", spec.kind, names));
}

}  // namespace

std::unique_ptr<FrameSource> open_source(std::string_view text) {
  if (names_a_camera(text))
    fail("{}: is a camera, for `live` and `record`; record it, and use the recording", text);
  return open_source_of(parse_source_spec(text));
}

std::unique_ptr<FrameStream> open_stream(std::string_view text) {
  if (names_a_camera(text)) return open_camera(text);
  SourceSpec of_source = parse_source_spec(text);
  require_kind_of_stream(of_source);
  SourceSpec of_stream = of_source;
  const auto is_of_stream = [](const auto& setting) {
    return setting.first == "rate" || setting.first == "loop";
  };
  std::erase_if(of_source.settings, is_of_stream);
  std::erase_if(of_stream.settings, std::not_fn(is_of_stream));
  const auto options = options_from<PlayOptions>(of_stream);
  return std::make_unique<PlayedStream>(open_source_of(of_source), options);
}

std::vector<std::string> source_kinds() {
  std::vector<std::string> kinds;
  for (const DatasetKind& kind : all_kinds()) kinds.emplace_back(kind.name);
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
