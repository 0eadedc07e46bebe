#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# One task of an array of jobs that render a data set in parts:
#
#   sbatch --array=0-7 scripts/slurm/render_array.sh MANIFEST FOLDER
#   knuckle join FOLDER/part-*.h5 --out SET.h5
#
# The same command again makes what is missing: parts that are whole are left as they are, and those that were killed go on
# where they were. KNUCKLE names the program, unless it is in the path.
#SBATCH --job-name=knuckle-render
#SBATCH --requeue
set -euo pipefail
[ $# -eq 2 ] || { echo "usage: sbatch --array=0-N render_array.sh MANIFEST FOLDER" >&2; exit 2; }
mkdir -p "$2"
exec "${KNUCKLE:-knuckle}" render --threads "${SLURM_CPUS_PER_TASK:-1}" --manifest "$1" --shard auto --out "$2/part-$(printf %05d "$SLURM_ARRAY_TASK_ID").h5"
