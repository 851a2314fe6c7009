#!/bin/bash
# One task of the plan. slurm_submit.sh submits all that is left; by hand:
#   sbatch --array=0-$((TASKS - 1)) slurm_bake.sh OUT [OFFSET]
# BLENDER and MEANVALUE_FARM (the path of meanvalue_farm.py) can be set in the environment. Arrays of more tasks than
# MaxArraySize (`scontrol show config`) are submitted in parts, each with the OFFSET of its first.
#SBATCH --job-name=meanvalue-bake
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=%x_%A_%a.log
set -euo pipefail
out=${1:?where the plan is: the --out of plan}
index=$((SLURM_ARRAY_TASK_ID + ${2:-0}))
exec "${BLENDER:-blender}" -b --factory-startup -noaudio -t "${SLURM_CPUS_PER_TASK:-0}" --python-exit-code 1 \
  --python "${MEANVALUE_FARM:?the path of meanvalue_farm.py}" -- bake --plan "$out/plan" --index "$index"
