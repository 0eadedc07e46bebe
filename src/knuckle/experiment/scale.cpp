// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/scale.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/data/source_spec.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/synth/manifest.h"

namespace knuckle {
namespace {

std::string text_of(const SourceSpec& spec) {
  std::string text = fmt::format("{}:{}", spec.kind, spec.path.string());
  char separator = '?';
  const auto add = [&](std::string_view key, const auto& value) {
    text += fmt::format("{}{}={}", separator, key, value);
    separator = '&';
  };
  const FrameSelection all;
  if (spec.selection.first != all.first) add("first", spec.selection.first);
  if (spec.selection.count != all.count) add("count", spec.selection.count);
  if (spec.selection.step != all.step) add("step", spec.selection.step);
  for (const auto& [key, value] : spec.settings) add(key, value);
  return text;
}

/// Synthetic frames are counted without the body that they show, which takes a while to load.
std::int64_t frames_of(const SourceSpec& spec) {
  if (spec.kind != "synthetic") return open_source(spec.text)->size();
  const std::int64_t all = load_manifest(spec.path).frames;
  const FrameSelection& taken = spec.selection;
  if (taken.first >= all) fail("{}: of {} frames none is left", spec.text, all);
  return std::min<std::int64_t>(taken.count, (all - taken.first + taken.step - 1) / taken.step);
}

}  // namespace

double scaled(double value, Scaling how, double s, double least) {
  double result = value;
  if (how == Scaling::amount) result = value * s;
  if (how == Scaling::size) result = value * std::sqrt(s);
  if (how == Scaling::depth) result = value + std::log2(s);
  return std::min(value, std::max(result, least));
}

std::int64_t scaled_count(std::int64_t value, Scaling how, double s, std::int64_t least) {
  return std::llround(scaled(static_cast<double>(value), how, s, static_cast<double>(least)));
}

std::string scaled_test_source(const std::string& source, double s) {
  if (s == 1.0) return source;
  SourceSpec spec = parse_source_spec(source);
  const std::int64_t frames = frames_of(spec);
  const std::int64_t count = scaled_count(frames, Scaling::amount, s, kFewestTestFrames);
  spec.selection.count = static_cast<int>(count);
  spec.selection.step *= static_cast<int>(std::max<std::int64_t>(1, frames / count));
  return text_of(spec);
}

std::string scaled_training_source(const std::string& source, double s) {
  if (s == 1.0) return source;
  SourceSpec spec = parse_source_spec(source);
  spec.selection.count =
      static_cast<int>(scaled_count(frames_of(spec), Scaling::amount, s, kFewestTrainingFrames));
  return text_of(spec);
}

}  // namespace knuckle
