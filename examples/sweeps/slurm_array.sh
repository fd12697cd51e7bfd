#!/bin/bash
# A grasp on every mesh of a list as a Slurm job array, one task per mesh:
#
#     find meshes -name '*.obj' >meshes.txt
#     sbatch --array=0-$(($(wc -l <meshes.txt) - 1))%100 examples/sweeps/slurm_array.sh meshes.txt results --contacts 4
#
# %100 limits how many run at the same time. Submit the same again after an interruption: meshes that are done are
# skipped. An array has at most MaxArraySize tasks (1,001 by default): for more, `split --lines=1000` the list and submit
# one array for each piece.
#
# What to change: the resources below; the path of graspd. Like the meshes and the results, it must be on a file system
# that all nodes share.
#SBATCH --job-name=graspd
#SBATCH --cpus-per-task=2
#SBATCH --mem=2G
#SBATCH --time=00:30:00
#SBATCH --output=graspd-%A_%a.log
# Tasks that lost their node are queued again.
#SBATCH --requeue
set -eu
[ $# -ge 2 ] || { echo "usage: sbatch --array=0-LAST slurm_array.sh LIST OUT [FLAG]..." >&2; exit 2; }
list=$1
out=$2
shift 2
# Slurm runs a copy of this file from its own folder, so plan_one.sh is found relative to the folder of submission.
sweeps=${SWEEPS:-${SLURM_SUBMIT_DIR:?submit this with sbatch}/examples/sweeps}
export THREADS="${SLURM_CPUS_PER_TASK:-1}"
exec sh "$sweeps/plan_one.sh" "$list" "$SLURM_ARRAY_TASK_ID" "$out" "$@"
