#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Bundles the page of `knuckle live --view` from web/src into web/dist, which is committed. Needs Node.js and npm.
#
#   scripts/build_web.sh [FOLDER]      FOLDER: another place than web/dist
set -euo pipefail
cd "$(dirname "$0")/.."
if [ $# -gt 1 ] || [[ "${1:-}" == -* ]]; then
  echo "usage: build_web.sh [FOLDER]" >&2
  exit 2
fi
out=$(realpath -m "${1:-web/dist}")
scripts/fetch_web_packages.sh
cd web
node build.mjs "$out"
echo "$out"
