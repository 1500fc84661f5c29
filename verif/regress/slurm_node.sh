#!/usr/bin/env bash
# A Slurm of one node, this machine, to try `triaxis regress run --launcher slurm` on.
#
#   verif/regress/slurm_node.sh start|stop|status
#
# Needs Debian's packages and root: apt-get install slurm-wlm munge. Installs nothing, and leaves
# /etc/slurm and /etc/munge alone: configuration, key, logs and state are in build/slurm, or in the folder that
# TRIAXIS_SLURM names. `start` waits until the node is idle, and prints the variable that tells Slurm's
# commands of it.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
folder=${TRIAXIS_SLURM:-$here/build/slurm}
# Sockets have short names, and munge wants a folder that nobody else may write to.
sockets=/run/triaxis-slurm
conf=$folder/slurm.conf
patience=300

fail() {
  echo "slurm_node: error: $*" >&2
  exit 2
}

check() {
  for tool in munged mungekey slurmctld slurmd sinfo; do
    command -v "$tool" >/dev/null || fail "$tool: not found: apt-get install slurm-wlm munge"
  done
  [ "$(id -u)" = 0 ] || fail "must be run as root: slurmd starts jobs as their users"
}

# What a daemon left in its pid file, where that process still is the daemon.
running() {
  local pid
  pid=$(cat "$sockets/$1.pid" 2>/dev/null) || return 1
  [ "$(cat "/proc/$pid/comm" 2>/dev/null)" = "$1" ] && echo "$pid"
}

configure() {
  local name memory
  name=$(hostname -s)
  memory=$(awk '/MemTotal/ {print int($2 / 1024 * 9 / 10)}' /proc/meminfo)
  mkdir -p "$folder/state" "$folder/spool"
  install -d -o munge -g munge -m 0755 "$sockets"
  install -d -o munge -g munge -m 0700 "$folder/munge"
  if [ ! -s "$folder/munge/key" ]; then
    mungekey --create --keyfile "$folder/munge/key"
    chown munge:munge "$folder/munge/key"
    chmod 0400 "$folder/munge/key"
  fi
  cat >"$conf" <<EOF
ClusterName=triaxis
SlurmctldHost=$name(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$sockets/munge.socket
CredType=cred/munge
SlurmctldPort=16817
SlurmdPort=16818
SlurmctldPidFile=$sockets/slurmctld.pid
SlurmdPidFile=$sockets/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
KillWait=5
NodeName=$name NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$memory State=UNKNOWN
PartitionName=regress Nodes=$name Default=YES MaxTime=INFINITE State=UP
EOF
}

# Wait until a command succeeds.
await() {
  local what=$1
  shift
  for _ in $(seq $((2 * patience))); do
    "$@" && return
    sleep 0.5
  done
  fail "$what within $patience s: see $folder/*.log"
}

# Whether the node takes jobs; one that has some is up too.
up() {
  [[ $(SLURM_CONF=$conf sinfo --noheader --format=%T 2>/dev/null) =~ ^(idle|mixed|allocated) ]]
}

start() {
  check
  if ! up; then
    stop
    configure
    # munged refuses a log file in a folder that others own; it has little to say.
    setpriv --reuid=munge --regid=munge --clear-groups munged --key-file="$folder/munge/key" \
      --socket="$sockets/munge.socket" --pid-file="$sockets/munged.pid" \
      --seed-file="$folder/munge/seed" --log-file="$folder/munge/munged.log" --force
    await "munged did not answer" test -S "$sockets/munge.socket"
    SLURM_CONF=$conf slurmctld
    SLURM_CONF=$conf slurmd -c
    await "the node did not become idle" up
  fi
  echo "Slurm is up, one node, partition regress. In your shell:"
  echo "export SLURM_CONF=$conf"
}

stop() {
  local name pid
  if running slurmctld >/dev/null; then
    SLURM_CONF=$conf scancel --quiet --partition=regress || true
    await "jobs did not end" idle
  fi
  for name in slurmd slurmctld munged; do
    if pid=$(running "$name"); then
      kill "$pid"
      await "$name did not end" ended "$pid"
    fi
  done
}

# Whether a process is gone, or waits to be reaped by whoever started it.
ended() {
  [[ ! -e /proc/$1/stat || $(<"/proc/$1/stat") =~ \)\ Z ]]
}

idle() {
  [ -z "$(SLURM_CONF=$conf squeue --noheader)" ]
}

status() {
  if up; then
    SLURM_CONF=$conf sinfo
  else
    echo "Slurm is not up" >&2
    exit 1
  fi
}

case ${1:-} in
  start | stop | status) "$1" ;;
  *) fail "usage: slurm_node.sh start|stop|status" ;;
esac
