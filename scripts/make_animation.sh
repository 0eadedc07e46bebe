#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes docs/images/animation.webp, the README's moving picture: the page of `knuckle live` while it plays a synthetic sequence of a
# person that training never saw. Needs a built program, and what scripts/setup.sh installs for the page's tests.
#   scripts/make_animation.sh [OUT]
# $KNUCKLE is another program than build/release/bin/knuckle.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-docs/images/animation.webp}
knuckle=${KNUCKLE:-build/release/bin/knuckle}
frames=96
work=$(mktemp -d)
server=
trap '[ -z "$server" ] || kill -TERM "$server" 2>/dev/null || true; rm -rf "$work"' EXIT

sed -e 's/^seed = .*/seed = 402/' -e "s/^frames = .*/frames = $frames/" -e 's/^frames_a_pose = .*/frames_a_pose = 12/' \
  -e 's/^gesture_share = .*/gesture_share = 1.0/' -e 's/^pair_share = .*/pair_share = 0.0/' \
  -e 's/^gestures = .*/gestures = ["spread", "fist", "point", "peace", "three", "ok", "thumb_up", "love_you", "claw"]/' \
  -e 's/^nearest_mm = .*/nearest_mm = 380.0/' -e 's/^farthest_mm = .*/farthest_mm = 430.0/' \
  -e 's/^palm_deg = .*/palm_deg = 35.0/' -e 's/^upright_deg = .*/upright_deg = 40.0/' \
  manifests/test_creative.toml >"$work/sequence.toml"
"$knuckle" render --manifest "$work/sequence.toml" --format folder --out "$work/set"

# Slowly, so that each frame is caught; the picture plays them faster.
"$knuckle" live --source "folder:$work/set?rate=2&loop=1" --view 0 2>"$work/said" &
server=$!
until grep -q '^view: ' "$work/said"; do
  kill -0 "$server" || { cat "$work/said" >&2; exit 1; }
  sleep 0.1
done
node web/tests/capture.mjs "$(sed -n 's/^view: //p' "$work/said")" "$frames" "$out"
echo "$out"
