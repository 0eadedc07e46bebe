#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds one preset (release where none is named).
#
#   scripts/build.sh [PRESET] [OPTION...] [-- TARGET...]     options go to cmake; all is built where no target is named
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
# Paths below this folder count relatively, so that ccache knows what another checkout has compiled.
export CCACHE_BASEDIR=$PWD
shift || true
options=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
  options+=("$1")
  shift
done
cmake --preset "$preset" --log-level=WARNING "${options[@]}"
cmake --build --preset "$preset" "${@/#--/--target}"
