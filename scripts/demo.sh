#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a fresh clone to a picture: set up, build the program alone, estimate the hand in a short recording, and say where
# the report is.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh program
scripts/build.sh program
build/release/bin/knuckle demo --out "${1:-build/demo}"
