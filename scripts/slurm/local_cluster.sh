#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Slurm on this machine alone, to try jobs before a real cluster sees them (Debian's slurmctld, slurmd, slurm-client).
#
#   scripts/slurm/local_cluster.sh start FOLDER   starts it; everything it writes lies in FOLDER
#   scripts/slurm/local_cluster.sh stop FOLDER    ends it, with all its jobs
#
# Commands find it by `export SLURM_CONF=FOLDER/slurm.conf`. Needs root. There is no authentication: users of this machine
# may run jobs as others, so never leave it running on one that is shared.
set -euo pipefail

usage() { echo "usage: scripts/slurm/local_cluster.sh start|stop FOLDER" >&2; exit 2; }
[ $# -eq 2 ] || usage
folder=$(realpath -m "$2")
export SLURM_CONF=$folder/slurm.conf

is_up() { [ "$(sinfo --noheader --format=%T 2>/dev/null)" = "idle" ]; }

start() {
  for program in slurmctld slurmd sinfo; do
    command -v "$program" >/dev/null || { echo "local_cluster.sh: $program is missing" >&2; exit 1; }
  done
  mkdir -p "$folder/state" "$folder/spool"
  local cores memory
  cores=$(nproc)
  memory=$(awk '/MemTotal/ { print int($2 / 1024 * 0.9) }' /proc/meminfo)
  cat >"$SLURM_CONF" <<CONF
ClusterName=local
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
SlurmUser=root
SlurmdUser=root
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
ReturnToService=2
KillWait=5
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=$cores RealMemory=$memory State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
  slurmctld -f "$SLURM_CONF" -c
  slurmd -f "$SLURM_CONF" -c
  for _ in $(seq 100); do
    is_up && { echo "export SLURM_CONF=$SLURM_CONF"; return; }
    sleep 0.2
  done
  echo "local_cluster.sh: the node does not come up; see $folder/slurmctld.log and $folder/slurmd.log" >&2
  exit 1
}

stop() {
  scancel --full --signal=KILL --user="$(id -un)" 2>/dev/null || true
  for daemon in slurmd slurmctld; do
    [ -s "$folder/$daemon.pid" ] && kill "$(cat "$folder/$daemon.pid")" 2>/dev/null || true
  done
  for _ in $(seq 50); do
    pgrep -f "$SLURM_CONF" >/dev/null || return 0
    sleep 0.2
  done
  pkill -KILL -f "$SLURM_CONF" || true
}

case "$1" in
  start) start ;;
  stop) stop ;;
  *) usage ;;
esac
