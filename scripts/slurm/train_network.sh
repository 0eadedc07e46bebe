#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A network trained by the tasks of a job, on as many machines as Slurm gives it:
#
#   sbatch --ntasks=8 --cpus-per-task=4 scripts/slurm/train_network.sh CONFIG MODEL [more arguments of train network]
#
# The same command again goes on where the job was ended, also with another --ntasks. Configuration, model and data lie where all
# machines see them. KNUCKLE names the program, unless it is in the path.
#SBATCH --job-name=knuckle-train
#SBATCH --requeue
set -euo pipefail
[ $# -ge 2 ] || { echo "usage: sbatch --ntasks=N train_network.sh CONFIG MODEL [ARGUMENTS]" >&2; exit 2; }
config=$1 model=$2
shift 2
[ ! -e "$model.checkpoint" ] || set -- --resume "$@"
cores=${SLURM_CPUS_PER_TASK:-1}
# srun is told of the cores again: since Slurm 22.05 it does not take them over from sbatch.
exec srun --kill-on-bad-exit=1 --cpus-per-task="$cores" "${KNUCKLE:-knuckle}" train network --config "$config" --out "$model" \
  --workers "$SLURM_NTASKS" --threads "$cores" "$@"
