#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Checks format and clang-tidy on all of our sources. Needs what scripts/setup.sh installs, but no build.
set -euo pipefail
cd "$(dirname "$0")/.."
mapfile -t sources < <(git ls-files '*.h' '*.cpp')
clang-format --dry-run -Werror "${sources[@]}"

for file in $(git ls-files '*.h' '*.cpp' '*.sh' '*.py' '*.cmake' '*CMakeLists.txt'); do
  head -n 2 "$file" | grep -q 'SPDX-License-Identifier: Apache-2.0' || { echo "$file: no SPDX line"; exit 1; }
done

# clang-tidy looks at sources one by one, whether the build groups them or not.
database=build/style
cmake --preset release -B "$database" -DKNUCKLE_UNITY=OFF --log-level=WARNING > /dev/null

# Tests are left to the compiler's warnings: GoogleTest's macros take clang-tidy many times longer than our code.
# clang-tidy 14, Debian's, cannot read LibTorch's headers as C++20: the module training and what includes it are left out.
# Neither are sources checked that this machine does not build, for lack of an optional library.
reads_torch() { grep -qE '#include ("knuckle/training/|"knuckle/workers/(meeting_place|watch)|<torch/)' "$1"; }
is_built() { grep -qF "\"file\": \"$PWD/$1\"" "$database/compile_commands.json"; }
git ls-files 'src/*.cpp' 'bench/*.cpp' | grep -v -e '_test.cpp$' -e '/testing.cpp$' -e '^src/knuckle/training/' |
  while read -r file; do if is_built "$file" && ! reads_torch "$file"; then echo "$file"; fi; done |
  xargs -P "$(nproc)" -n 4 clang-tidy --quiet -p "$database" 2> >(grep -v 'warnings\? generated' >&2)
