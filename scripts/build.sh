#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds one preset (release where none is named); more arguments go to cmake.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
# Paths below this folder count relatively, so that ccache knows what another checkout has compiled.
export CCACHE_BASEDIR=$PWD
cmake --preset "$preset" --log-level=WARNING "${@:2}"
cmake --build --preset "$preset"
