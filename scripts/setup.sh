#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs what Knuckle needs on Debian 12 or 13, and fetches the MakeHuman body.
#
#   scripts/setup.sh            everything: to build, test, check and train
#   scripts/setup.sh program    what the program alone is built from and runs with
#
# Does nothing where all is there already. Needs root (or sudo) only for packages that are missing.
set -euo pipefail
cd "$(dirname "$0")/.."

packages=(
  # tools
  g++ make cmake ninja-build pkg-config gnuplot-nox fonts-dejavu-core
  # libraries
  libeigen3-dev libopencv-core-dev libopencv-imgproc-dev libhdf5-dev libmatio-dev
  libopenexr-dev libpng-dev zlib1g-dev libdeflate-dev libbz2-dev liblz4-dev libzstd-dev libxxhash-dev libtomlplusplus-dev libcli11-dev libfmt-dev nlohmann-json3-dev libtbb-dev
  # the server of `live --view` (headers alone)
  libboost-dev
  # cameras, and recordings of OpenNI2
  libfreenect-dev libopenni2-dev
  # runs ONNX files
  libopencv-dnn-dev
)
development_packages=(
  ccache clang clang-format clang-tidy libclang-rt-dev doxygen git python3 python3-numpy python3-h5py
  python3-dev pybind11-dev
  libtorch-dev libopenblas0-pthread
  # headers that LibTorch's c10d includes: training by several processes
  libgloo-dev
  libgtest-dev libgmock-dev libbenchmark-dev
  # writes and reads PNG files beside us
  libopencv-imgcodecs-dev
  # write recordings that tests read
  libfreenect-bin ffmpeg
  # shows the page of `live` in its tests
  chromium
  # checks exported networks
  python3-onnx
  # a scheduler and a starter of jobs for their tests (6 MB to fetch)
  slurmctld slurmd slurm-client parallel
  # joins two name spaces by a cable, for the tests of trainings on two machines
  iproute2
  # what the notebooks use (examples/notebooks)
  python3-matplotlib python3-torch
)
case "${1:-}" in
  "") packages+=("${development_packages[@]}") ;;
  program) ;;
  *) echo "usage: scripts/setup.sh [program]" >&2; exit 2 ;;
esac
# npm comes with some machines' own Node.js; Debian's package is needed only where it does not.
command -v npm >/dev/null || packages+=(npm)

is_installed() { [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

# Some images bring a tool without its package.
has_command() {
  case "$1" in
    g++) command -v g++ ;;
    cmake) command -v cmake ;;
    make) command -v make ;;
    git) command -v git ;;
    ninja-build) command -v ninja ;;
    pkg-config) command -v pkg-config ;;
    python3) command -v python3 ;;
    *) return 1 ;;
  esac >/dev/null
}

missing=()
for package in "${packages[@]}"; do
  is_installed "$package" || has_command "$package" || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  if ! command -v apt-get >/dev/null; then
    echo "setup.sh: these packages are missing, and there is no apt-get to install them: ${missing[*]}" >&2
    exit 1
  fi
  as_root=()
  [ "$(id -u)" -eq 0 ] || as_root=(sudo)
  echo "Installing ${#missing[@]} packages: ${missing[*]}"
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"
fi

scripts/fetch_makehuman.sh
[ "${1:-}" = program ] || scripts/fetch_web_packages.sh
[ "${1:-}" = program ] || scripts/fetch_onnx_runtime.sh
