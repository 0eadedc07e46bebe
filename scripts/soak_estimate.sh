#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The long run of `knuckle estimate`: renders nothing to the disk, measures peak memory, kills the run at random moments, goes on
# with --resume, and compares the bytes with those of an undisturbed run.
#
#   scripts/soak_estimate.sh [FRAMES] [KILLS] [SEED]     400000 frames, 20 kills, seed 1
#
# KNUCKLE names the program (build/release/bin/knuckle), PIPELINE the pipeline (pipelines/default.toml).
set -euo pipefail
cd "$(dirname "$0")/.."

frames=${1:-400000}
kills=${2:-20}
RANDOM=${3:-1}
knuckle=${KNUCKLE:-build/release/bin/knuckle}
pipeline=${PIPELINE:-pipelines/default.toml}
[ -x /usr/bin/time ] || { echo "soak_estimate: /usr/bin/time is missing; install the package 'time'"; exit 1; }
[ -x "$knuckle" ] || { echo "soak_estimate: $knuckle is missing; scripts/build.sh program builds it"; exit 1; }

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat > "$folder/manifest.toml" <<TOML
frames = $frames
[body]
people = 10
[camera]
width = 160
height = 120
fx = 112
fy = 112
cx = 79.5
cy = 59.5
TOML

# estimate NAME SOURCE-SETTINGS [OPTIONS]: poses, records and summary as NAME.txt, NAME.jsonl, NAME.json.
estimate() {
  local name=$1 settings=$2
  shift 2
  exec "$knuckle" estimate --source "synthetic:$folder/manifest.toml$settings" --pipeline "$pipeline" \
    --out "$folder/$name.txt" --records "$folder/$name.jsonl" --json "$folder/$name.json" "$@"
}
export -f estimate
export folder knuckle pipeline

# measured NAME SOURCE-SETTINGS: an undisturbed run with its peak memory and time.
measured() {
  /usr/bin/time -f '%M %e' -o "$folder/$1.time" bash -c 'estimate "$@"' estimate "$1" "$2" >/dev/null 2>"$folder/$1.log" ||
    { cat "$folder/$1.log"; exit 1; }
  read -r kilobytes seconds < "$folder/$1.time"
  echo "$3 frames: peak memory $((kilobytes / 1024)) MB, $seconds s"
}

measured first "?count=1000" 1000
measured whole "" "$frames"

# Each run is killed at a random moment in the part of the whole time that falls to it.
part_ms=$(awk -v s="$seconds" -v k="$kills" 'BEGIN { printf "%d", 1000 * s / (k + 1) }')
killed=0
while [ "$killed" -lt "$kills" ]; do
  estimate run "" --resume >"$folder/run.log" 2>&1 &
  process=$!
  sleep "$(awk -v p="$part_ms" -v r="$RANDOM" 'BEGIN { printf "%.3f", 2 * p * r / 32768 / 1000 }')"
  kill -KILL "$process" 2>/dev/null || true
  status=0
  wait "$process" 2>/dev/null || status=$?
  [ "$status" -eq 0 ] && break
  [ "$status" -eq 137 ] || { cat "$folder/run.log"; exit 1; }
  killed=$((killed + 1))
done
if [ ! -e "$folder/run.txt" ]; then (estimate run "" --resume >"$folder/run.log" 2>&1) || { cat "$folder/run.log"; exit 1; }; fi
for file in txt jsonl; do cmp "$folder/whole.$file" "$folder/run.$file"; done
[ -z "$(find "$folder" -name '*.partial' -o -name '*.resume')" ] || { echo "soak_estimate: something was left over"; exit 1; }
echo "killed $killed times and resumed: the same bytes"
