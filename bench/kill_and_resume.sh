#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Kills a simulation at random moments, goes on with --resume each time, and compares the final state
# with that of a run that was left alone: bit for bit.
#
#   bench/kill_and_resume.sh TWANG SCENE [KILLS=20] [SEED=1]
set -euo pipefail
twang=$(realpath "$1")
scene=$(realpath "$2")
kills=${3:-20}
RANDOM=${4:-1}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

state() { grep -o '"state_sha256": "[0-9a-f]*"' "$1/summary.json"; }

begin=$(date +%s%N)
"$twang" simulate "$scene" --out "$folder/whole" --threads 1 > /dev/null 2>&1
whole_ms=$((($(date +%s%N) - begin) / 1000000))
killed=0
resumed=0
while ((killed < kills)); do
  flag=()
  [[ -e $folder/parts/checkpoint.bin ]] && flag=(--resume) && resumed=$((resumed + 1))
  "$twang" simulate "$scene" --out "$folder/parts" --threads 1 "${flag[@]}" > /dev/null 2>&1 &
  pid=$!
  # One that has come to its end by then does not count.
  sleep "$(awk -v ms="$whole_ms" -v r="$RANDOM" 'BEGIN { print 0.001 * (20 + ms * 0.15 * r / 32768) }')"
  kill -9 "$pid" 2> /dev/null && killed=$((killed + 1))
  wait "$pid" 2> /dev/null || true
done
flag=()
[[ -e $folder/parts/checkpoint.bin ]] && flag=(--resume)
"$twang" simulate "$scene" --out "$folder/parts" --threads 1 "${flag[@]}" > /dev/null 2>&1
echo "killed $killed times within runs of $whole_ms ms, resumed from a checkpoint $resumed times"
echo "whole:   $(state "$folder/whole")"
echo "resumed: $(state "$folder/parts")"
[[ $(state "$folder/whole") == $(state "$folder/parts") ]] || { echo "the states differ"; exit 1; }
for table in energy.csv motion.csv probes.csv; do
  cmp "$folder/whole/$table" "$folder/parts/$table"
done
echo "the same, bit for bit"
