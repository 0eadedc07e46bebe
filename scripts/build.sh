#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds one preset (release where none is named): all of it, or the targets that are named behind it.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
targets=("${@:2}")
cmake --preset "$preset" --log-level=WARNING
cmake --build --preset "$preset" ${targets[@]:+--target "${targets[@]}"}
