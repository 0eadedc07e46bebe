// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/join_parts.h"

#include <string>

#include "knuckle/core/error.h"
#include "knuckle/data/readers/h5_parts.h"
#include "knuckle/data/writers/h5_assembly.h"
#include "knuckle/storage/file_io.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

/// What is wrong with any part, read to its end: damage shows where its frame is read, and ends the joining
/// at the first.
std::vector<std::string> faults_of(const std::vector<fs::path>& parts) {
  std::vector<std::string> faults;
  for (const fs::path& part : parts) {
    try {
      (void)check_h5(part);
    } catch (const Error& error) {
      faults.emplace_back(error.what());
    }
  }
  return faults;
}

}  // namespace

IndexRange join_parts(const std::vector<fs::path>& paths, const fs::path& out) {
  if (fs::exists(fs::symlink_status(out))) fail("{}: exists already; remove it first", out.string());
  check_writable(out);
  const H5Parts parts(paths);
  const H5Facts facts = parts.facts();
  try {
    assemble_h5(out, facts, [&](std::int64_t number) {
      const auto [part, frame] = parts.part_of_frame(number - facts.frames.first);
      return part->read_stored(frame);
    });
  } catch (const Error&) {
    const std::vector<std::string> faults = faults_of(parts.paths());
    if (faults.empty()) throw;
    fail_with_all(faults);
  }
  return facts.frames;
}

}  // namespace knuckle
