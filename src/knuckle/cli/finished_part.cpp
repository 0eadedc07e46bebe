// SPDX-License-Identifier: Apache-2.0
#include "knuckle/cli/finished_part.h"

#include <cstdio>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/h5_source.h"

namespace fs = std::filesystem;

namespace knuckle::cli {
namespace {

/// What differs from the part that is to be made; empty where nothing does.
std::string difference(const H5Facts& found, const FrameWriterOptions& wanted) {
  if (found.frames != IndexRange{wanted.first, wanted.count} || found.part_of != wanted.part_of ||
      found.manifest != wanted.manifest) {
    return "is another part, or of another set";
  }
  if (found.generator != wanted.generator) {
    return fmt::format("was rendered by {}, this is {}",
                       found.generator.empty() ? "another version of the program" : found.generator,
                       wanted.generator);
  }
  return "";
}

/// Nothing is lost: a file that is taken for a broken part may be somebody's who mistook the name.
void set_aside(const fs::path& out, std::string_view fault) {
  const fs::path aside = out.string() + ".broken";
  std::error_code code;
  fs::rename(out, aside, code);
  if (code) fail("{}; it cannot be moved to {}: {}", fault, aside.string(), code.message());
  fmt::print(stderr, "warning: {}; it is {} now, and is rendered again\n", printable(fault),
             printable(aside.string()));
}

}  // namespace

bool is_part_finished(const fs::path& out, const FrameWriterOptions& options) {
  if (!options.part_of || !fs::exists(out)) return false;
  if (!fs::is_regular_file(out)) fail("{}: is no file; name another", out.string());
  std::string found;
  try {
    found = difference(check_h5(out), options);
  } catch (const Error& error) {
    set_aside(out, error.what());
    return false;
  }
  if (!found.empty()) fail("{}: {}; remove it, or name another file", out.string(), found);
  return true;
}

}  // namespace knuckle::cli
