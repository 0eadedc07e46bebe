#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Sets up, builds and runs all tests; with --sanitize=address under the address and undefined-behaviour sanitizers, with
# --sanitize=thread under the thread sanitizer.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=release
case "${1:-}" in
  "") ;;
  --sanitize | --sanitize=address) preset=asan ;;
  --sanitize=thread) preset=tsan ;;
  *) echo "usage: scripts/test.sh [--sanitize=address|--sanitize=thread]" >&2; exit 2 ;;
esac
scripts/setup.sh
scripts/build.sh "$preset"
ctest --preset "$preset" -j "$(nproc)"
