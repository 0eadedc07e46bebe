#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fetches the npm packages that the page in web/ is built and tested with, as web/package-lock.json names them.
# Does nothing where they are already there.
set -euo pipefail
cd "$(dirname "$0")/../web"
command -v npm >/dev/null || { echo "fetch_web_packages.sh: npm is missing; install it to build and test the page" >&2; exit 1; }
cmp -s package-lock.json node_modules/.knuckle-lock.json && exit 0

# No package's own scripts run: esbuild and the others work without them.
npm ci --ignore-scripts --no-audit --no-fund --loglevel=error
cp package-lock.json node_modules/.knuckle-lock.json
