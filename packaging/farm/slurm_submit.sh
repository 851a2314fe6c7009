#!/bin/bash
# Submits what is left of a plan, in arrays that Slurm takes (MaxArraySize), and after them the merges:
#   slurm_submit.sh OUT [options of sbatch, as --cpus-per-task=8]
# After a failure the same again. BLENDER is the program, if it is not `blender`.
set -euo pipefail
shopt -s inherit_errexit
out=${1:?where the plan is: the --out of plan}
shift
here=$(dirname "$(readlink -f "$0")")
export MEANVALUE_FARM=${MEANVALUE_FARM:-$here/meanvalue_farm.py}
size=$(scontrol show config | sed -n 's/^MaxArraySize *= *\([0-9][0-9]*\).*/\1/p')
[ "${size:-0}" -gt 0 ] || { echo "slurm_submit.sh: scontrol show config tells no MaxArraySize" >&2 && exit 1; }

# in_arrays: of lines with one index each, lines OFFSET,ARRAY with ARRAY as --array wants it.
in_arrays() {
  awk -v size="$size" '{
    offset = $1 - $1 % size
    if (offset != last || NR == 1) printf "%s%d ", NR == 1 ? "" : "\n", offset
    else printf ","
    printf "%d", $1 - offset
    last = offset
  } END { if (NR) print "" }'
}

# submit SCRIPT OPTION...: lines of in_arrays on standard input to job numbers, one a line.
submit() {
  local offset array
  while read -r offset array; do
    sbatch --parsable --array="$array" "${@:2}" "$here/$1" "$out" "$offset" </dev/null | cut -d';' -f1
  done
}

left=$("${BLENDER:-blender}" -b --factory-startup -noaudio --python-exit-code 1 --python "$MEANVALUE_FARM" -- \
  status --out "$out" --missing)
jobs=$({ grep '^[0-9]' <<<"$left" || true; } | tr ',' '\n' | awk -F- '{ for (k = $1; k <= $NF; k++) print k }' | in_arrays |
  submit slurm_bake.sh "$@")
count=$(wc -l <"$out/plan/clips.tsv")
after=()
if [ -n "$jobs" ]; then after=(--dependency="afterany:$(paste -sd: <<<"$jobs")"); fi
merges=$(seq 0 $((count - 1)) | in_arrays | submit slurm_merge.sh "${after[@]}" "$@")
echo "bake: ${jobs//$'\n'/ }"
echo "merge: ${merges//$'\n'/ }"
