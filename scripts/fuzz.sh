#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fuzzes every reader and parser, one after another, SECONDS each (default 60), and prints how often each was run.
#
#   scripts/fuzz.sh [SECONDS [TARGET...]]
#
# New inputs are kept in build/fuzz/corpus; an input that ends a target is kept in build/fuzz/findings, and the script ends
# with status 1. `build/fuzz/bin/knuckle_fuzz_replay fuzz/corpus TARGET FILE` shows it again.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
shift || true
targets=("$@")
[ ${#targets[@]} -gt 0 ] || mapfile -t targets < <(ls fuzz/corpus)

cmake --preset fuzz --log-level=WARNING >/dev/null
ninja -C build/fuzz "${targets[@]/#/fuzz_}" knuckle_fuzz_replay >/dev/null
mkdir -p build/fuzz/findings
# A library that asks for more than 1 GB at once, because a header says so, is told that there is no more; our own code that does ends
# the target.
export ASAN_OPTIONS=allocator_may_return_null=1:max_allocation_size_mb=1024
status=0
for target in "${targets[@]}"; do
  mkdir -p "build/fuzz/corpus/$target"
  log=build/fuzz/$target.log
  # 10 s are what a damaged file may cost at most.
  if ! "build/fuzz/bin/fuzz_$target" -max_total_time="$seconds" -rss_limit_mb=2048 -malloc_limit_mb=0 -timeout=10 \
      -max_len=65536 -detect_leaks=0 -print_final_stats=1 -artifact_prefix="build/fuzz/findings/${target}_" \
      "build/fuzz/corpus/$target" "fuzz/corpus/$target" >"$log" 2>&1; then
    status=1
    echo "$target: FOUND something, see $log"
  fi
  runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -1)
  echo "$target: ${runs:-no} executions"
done
exit $status
