#!/bin/bash
# One fit over the machines of a Slurm job: sbatch ranks.sh CONFIG RUN; the same line again continues RUN.
#SBATCH --job-name=pathfit
#SBATCH --nodes=4
#SBATCH --ntasks-per-node=1
#SBATCH --cpus-per-task=16
#SBATCH --mem=16G
#SBATCH --time=04:00:00
#SBATCH --output=%x_%j.log
# Two minutes before the end every rank is told: the first writes results, and all stop with status 75.
#SBATCH --signal=TERM@120
set -euo pipefail
if [ -d "$2/checkpoints" ]; then
  command=(resume "$2")
else
  command=(fit "$1" -o "$2")
fi
exec srun --mpi=pmix pathfit "${command[@]}" --threads "$SLURM_CPUS_PER_TASK"
