#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Run a command beside a real Slurm of one node that lives as long as the command: tools/slurm_node.sh FOLDER COMMAND [ARGUMENT ...]
# As root, after  apt-get install slurm-wlm munge.  FOLDER takes the node's state and logs. The node claims 16 cores, so that jobs for
# larger machines begin. Key, socket and ports are its own: another Slurm of the machine is not touched.
set -euo pipefail
work=$1
shift
node=$(hostname -s)
port=$((20000 + RANDOM % 20000))
mkdir -p "$work/state" "$work/spool"
work=$(realpath "$work")
dd if=/dev/urandom of="$work/munge.key" bs=128 count=1 2>/dev/null
chmod 400 "$work/munge.key"
munged --force --key-file="$work/munge.key" --socket="$work/munge.sock" --pid-file="$work/munge.pid" --seed-file="$work/munge.seed" \
  --log-file="$work/munge.log" 2>/dev/null
trap 'scontrol shutdown >/dev/null 2>&1 || true; kill "$(cat "$work/munge.pid")"' EXIT
cat > "$work/slurm.conf" <<CONF
ClusterName=proof
SlurmctldHost=$node
SlurmUser=root
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
AuthInfo=socket=$work/munge.sock
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmctldPidFile=$work/ctld.pid
SlurmdPidFile=$work/d.pid
SlurmctldLogFile=$work/ctld.log
SlurmdLogFile=$work/d.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
KillWait=20
NodeName=$node CPUs=16 RealMemory=8192 State=UNKNOWN
PartitionName=all Nodes=$node Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$work/slurm.conf
slurmctld
slurmd
for n in $(seq 100); do
  sinfo -h -o %t 2>/dev/null | grep -q idle && break
  if [ "$n" -eq 100 ]; then
    cat "$work/ctld.log" "$work/d.log" >&2
    exit 1
  fi
  sleep 0.1
done
"$@"
