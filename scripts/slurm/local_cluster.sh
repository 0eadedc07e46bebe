#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Slurm on this machine alone, to try jobs before a real cluster sees them (Debian's slurmctld, slurmd, slurm-client).
#
#   scripts/slurm/local_cluster.sh start FOLDER            starts it; everything it writes lies in FOLDER
#   scripts/slurm/local_cluster.sh stop FOLDER             ends it, with all its jobs
#   scripts/slurm/local_cluster.sh run FOLDER COMMAND ...  a cluster for one command; it ends with the command, however that ends
#   scripts/slurm/local_cluster.sh check                   whether this machine can have one; says why not
#
# Commands find it by `export SLURM_CONF=FOLDER/slurm.conf`. It lives in a process namespace of its own, with which its
# daemons and all jobs end, and listens on the loopback only. Needs root. There is no authentication: users of this machine
# may run jobs as others, so never leave it running on one that is shared.
set -euo pipefail

usage() { echo "usage: scripts/slurm/local_cluster.sh start FOLDER | stop FOLDER | run FOLDER COMMAND ... | check" >&2; exit 2; }
die() { echo "local_cluster.sh: $*" >&2; exit 1; }

PATH=$PATH:/usr/sbin
script=$(realpath "$0")

check() {
  local program fault
  for program in slurmctld slurmd sinfo unshare; do
    command -v "$program" >/dev/null || die "$program is missing"
  done
  [ "$(id -u)" -eq 0 ] || die "Slurm's daemons are started by root alone"
  fault=$(unshare --fork --pid --mount-proc --kill-child true 2>&1) || die "a namespace cannot be made here (a container without CAP_SYS_ADMIN?): $fault"
}

# Ports differ from folder to folder, so that several clusters do not meet; so do the numbers of jobs, from which the
# ports of trainings by several processes follow (20,000 to 29,999).
write_configuration() {
  local number port memory
  number=$(cksum <<<"$folder" | cut -d' ' -f1)
  port=$((14000 + number % 3000 * 2))
  memory=$(awk '/MemTotal/ { print int($2 / 1024 * 0.9) }' /proc/meminfo)
  mkdir -p "$folder/state" "$folder/spool"
  cat >"$SLURM_CONF" <<CONF
ClusterName=local
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
FirstJobId=$((1 + number % 1000003))
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
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
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$memory State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
}

is_up() { [ "$(sinfo --noheader --format=%T 2>/dev/null)" = "idle" ]; }

wait_until_up() {
  for _ in $(seq 100); do
    is_up && return
    [ $# -eq 0 ] || is_running "$1" || die "it ended at once; see $folder/cluster.log"
    sleep 0.2
  done
  die "the node does not come up; see $folder/slurmctld.log and $folder/slurmd.log"
}

# The first process of the namespace: when it ends, the kernel ends all others in it.
inside() {
  write_configuration
  slurmctld -D -f "$SLURM_CONF" -c >/dev/null 2>&1 </dev/null &
  slurmd -D -f "$SLURM_CONF" -c >/dev/null 2>&1 </dev/null &
  wait_until_up
  "$@"
}

run() {
  check
  exec unshare --fork --pid --mount-proc --kill-child "$script" inside "$folder" "$@"
}

# Whether the process $1 is a cluster of this folder, and not one that was given its number since.
is_running() { tr '\0' '\n' 2>/dev/null <"/proc/$1/cmdline" | grep -qxF "$folder"; } 2>/dev/null

start() {
  check
  mkdir -p "$folder"
  stop
  setsid "$script" run "$folder" sleep infinity >"$folder/cluster.log" 2>&1 </dev/null &
  echo $! >"$folder/cluster.pid"
  wait_until_up $!
  echo "export SLURM_CONF=$SLURM_CONF"
}

stop() {
  local outer inner
  outer=$(cat "$folder/cluster.pid" 2>/dev/null) || return 0
  is_running "$outer" || return 0
  inner=$(pgrep --parent "$outer") || inner=
  kill -KILL "${inner:-$outer}" 2>/dev/null || true
  while is_running "$outer"; do sleep 0.1; done  # it ends when all in the namespace have
  rm -f "$folder/cluster.pid"
}

[ $# -ge 1 ] || usage
verb=$1
if [ $# -ge 2 ]; then
  folder=$(realpath -m "$2")
  export SLURM_CONF=$folder/slurm.conf
fi
case "$verb $#" in
  "check 1") check ;;
  "start 2") start ;;
  "stop 2") stop ;;
  "run "[12] | "inside "[12]) usage ;;
  "run "* | "inside "*) "$verb" "${@:3}" ;;
  *) usage ;;
esac
