#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the Python package in a fresh Debian, as docs/python.md says, and runs there what shows that it works: notebooks, the
# program's poses to the last bit, arrays, estimators of one's own.
#
#   scripts/try_fresh_debian.sh SUITE FOLDER     SUITE is bookworm (12) or trixie (13)
#
# Needs root and debootstrap. FOLDER/SUITE is made where it is not there (1.5 GB, minutes), and only the committed state is tried.
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# = 2 ] || { echo "usage: scripts/try_fresh_debian.sh SUITE FOLDER" >&2; exit 2; }
# What is mounted below is seen by this script alone, and goes with it however it ends.
[ -n "${KNUCKLE_OWN_MOUNTS:-}" ] || exec env KNUCKLE_OWN_MOUNTS=1 unshare --mount scripts/try_fresh_debian.sh "$@"
suite=$1
mkdir -p "$2"
root=$(cd "$2" && pwd)/$suite

if [ ! -e "$root/.whole" ]; then
  rm -rf --one-file-system "$root"
  debootstrap --variant=minbase --include=ca-certificates,git "$suite" "$root"
  touch "$root/.whole"
fi

# debootstrap has made the few devices that are needed; this machine's own /dev stays out of reach.
mount -t proc proc "$root/proc"
mkdir -p "$root/dev/shm"
mount -t tmpfs tmpfs "$root/dev/shm"
# How this machine reaches the network, and where it fetches packages.
for file in etc/resolv.conf etc/npmrc root/.npmrc; do
  if [ -r "/$file" ]; then cp "/$file" "$root/$file"; fi
done
# Whom it trusts beyond Debian's list, such as a proxy between.
if [ -d /usr/local/share/ca-certificates ]; then
  cp -r /usr/local/share/ca-certificates "$root/usr/local/share/"
  chroot "$root" update-ca-certificates
fi

rm -rf "$root/root/knuckle" "$root/root/environment"
git clone --quiet . "$root/root/knuckle"
chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
  PYTHONDONTWRITEBYTECODE=1 /bin/bash -euo pipefail -c '
  cd /root/knuckle
  scripts/setup.sh program
  apt-get install -y -q --no-install-recommends python3-dev python3-venv pybind11-dev python3-numpy python3-h5py \
    python3-matplotlib python3-torch
  python3 -m venv --system-site-packages /root/environment
  /root/environment/bin/pip install --no-index .
  cmake --preset program --log-level=WARNING
  cmake --build --preset program
  for test in notebooks same_as_program arrays estimators; do
    KNUCKLE_PROGRAM="$PWD/build/release/bin/knuckle" /root/environment/bin/python "python/tests/${test}_test.py"
  done'
echo "$suite: installed by pip in a fresh Debian, and its tests pass"
