// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/data/selected_frames.h"

namespace knuckle {

/// What a person writes to name a source: `KIND:PATH[?key=value&...]`, as in
/// `nyu:/sets/nyu/test?view=2&count=100`. The keys `first`, `count` and `step` select frames; the others are
/// settings of the kind's reader.
struct SourceSpec {
  std::string text;            ///< as written, for messages
  std::string kind;            ///< for example "nyu"
  std::filesystem::path path;  ///< the set's folder or file
  FrameSelection selection;
  std::vector<std::pair<std::string, std::string>> settings;  ///< the reader's own keys with their values
};

/// Takes the text apart. Throws an Error where it has no kind, path or `=`, names a key twice, or selects
/// with a number that is none or out of range. Whether the kind and its settings exist is the matter of who
/// opens it.
SourceSpec parse_source_spec(std::string_view text);

/// The same for what need not have a path: a camera, as in `freenect:`.
SourceSpec parse_camera_spec(std::string_view text);

namespace detail {
void read_settings(const SourceSpec& spec, const std::function<void(OptionVisitor&)>& show_options);
}  // namespace detail

/// The reader's options as the settings say. Throws an Error that lists the known keys where one is unknown,
/// and one that names the key where its value is not a number or out of range.
template <VisitableOptions Options>
Options options_from(const SourceSpec& spec) {
  Options options;
  detail::read_settings(spec, [&](OptionVisitor& visitor) { options.visit(visitor); });
  return options;
}

/// For a kind without settings of its own: throws where there is one.
void require_no_settings(const SourceSpec& spec);

}  // namespace knuckle
