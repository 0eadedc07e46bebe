#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Hands as each sensor sees them: a picture (depth, mask, infrared) and the statistics of 60 frames per preset;
# and the same of recordings, where their folder is given.
#   scripts/compare_sensors.sh OUT [FOLDER_WITH_RECORDINGS]
# OUT/sensor_NAME.png, OUT/real_NAME.png and OUT/statistics.md are written; the table is also printed.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:?"usage: scripts/compare_sensors.sh OUT [FOLDER_WITH_RECORDINGS]"}
recordings=${2:-}
knuckle=build/release/bin/knuckle
mkdir -p "$out"

# measure SOURCE NAME PICTURE: one row of the table
measure() {
  "$knuckle" inspect --source "$1" --frame 0 --panels "$out/$3.png" --statistics |
    awk -v name="$2" '
      /^hands/        { frames = $4 }
      /depth  /       { depth = $2 }
      /depth spread/  { spread = $3 }
      /valid in box/  { valid = $4 }
      /surface noise/ { surface = $3 }
      /edge noise/    { edge = $3 }
      /flying pixels/ { flying = $3 }
      END { printf "| %s | %d | %d mm | %s %% | %s mm | %s px | %s mm | %s |\n", name, frames, depth, valid,
            surface, edge, spread, flying == "nan" ? "-" : flying " %" }'
}

# synthetic PRESET NEAREST FARTHEST
synthetic() {
  sed -e "s/^preset = .*/preset = \"$1\"/" -e "s/^nearest_mm = .*/nearest_mm = $2.0/" \
    -e "s/^farthest_mm = .*/farthest_mm = $3.0/" manifests/sensor_views.toml >"$out/$1.toml"
  measure "synthetic:$out/$1.toml" "synthetic, \`$1\`" "sensor_$1"
}

{
  echo "| frames | hands | depth | valid in box | surface noise | edge noise | depth spread | flying pixels |"
  echo "|---|---|---|---|---|---|---|---|"
  synthetic paper 400 500
  synthetic creative 400 500
  synthetic pico 400 500
  synthetic kinect_v1 880 1000
  synthetic kinect_v2 600 700
  synthetic sr300 500 600
  synthetic d400 600 800
  if [[ -n $recordings ]]; then
    for set in rgbd_sequence sr305_open_hand sr305_other kinect_scenes kinect2_hand table_cam2 table_cam4 table_cam6; do
      measure "folder:$recordings/$set" "recorded, $set" "real_$set"
    done
  fi
} | tee "$out/statistics.md"
