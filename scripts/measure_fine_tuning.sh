#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measures the table of docs/own_data.md: models/dense.pt before and after it was tuned on 40 frames of a recording, alone and mixed
# half and half with rendered ones, tested on two other recordings and on rendered frames.
#
#   scripts/measure_fine_tuning.sh BUILD RECORDINGS OUT     RECORDINGS holds table_cam2, table_cam4 and table_cam6; 40 minutes
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# = 3 ] || { echo "usage: scripts/measure_fine_tuning.sh BUILD RECORDINGS OUT" >&2; exit 2; }
knuckle=$(realpath "$1")/bin/knuckle
recordings=$(realpath "$2")
mkdir -p "$3"
out=$(realpath "$3")

# tuning NAME EPOCHS [RENDERED]: as pipelines/train_own.toml, without an early end
tuning() {
  {
    echo "initial = \"$PWD/models/dense.pt\""
    echo "validation = \"folder:$recordings/table_cam4?first=40\""
    echo 'start = "truth"'
    printf '[[source]]\nsource = "folder:%s/table_cam4?count=40"\n' "$recordings"
    [ $# -lt 3 ] || printf '[[source]]\nsource = "synthetic:%s/manifests/train_network.toml"\nmost = %s\n' "$PWD" "$3"
    sed -n '/^\[segmentation\]/,$p' pipelines/train_own.toml | sed -e "s/^epochs = .*/epochs = $2/" -e '/^patience/d'
  } >"$out/$1.toml"
}

# score NAME MODEL: a line of the table
score() {
  sed "s|\"../models/dense.pt\"|\"$2\"|" pipelines/free_hand.toml >"$out/$1_pipeline.toml"
  for source in "folder:$recordings/table_cam2" "folder:$recordings/table_cam6" 'synthetic:manifests/validate_network.toml?count=100'; do
    "$knuckle" estimate --source "$source" --init truth --pipeline "$out/$1_pipeline.toml" --out "$out/$1.txt" >"$out/$1_estimate.log" 2>&1
    echo "$1 on ${source##*/}:"
    "$knuckle" evaluate --truth "$source" --predictions "$1=$out/$1.txt" --out "$out/$1_report"
  done
}

score dense "$PWD/models/dense.pt"
score dense_scenes "$PWD/models/dense_scenes.pt"
tuning alone 500
tuning mixed 19.6 2000
for name in alone mixed; do
  "$knuckle" train network --config "$out/$name.toml" --out "$out/$name.pt" >"$out/$name.log" 2>&1
  score "$name" "$out/$name.pt"
done
