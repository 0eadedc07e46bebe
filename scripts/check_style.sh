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

# A name that a source asks for by `using` and does not use. clang-tidy sees these only in a file that it is given itself.
unused=0
for file in "${sources[@]}"; do
  for name in $(sed -nE 's/^ *using (::)?([A-Za-z_0-9]+::)+([A-Za-z_0-9]+);$/\3/p' "$file"); do
    if [ "$(grep -cw -- "$name" "$file")" = 1 ]; then echo "$file: 'using ...::$name' is not used"; unused=1; fi
  done
  if [[ $file == *.cpp ]] && grep -nE '#include "[^"]*\.cpp"' "$file"; then echo "$file: includes a source"; unused=1; fi
done
[ "$unused" = 0 ]

# What two headers define by one name: the linker takes one for the other, without a word.
defined_in() { sed -nE 's/^(struct|class|enum class|inline constexpr [^=]*[ >]) *(k?[A-Z][A-Za-z0-9]*)( .*)?[={].*/\2/p' "$1" | sort -u; }
twice=$(git ls-files 'src/*.h' | grep -v testing | while read -r file; do defined_in "$file"; done | sort | uniq -d)
[ -z "$twice" ] || { echo "defined in two headers: $twice"; exit 1; }

# clang-tidy takes most of its time for the headers that a source includes, so it looks at groups of sources: a fraction of
# the time, and the same findings in each. What it no longer notices is an include that a source borrows from a
# neighbour in its group; building with KNUCKLE_UNITY=OFF does. Two of its checks look at the file alone that it is given: those
# above take their place.
grouped=build/style
single=build/style_single
cmake --preset release -B "$grouped" -DKNUCKLE_UNITY=ON -DKNUCKLE_UNITY_SIZE=10 --log-level=WARNING > /dev/null
cmake --preset release -B "$single" -DKNUCKLE_UNITY=OFF --log-level=WARNING > /dev/null

# Tests are left to the compiler's warnings: GoogleTest's macros take clang-tidy many times longer than our code.
# clang-tidy 14, Debian's, cannot read LibTorch's headers as C++20: the module training and what includes it are left out.
# Neither are sources checked that this machine does not build, for lack of an optional library.
reads_torch() { grep -qE '#include ("knuckle/training/|"knuckle/workers/(meeting_place|watch)|<torch/)' "$1"; }
is_built() { grep -qF "\"file\": \"$PWD/$1\"" "$single/compile_commands.json"; }
declare -A wanted=()
while read -r file; do
  if is_built "$file" && ! reads_torch "$file"; then wanted[$file]=1; fi
done < <(git ls-files 'src/*.cpp' 'bench/*.cpp' | grep -v -e '_test.cpp$' -e '/testing.cpp$' -e '^src/knuckle/training/')

# Groups of which all are wanted; what is left is looked at file by file.
groups=()
while read -r group; do
  mapfile -t members < <(sed -n "s|^#include \"$PWD/\(.*\)\"$|\1|p" "$group")
  all=1
  for file in "${members[@]}"; do [ -n "${wanted[$file]:-}" ] || all=0; done
  if [ "$all" = 1 ]; then
    groups+=("$group")
    for file in "${members[@]}"; do unset "wanted[$file]"; done
  fi
done < <(find "$PWD/$grouped" -name 'unity_*.cxx' | sort)

tidy() { xargs -r -P "$(nproc)" -n "$1" clang-tidy --quiet "${@:2}" 2> >(grep -v 'warnings\? generated' >&2); }
printf '%s\n' "${groups[@]}" | tidy 1 -p "$grouped" --checks=-bugprone-suspicious-include
printf '%s\n' "${!wanted[@]}" | sort | tidy 4 -p "$single"
