#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Renders a data set in PARTS parts, JOBS at a time, by GNU parallel on this machine or, with its --sshlogin, on many:
#
#   scripts/render_parts.sh MANIFEST PARTS FOLDER [JOBS [OPTIONS OF PARALLEL...]]
#   knuckle join FOLDER/part-*.h5 --out SET.h5
#
# The same command again makes what is missing. KNUCKLE names the program, unless it is in the path.
set -euo pipefail
[ $# -ge 3 ] || { echo "usage: scripts/render_parts.sh MANIFEST PARTS FOLDER [JOBS [OPTIONS OF PARALLEL...]]" >&2; exit 2; }
manifest=$1 parts=$2 folder=$3 jobs=${4:-1}
mkdir -p "$folder"
seq -f %05.0f 0 $((parts - 1)) | parallel --jobs "$jobs" --halt never "${@:5}" \
  "${KNUCKLE:-knuckle}" render --manifest "$manifest" --shard '{= $_ += 0 =}'/"$parts" --out "$folder/part-{}.h5"
