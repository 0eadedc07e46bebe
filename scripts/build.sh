#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds one preset (release where none is named); more arguments go to cmake.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
cmake --preset "$preset" --log-level=WARNING "${@:2}"
cmake --build --preset "$preset"
