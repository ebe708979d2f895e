#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Run a command beside a real Slurm that lives as long as the command: [NODES=N] tools/slurm_node.sh FOLDER COMMAND [ARGUMENT ...]
# As root, after  apt-get install slurm-wlm munge.  FOLDER takes state and logs. Each node, n1 to nN, is a slurmd of this machine that
# claims 32 cores, so that jobs for larger machines run side by side. Key, socket and ports are its own: another Slurm of the machine is not
# touched.
set -euo pipefail
work=$1
shift
nodes=${NODES:-1}
node=$(hostname -s)
port=$((20000 + RANDOM % 20000))
mkdir -p "$work/state" "$work/spool"
work=$(realpath "$work")
dd if=/dev/urandom of="$work/munge.key" bs=128 count=1 2>/dev/null
chmod 400 "$work/munge.key"
munged --force --key-file="$work/munge.key" --socket="$work/munge.sock" --pid-file="$work/munge.pid" --seed-file="$work/munge.seed" \
  --log-file="$work/munge.log" 2>/dev/null
trap 'scontrol shutdown >/dev/null 2>&1 || true; kill $(cat "$work"/*.pid 2>/dev/null) 2>/dev/null || true' EXIT
cat > "$work/slurm.conf" <<CONF
ClusterName=proof
SlurmctldHost=$node
SlurmUser=root
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool/%n
AuthInfo=socket=$work/munge.sock,cred_expire=10
SlurmctldPort=$port
SlurmctldPidFile=$work/ctld.pid
SlurmdPidFile=$work/%n.pid
SlurmctldLogFile=$work/ctld.log
SlurmdLogFile=$work/%n.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SchedulerParameters=batch_sched_delay=0
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
KillWait=20
NodeName=n[1-$nodes] NodeHostname=$node Port=[$((port + 1))-$((port + nodes))] CPUs=32 RealMemory=16384 State=UNKNOWN
PartitionName=all Nodes=n[1-$nodes] Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$work/slurm.conf
slurmctld
for i in $(seq "$nodes"); do slurmd -N "n$i"; done
for n in $(seq 100); do
  [ "$(sinfo -h -N -t idle -o %N 2>/dev/null | wc -l)" -eq "$nodes" ] && break
  if [ "$n" -eq 100 ]; then
    cat "$work"/*.log >&2
    exit 1
  fi
  sleep 0.1
done
"$@"
