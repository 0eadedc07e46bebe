#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# One task of an array of jobs that render a data set in PARTS parts, numbered from 0:
#
#   sbatch --array=0-7 scripts/slurm/render_array.sh MANIFEST 8 FOLDER
#   knuckle join FOLDER/part-*.h5 --out SET.h5
#
# The same command again makes what is missing or broken: parts that are whole are read, checked and left as they are, and those
# that were killed go on where they were. Some parts alone: --array=2,5 beside the same PARTS. KNUCKLE names the program, unless
# it is in the path.
#SBATCH --job-name=knuckle-render
#SBATCH --requeue
set -euo pipefail
[ $# -eq 3 ] || { echo "usage: sbatch --array=0-(PARTS-1) render_array.sh MANIFEST PARTS FOLDER" >&2; exit 2; }
[ -n "${SLURM_ARRAY_TASK_ID:-}" ] || { echo "render_array.sh: this is no task of an array; say sbatch --array=0-$(($2 - 1))" >&2; exit 2; }
mkdir -p "$3"
exec "${KNUCKLE:-knuckle}" render --threads "${SLURM_CPUS_PER_TASK:-1}" --manifest "$1" --shard "$SLURM_ARRAY_TASK_ID/$2" \
  --out "$3/part-$(printf %05d "$SLURM_ARRAY_TASK_ID").h5"
