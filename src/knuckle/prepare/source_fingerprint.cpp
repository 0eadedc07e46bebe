// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/source_fingerprint.h"

#include <algorithm>
#include <set>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/data/readers/h5_parts.h"
#include "knuckle/data/source_spec.h"
#include "knuckle/hand/body_file.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/synth/manifest.h"
#include "knuckle/synth/synthetic_source.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

/// A file's size and time of writing.
std::string state_of(const fs::path& file) {
  std::error_code fault;
  const std::uintmax_t size = fs::file_size(file, fault);
  if (fault) fail("{}: cannot be read: {}", file.string(), fault.message());
  const auto written = fs::last_write_time(file, fault).time_since_epoch().count();
  return fmt::format("{} bytes, written {}", size, written);
}

std::string listing_of(const fs::path& folder, const std::set<fs::path>& except) {
  std::vector<std::string> lines;
  constexpr auto kOptions = fs::directory_options::follow_directory_symlink;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, kOptions)) {
    const fs::path& path = entry.path();
    const bool counts = entry.is_regular_file() && !path.filename().string().starts_with('.') &&
                        !except.contains(fs::weakly_canonical(path));
    if (counts)
      lines.push_back(fmt::format("{}: {}\n", path.lexically_relative(folder).string(), state_of(path)));
  }
  std::ranges::sort(lines);
  std::string listing;
  for (const std::string& line : lines) listing += line;
  return listing;
}

std::string state_of_synthetic(const fs::path& path) {
  const Manifest manifest = load_manifest(path);
  const std::string& file = manifest.body.file;
  return fmt::format("{}\n{}", manifest.resolved,
                     file.empty() ? body_hash(body_of(manifest)) : state_of(path.parent_path() / file));
}

}  // namespace

std::string source_fingerprint(const std::string& source, std::span<const fs::path> except) {
  const SourceSpec spec = parse_source_spec(source);
  std::string text = fmt::format("{} {} {} {}\n", spec.kind, spec.selection.first, spec.selection.count,
                                 spec.selection.step);
  for (const auto& [key, value] : spec.settings) text += fmt::format("{}={}\n", key, value);
  if (spec.kind == "synthetic") return text_hash(text + state_of_synthetic(spec.path));
  if (names_several_files(spec.path)) {
    for (const fs::path& part : matching_files(spec.path))
      text += fmt::format("{}: {}\n", part.filename().string(), state_of(part));
    return text_hash(text);
  }
  if (!fs::is_directory(spec.path)) return text_hash(text + state_of(spec.path));
  std::set<fs::path> skipped;
  for (const fs::path& path : except) skipped.insert(fs::weakly_canonical(path));
  return text_hash(text + listing_of(spec.path, skipped));
}

}  // namespace knuckle
