// SPDX-License-Identifier: Apache-2.0
// The import of MakeHuman's package.
#include "fuzz_target.h"

#include <string>

#include "knuckle/core/error.h"
#include "knuckle/synth/makehuman/makehuman_import.h"
#include "knuckle/synth/makehuman/makehuman_package.h"
#include "knuckle/synth/people/body_shape.h"

namespace knuckle::fuzz {
namespace {

/// All targets that people are made of, by which no vertex moves.
void write_targets(const FuzzFolder& folder, std::size_t vertices) {
  std::string list;
  const std::vector<std::string> names = person_target_names();
  for (const std::string& name : names) {
    list += fmt::format("{}\"data/targets/{}.target\": {{}}", list.empty() ? "" : ",", name);
  }
  folder.write("src/json/targets/target-list.json", fmt::format("{{\"targets\": {{{}}}}}", list));
  folder.write("public/data/targets/targets.bin",
               std::string(names.size() * vertices * 3 * sizeof(std::int16_t), '\0'));
}

}  // namespace

/// '0': the mesh; '1': the list of targets.
void run_makehuman(Bytes bytes) {
  static const FuzzFolder folder;
  const auto [which, content] = selected(bytes, 2);
  if (which == 1) {
    folder.write("src/json/targets/target-list.json", as_text(content));
    folder.write("public/data/targets/targets.bin", "123456");
    const MakeHumanTargets targets(folder.path(), 1);
    for (const std::string& name : targets.names()) (void)targets.offsets_mm(name);
    return;
  }
  folder.write("public/data/models/human_full_size.json", as_text(content));
  write_targets(folder, read_makehuman_mesh(folder.path()).vertices_mm.size());
  (void)import_makehuman(folder.path());
}

}  // namespace knuckle::fuzz
