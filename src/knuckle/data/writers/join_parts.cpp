// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/join_parts.h"

#include "knuckle/core/error.h"
#include "knuckle/data/readers/h5_parts.h"
#include "knuckle/data/writers/h5_assembly.h"
#include "knuckle/storage/file_io.h"

namespace fs = std::filesystem;

namespace knuckle {

IndexRange join_parts(const std::vector<fs::path>& paths, const fs::path& out) {
  if (fs::exists(fs::symlink_status(out))) fail("{}: exists already; remove it first", out.string());
  check_writable(out);
  const H5Parts parts(paths);
  const H5Facts facts = parts.facts();
  assemble_h5(out, facts, [&](std::int64_t number) {
    const auto [part, frame] = parts.part_of_frame(number - facts.frames.first);
    return part->read_stored(frame);
  });
  return facts.frames;
}

}  // namespace knuckle
