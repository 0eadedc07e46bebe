#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measures anew, unattended, what docs/performance.md, python.md, onnx.md, evaluation.md and own_data.md say of Knuckle beside other
# software and in Python. Hours; what is done is not done again where it is started anew.
#
#   scripts/measure_figures.sh OUT [RECORDINGS]     OUT/NAME.log is what a step printed, OUT/NAME.done that it ended well
#
# Needs what scripts/setup.sh installs; peers want libopencv-ml-dev and Blender, the fresh Debians root and debootstrap, the
# fine-tuning the folder of table_cam2, table_cam4 and table_cam6. What is missing is a step that fails, and named at the end.
# Nothing else should run before `calm.done` is there.
set -uo pipefail
cd "$(dirname "$0")/.."
[ $# = 1 ] || [ $# = 2 ] || { echo "usage: scripts/measure_figures.sh OUT [RECORDINGS]" >&2; exit 2; }
mkdir -p "$1"
out=$(realpath "$1")
recordings=${2:-}
build=build/figures
python=/usr/bin/python3
export PYTHONDONTWRITEBYTECODE=1

# step NAME COMMAND...
step() {
  local name=$1
  shift
  [ ! -e "$out/$name.done" ] || return 0
  echo "$(date +%T) $name"
  if "$@" >"$out/$name.log" 2>&1; then touch "$out/$name.done"; else echo "$(date +%T) $name: failed, see $name.log"; fi
}

# For this machine's processor, as the variants of the packages are.
level() {
  if grep -qw avx512vl /proc/cpuinfo && grep -qw avx512dq /proc/cpuinfo; then echo x86-64-v4; else echo x86-64-v3; fi
}

# build [TARGET...]: all, or those of these that this machine can build
build() {
  cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DKNUCKLE_DEVELOPMENT=ON -DKNUCKLE_ARCH="$(level)" --log-level=WARNING || return 1
  local targets=()
  for target in "$@"; do
    if ninja -C "$build" -t query "$target" >/dev/null 2>&1; then targets+=("$target"); else echo "$target: cannot be built here"; fi
  done
  ninja -C "$build" "${targets[@]}"
}

processor() { grep -m1 'model name' /proc/cpuinfo; echo "$(nproc) cores, $(level)"; uptime; git rev-parse --short HEAD; }

# A network of the paper's size; how good it is does not change its speed.
regression() {
  sed -e 's/^most = .*/most = 64/' -e 's/^epochs = .*/epochs = 1/' -e 's/^batch_size = .*/batch_size = 32/' \
    -e 's/^validate_every = .*/validate_every = 2/' -e "s|synthetic:../|synthetic:$PWD/|" \
    -e 's|validate_network.toml|&?count=32|' pipelines/train_regression.toml >"$out/regression.toml"
  "$build/bin/knuckle" train network --config "$out/regression.toml" --out "$out/regression.pt"
}

onnx() { KNUCKLE_ONNX_FRAMES=520 ctest --test-dir "$build" -R '^onnx_program/' --output-on-failure --verbose; }

joints() {
  local source='synthetic:manifests/validate_network.toml?count=300'
  "$build/bin/knuckle" estimate --source "$source" --init truth --pipeline pipelines/free_hand.toml --out "$out/joints.txt" || return 1
  for landmarks in '' nyu14 icvl16; do
    "$build/bin/knuckle" evaluate --truth "$source" --predictions "dense=$out/joints.txt" ${landmarks:+--landmarks "$landmarks"} \
      --out "$out/joints_$landmarks" || return 1
    grep '' "$out/joints_$landmarks/joints.csv"
  done
}

calm() {
  step python_cost "$python" bench/python_cost.py --build "$build" --rounds 7 --threads
  step python_cost_again "$python" bench/python_cost.py --build "$build" --rounds 7 --threads
  step python_cost_free_hand "$python" bench/python_cost.py --build "$build" --rounds 5 --pipeline pipelines/free_hand.toml
  local models=(models/dense.pt models/dense_scenes.pt "$out/regression.pt")
  step peers "$python" bench/peers/compare.py --build "$build" --models "${models[@]}"
  step peers_again "$python" bench/peers/compare_networks.py --build "$build" --rounds 5 "${models[@]}"
  touch "$out/calm.done"
}

debians() { for suite in bookworm trixie; do step "fresh_$suite" scripts/try_fresh_debian.sh "$suite" "$out/debian"; done; }

rest() {
  step million "$python" bench/python_cost.py --build "$build" --rounds 0 --pipeline pipelines/free_hand.toml --estimates 1000000
  step joints joints
  [ -z "$recordings" ] || step fine_tuning scripts/measure_fine_tuning.sh "$build" "$recordings" "$out/fine_tuning"
  step build_all build
  step onnx onnx
  step python_tests ctest --test-dir "$build" -R '^python/' --output-on-failure
}

step processor processor
step build build knuckle knuckle-train-network knuckle_python knuckle_frame_cost knuckle_network_peer knuckle_forest_peer knuckle_frame_dump
[ -e "$out/build.done" ] || exit 1
step regression regression
calm
debians &
rest
wait
echo "$(date +%T) done: $(find "$out" -maxdepth 1 -name '*.done' | wc -l) steps"
