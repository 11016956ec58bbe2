#!/bin/sh
# One task of a campaign: its share of the runs of `sextant campaign run`, into two files of its own.
#
# In: the task's index, from 0, as Slurm (array) or Kubernetes (indexed Job) gives it; SCENARIO, a file or a name; SEED; RUNS, flights of
# each task; OUT, a folder that all tasks share; VARY, a file, if anything is drawn. `sextant` is on the PATH.
# Out: OUT/flights-INDEX.jsonl and .parquet with the runs INDEX * RUNS to INDEX * RUNS + RUNS - 1. A task that was stopped and is
# started again goes on behind what its file holds.
set -eu
index=${SLURM_ARRAY_TASK_ID:-${JOB_COMPLETION_INDEX:?there is no index: start this as a task of an array}}
file=$(printf '%s/flights-%05d' "${OUT:?a folder}" "$index")
mkdir -p "$OUT"
# Status 1 is a missed limit, which is a result and no failed task.
sextant campaign run "${SCENARIO:?a file or a name}" ${VARY:+--vary "$VARY"} --seed "${SEED:?a number}" \
    --first $((index * ${RUNS:?a number})) --runs "$RUNS" --out "$file.jsonl" --table "$file.parquet" || [ $? -eq 1 ]
