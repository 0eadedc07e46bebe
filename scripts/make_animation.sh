#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes docs/images/animation.webp, the README's moving picture: a synthetic sequence of a person that training never saw, with
# the joints that the default pipeline finds in it. Needs ImageMagick (convert) and a built program.
#   scripts/make_animation.sh [OUT]
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-docs/images/animation.webp}
knuckle=build/release/bin/knuckle
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

sed -e 's/^seed = .*/seed = 402/' -e 's/^frames = .*/frames = 96/' -e 's/^frames_a_pose = .*/frames_a_pose = 12/' \
  -e 's/^gesture_share = .*/gesture_share = 1.0/' -e 's/^pair_share = .*/pair_share = 0.0/' \
  -e 's/^gestures = .*/gestures = ["spread", "fist", "point", "peace", "three", "ok", "thumb_up", "love_you", "claw"]/' \
  -e 's/^nearest_mm = .*/nearest_mm = 380.0/' -e 's/^farthest_mm = .*/farthest_mm = 430.0/' \
  -e 's/^palm_deg = .*/palm_deg = 35.0/' -e 's/^upright_deg = .*/upright_deg = 40.0/' \
  manifests/test_creative.toml >"$work/sequence.toml"
"$knuckle" render --manifest "$work/sequence.toml" --format folder --out "$work/set"
"$knuckle" estimate --source "folder:$work/set" --out "$work/poses.txt"

# `inspect` draws the joints of joints.txt: those that were found take the place of the true ones.
convention=$(sed -n 's/^# convention: //p' "$work/poses.txt")
sed -i "s/^convention = .*/convention = \"$convention\"/" "$work/set/dataset.toml"
grep -v '^#' "$work/poses.txt" >"$work/set/joints.txt"
for frame in $(seq 0 95); do
  "$knuckle" inspect --source "folder:$work/set" --frame "$frame" --png "$work/$(printf %03d "$frame").png" >/dev/null
done
convert -delay 8 -loop 0 "$work"/[0-9]*.png -crop 416x384+176+88 +repage -quality 70 -define webp:method=4 "$out"
echo "$out"
