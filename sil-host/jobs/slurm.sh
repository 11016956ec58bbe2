#!/bin/sh
#SBATCH --job-name=sextant
#SBATCH --array=0-49
#SBATCH --cpus-per-task=4
#SBATCH --mem=4G
#SBATCH --time=04:00:00
#SBATCH --requeue
# 50 tasks of 20 flights, four at a time in each. Submit it from this folder: `OUT=/shared/flights sbatch slurm.sh`.
set -eu
export SCENARIO="${SCENARIO:-leo-oblique}" SEED="${SEED:-1}" RUNS="${RUNS:-20}"
# Slurm runs a copy of this file, from the folder in which it was submitted.
exec sh ./task.sh
