#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fetches ONNX Runtime, which tests compare exported networks with, as tests/onnx/package-lock.json names it (240 MB).
# Does nothing where it is already there.
set -euo pipefail
cd "$(dirname "$0")/../tests/onnx"
command -v npm >/dev/null || { echo "fetch_onnx_runtime.sh: npm is missing; install it to compare networks with ONNX Runtime" >&2; exit 1; }
cmp -s package-lock.json node_modules/.knuckle-lock.json && exit 0

# Its own script would fetch CUDA's part, which is not used.
npm ci --ignore-scripts --no-audit --no-fund --loglevel=error
cp package-lock.json node_modules/.knuckle-lock.json
