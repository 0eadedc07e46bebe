#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A forest trained by the tasks of a job, on as many machines as Slurm gives it; KIND is pose-forest or segmentation-forest:
#
#   sbatch --ntasks=8 --cpus-per-task=4 scripts/slurm/train_forest.sh KIND CONFIG MODEL [more arguments of train KIND]
#
# The same command again goes on where the job was ended, also with another --ntasks. Configuration, model and data lie where all
# machines see them. KNUCKLE names the program, unless it is in the path.
#SBATCH --job-name=knuckle-train
#SBATCH --requeue
set -euo pipefail
[ $# -ge 3 ] || { echo "usage: sbatch --ntasks=N train_forest.sh pose-forest|segmentation-forest CONFIG MODEL [ARGUMENTS]" >&2; exit 2; }
kind=$1 config=$2 model=$3
shift 3
[ ! -e "$model.checkpoint" ] && [ ! -e "$model.checkpoint.tree" ] || set -- --resume "$@"
exec srun --kill-on-bad-exit=1 "${KNUCKLE:-knuckle}" train "$kind" --config "$config" --out "$model" --workers "$SLURM_NTASKS" \
  --threads "${SLURM_CPUS_PER_TASK:-1}" "$@"
