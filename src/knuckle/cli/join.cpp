// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/text.h"
#include "knuckle/data/writers/join_parts.h"

namespace knuckle::cli {
namespace {

struct JoinArguments {
  std::vector<std::filesystem::path> parts;
  std::filesystem::path out;
};

void run_join(const JoinArguments& arguments) {
  const IndexRange frames = join_parts(arguments.parts, arguments.out);
  fmt::print("{} frames of {} parts: {}\n", frames.count, arguments.parts.size(),
             printable(arguments.out.string()));
}

}  // namespace

void add_join(CLI::App& program) {
  CLI::App& verb = add_verb(program, "join", "Join the parts of a set that `render --shard` made",
                            "knuckle render --manifest manifests/demo.toml --shard 0/2 --out part0.h5\n"
                            "  knuckle render --manifest manifests/demo.toml --shard 1/2 --out part1.h5\n"
                            "  knuckle join part0.h5 part1.h5 --out joined.h5");
  auto arguments = std::make_shared<JoinArguments>();
  verb.add_option("parts", arguments->parts, "Files with parts of one set, in any order")
      ->type_name("PART...")
      ->required();
  verb.add_option("--out", arguments->out,
                  "File to write; it has the bytes of a set that was made in one piece")
      ->type_name("FILE")
      ->required();
  verb.callback([arguments] { run_join(*arguments); });
}

}  // namespace knuckle::cli
