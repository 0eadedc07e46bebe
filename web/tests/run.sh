#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# One test of the page, for CTest: `run.sh bundle`, `run.sh types`, or `run.sh FILE.test.mjs`. Exit status 77: something that it needs is missing.
set -euo pipefail
cd "$(dirname "$0")/.."

skip() {
  echo "skipped: $*"
  exit 77
}

needs_packages() {
  command -v node >/dev/null || skip "node is missing (scripts/setup.sh installs it)"
  [ -d node_modules/esbuild ] || skip "web/node_modules is missing (scripts/fetch_web_packages.sh)"
}

needs_browser() {
  [ -d node_modules/playwright-core ] || skip "playwright-core is missing (scripts/fetch_web_packages.sh)"
  CHROMIUM=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || true)}
  [ -n "$CHROMIUM" ] || skip "chromium is missing (scripts/setup.sh installs it)"
  export CHROMIUM
}

needs_packages
case "${1:-}" in
  bundle)
    built=$(mktemp -d)
    trap 'rm -rf "$built"' EXIT
    node build.mjs "$built"
    diff -rq "$built" dist || { echo "web/dist is not what web/src gives: run scripts/build_web.sh and commit" >&2; exit 1; }
    ;;
  types) node node_modules/typescript/bin/tsc --noEmit ;;
  *.test.mjs)
    needs_browser
    node --test "tests/$1"
    ;;
  *) echo "usage: run.sh bundle|types|FILE.test.mjs" >&2; exit 2 ;;
esac
