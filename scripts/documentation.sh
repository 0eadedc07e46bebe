#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Writes the pages of the headers and documents to build/documentation/html. Needs Debian's package doxygen.
set -euo pipefail
cd "$(dirname "$0")/.."
command -v doxygen >/dev/null || { echo "documentation.sh: doxygen is missing (Debian: apt-get install doxygen)" >&2; exit 1; }
mkdir -p build/documentation
doxygen docs/Doxyfile
echo "build/documentation/html/index.html"
