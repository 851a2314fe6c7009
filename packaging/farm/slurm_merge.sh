#!/bin/bash
# Puts the chunks of one clip together. Submit after the bake, whether all of it went well or not (a clip that is not
# whole ends with exit code 3 and holds up no other):
#   sbatch --array=0-$((CLIPS - 1)) --dependency=afterany:BAKE_JOB slurm_merge.sh OUT [OFFSET]
# as slurm_submit.sh does.
#SBATCH --job-name=meanvalue-merge
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=%x_%A_%a.log
set -euo pipefail
out=${1:?where the plan is: the --out of plan}
index=$((SLURM_ARRAY_TASK_ID + ${2:-0}))
exec "${BLENDER:-blender}" -b --factory-startup -noaudio -t "${SLURM_CPUS_PER_TASK:-0}" --python-exit-code 1 \
  --python "${MEANVALUE_FARM:?the path of meanvalue_farm.py}" -- \
  merge --plan "$out/plan" --index "$index"
