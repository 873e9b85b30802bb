#!/bin/sh
# A sweep as a job array of Slurm: 16 tasks, each of which runs one part.
# usage: sbatch docs/ci/slurm_array.sh SWEEP OUT
#   SWEEP  a sweep file or a scene
#   OUT    folder on a file system that all nodes share; part I lies in OUT/part-I
# Then: wherein merge OUT/part-* --out WHOLE
# A task that is requeued goes on where it stopped. The program is $WHEREIN, `wherein` unless set.
#SBATCH --job-name=sweep
#SBATCH --array=1-16
#SBATCH --cpus-per-task=1
#SBATCH --requeue
#SBATCH --open-mode=append
set -eu
# Not the number of tasks that Slurm tells: a part that is submitted again by itself, --array=3, is still the third of 16.
parts=16
code=0
"${WHEREIN:-wherein}" sweep "$1" --shard "$SLURM_ARRAY_TASK_ID/$parts" --jobs "${SLURM_CPUS_PER_TASK:-1}" \
	--out "$2/part-$SLURM_ARRAY_TASK_ID" || code=$?
# Code 1, a missed expectation, is told by the merged report.
[ "$code" -eq 1 ] && code=0
exit "$code"
