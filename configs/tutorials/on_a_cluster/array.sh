#!/bin/bash
# One run of a sweep in each task of a Slurm job array: sbatch --array=1-N array.sh LIST
#SBATCH --job-name=pathfit
#SBATCH --cpus-per-task=4
#SBATCH --mem=4G
#SBATCH --time=01:00:00
#SBATCH --output=%x_%A_%a.log
# Two minutes before the end: the run writes a checkpoint and stops; the same sbatch again continues it.
#SBATCH --signal=B:TERM@120
set -euo pipefail
command=$(sed -n "${SLURM_ARRAY_TASK_ID}p" "$1")
eval "exec $command --threads $SLURM_CPUS_PER_TASK"
